"""Programs of any number of rules, of the kind that tools write."""


def each(first, rules, count):
    """The first declaration, and what rules(1), rules(2), ... say, of `count` predicates in all."""
    return first + "".join(rules(i) for i in range(1, count))


def linked(predicates):
    """Each predicate follows from the one before at a catom, and from itself over links: two rules each."""
    return each("type p0(node, int).\np0(A, N) :- neighborCount(A, N).\n",
                lambda i: f"type p{i}(node, int).\np{i}(A, X + {i}) :- p{i - 1}(A, X), X < {i * i + 10}.\n"
                          f"p{i}(A, Y) :- neighbor(A, B), p{i}(B, Y), Y > {i}.\n", predicates)


def chain(predicates):
    """Sets without links, one rule each."""
    return each("type p0(node, int).\np0(A, N) :- neighborCount(A, N).\n",
                lambda i: f"type p{i}(node, int).\np{i}(A, X + 1) :- p{i - 1}(A, X), X < {i + 10}.\n", predicates)


def aggregates(predicates):
    """Sums, least and greatest values by turns, over links."""
    kinds = ("min", "max", "sum", "count")
    return each("type v0(node, int).\nv0(A, N) :- neighborCount(A, N).\n",
                lambda i: f"type v{i}(node, {kinds[i % 4]} int).\nv{i}(A, X % {i + 5}) :- v{i - 1}(A, X).\n"
                          f"v{i}(A, X % {i + 7} + 1) :- neighbor(A, B), v{i - 1}(B, X).\n", predicates)


def linear(predicates):
    """Tokens that become others, and are sent on."""
    return each("type linear t0(node, int).\n" + "".join(f"t0(@{i}, {7 * i}).\n" for i in range(16)),
                lambda i: f"type linear t{i}(node, int).\nt{i - 1}(A, X), X > {i} -o t{i}(A, X - 1).\n"
                          f"t{i - 1}(A, X), X <= {i}, neighbor(A, B) -o t{i}(B, X + 2).\n", predicates)


def one_predicate(rules):
    """Many rules of one predicate."""
    return each("type n(node, int).\nn(A, N) :- neighborCount(A, N).\ntype q(node, int).\n",
                lambda i: f"q(A, X + {i - 1}) :- n(A, X), X > {(i - 1) % 7}.\n", rules + 1)


KINDS = {"linked": linked, "chain": chain, "aggregates": aggregates, "linear": linear, "one_predicate": one_predicate}
