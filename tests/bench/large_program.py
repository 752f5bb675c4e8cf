"""Programs of any number of rules, of the kind that tools write."""


def linked(predicates):
    """Each predicate follows from the one before at a catom, and from itself over links: two rules each."""
    text = ["type p0(node, int).\np0(A, N) :- neighborCount(A, N).\n"]
    for i in range(1, predicates):
        text.append(f"type p{i}(node, int).\np{i}(A, X + {i}) :- p{i - 1}(A, X), X < {i * i + 10}.\n"
                    f"p{i}(A, Y) :- neighbor(A, B), p{i}(B, Y), Y > {i}.\n")
    return "".join(text)


def chain(predicates):
    """Sets without links, one rule each."""
    return "type p0(node, int).\np0(A, N) :- neighborCount(A, N).\n" + "".join(
        f"type p{i}(node, int).\np{i}(A, X + 1) :- p{i - 1}(A, X), X < {i + 10}.\n" for i in range(1, predicates))


def aggregates(predicates):
    """Sums, least and greatest values by turns, over links."""
    kinds = ("min", "max", "sum", "count")
    text = ["type v0(node, int).\nv0(A, N) :- neighborCount(A, N).\n"]
    for i in range(1, predicates):
        text.append(f"type v{i}(node, {kinds[i % 4]} int).\nv{i}(A, X % {i + 5}) :- v{i - 1}(A, X).\n"
                    f"v{i}(A, X % {i + 7} + 1) :- neighbor(A, B), v{i - 1}(B, X).\n")
    return "".join(text)


def linear(predicates):
    """Tokens that become others, and are sent on."""
    text = ["type linear t0(node, int).\n" + "".join(f"t0(@{i}, {7 * i}).\n" for i in range(16))]
    for i in range(1, predicates):
        text.append(f"type linear t{i}(node, int).\nt{i - 1}(A, X), X > {i} -o t{i}(A, X - 1).\n"
                    f"t{i - 1}(A, X), X <= {i}, neighbor(A, B) -o t{i}(B, X + 2).\n")
    return "".join(text)


def one_predicate(rules):
    """Many rules of one predicate."""
    return "type n(node, int).\nn(A, N) :- neighborCount(A, N).\ntype q(node, int).\n" + "".join(
        f"q(A, X + {i}) :- n(A, X), X > {i % 7}.\n" for i in range(rules))


KINDS = {"linked": linked, "chain": chain, "aggregates": aggregates, "linear": linear, "one_predicate": one_predicate}
