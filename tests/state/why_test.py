"""`why` and `why-not`: every part of every answer is checked against the facts that runs to the named ticks write, and by queries.
Answers about random programs are judged by the reference evaluator: `test_random --why`.

    why_test.py --meldc PATH --meldsim PATH [unittest options]
"""
import json
import random
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests"))

from frame import Case, main  # noqa: E402

GRADIENT = """type source(node).
type dist(node, min int).
type nearby(node, int, count int).
type far(node).
dist(A, 0)     :- source(A).
dist(B, D + 1) :- neighbor(A, B), dist(A, D).
nearby(A, D, B) :- neighbor(A, B), dist(B, D).
far(A) :- dist(A, D), D > 2, not source(A), neighbor(A, B), not source(B).
"""
TREE = """type root(node).
type parent(node, min int, node).
type reach(node, node).
type size(node, sum int).
type heavy(node, int).
parent(A, 0, A)     :- root(A).
parent(B, D + 1, A) :- neighbor(A, B), parent(A, D, _).
reach(A, A)         :- root(A).
reach(B, R)         :- neighbor(A, B), reach(A, R).
size(A, 1)          :- parent(A, _, _).
size(A, N)          :- neighbor(A, B), parent(B, _, A), size(B, N), A <> B.
heavy(A, N)         :- size(A, N), N > 2, root(A).
"""
LEADER = """type candidate(node).
type best(node, max int).
type leader(node).
type known(node, int).
type two(node, int).
candidate(A).
best(A, node2int(A)) :- candidate(A).
best(B, X)           :- neighbor(A, B), best(A, X).
leader(A)            :- best(A, X), X = node2int(A).
known(A, X)          :- neighbor(A, B), neighbor(B, C), best(C, X), C <> A.
two(A, N)            :- candidate(A), N = count : { neighbor(A, B), best(B, _) }.
"""
LOCAL = """type a(node, int).
type up(node, int).
type chain(node, int, int).
chain(A, X, X + 1) :- a(A, X).
chain(A, X, Z) :- chain(A, X, Y), chain(A, Y, Z).
up(A, X) :- a(A, X).
up(A, X) :- chain(A, Y, X), up(A, Y).
"""


def world(side, given, events, more=""):
    """A square with facts, and events that change them: (tick, "give" or "take", predicate, catom)."""
    text = f'lattice = "square"\n{more}[[body]]\nshape = "box({side}, {side}, 1)"\n'
    if given:
        text += "[facts]\n" + "".join(f"{p} = {v}\n" for p, v in given.items())
    for tick, change, predicate, catom in events:
        text += f'[[event]]\ntick = {tick}\n{change} = {{ {predicate} = "id == {catom}" }}\n'
    return text


# Programs, their worlds and ticks.
CASES = {
    "gradient": (GRADIENT, world(4, {"source": '"id == 0"'}, [(9, "take", "source", 0), (11, "give", "source", 13)]), 30),
    "tree": (TREE, world(3, {"root": '"id == 0"'}, [(8, "give", "root", 7), (12, "take", "root", 0)]), 26),
    "leader": (LEADER, world(3, {}, []), 12),
    "local": (LOCAL, world(2, {"a": '[{ where = "id < 2", args = [1] }, { args = [2] }, { args = [3] }]'}, []), 6),
}


# Where a rule of a recursion asks for a value beyond a bound, a fact may be found to rest on one of its own rank; then it says so.
UNRANKED = "ranks do not say here what rests on what"


class Why(Case):
    def ask(self, program, where, commands, processes=1):
        out, _ = self.call("meldsim", "debug", program, "--world", where, "--json", "--quiet", "-n", processes, "--commands", "-",
                           stdin=None, input="".join(c + "\n" for c in commands).encode())
        return [json.loads(line) for line in out.splitlines()]

    def states(self, program, where, last):
        """The facts of every tick."""
        states = {}
        for moved, found in zip(*[iter(self.ask(program, where, [c for t in range(last + 1) for c in (f"to {t}", "facts")]))] * 2):
            if "error" in moved:
                break
            states[moved["tick"]] = {f.removesuffix(".") for f in found["facts"]}
        return states

    def check_why(self, answer, fact, states, context):
        """Everything that it names holds where it says, ranks fall, and it ends with what is given."""
        self.assertTrue(answer["roots"], context)
        nodes = answer["nodes"]
        self.assertEqual(nodes[answer["roots"][0]]["fact"], fact, context)
        unranked = any(UNRANKED in node.get("note", "") for node in nodes)
        for i, node in enumerate(nodes):
            about = f"{context}: node {i} {node}"
            name = node["fact"].split("(")[0]
            # What is stable is a predicate of the compiler's; so is a value that a better one has replaced, until nothing rests on it.
            if node["is"] != "sensed" and not name == "stable" and "replaced" not in node.get("note", ""):
                there = any(f.startswith(node["fact"].split("_")[0]) for f in states[node["tick"]])
                self.assertTrue(there if "_" in node["fact"] else node["fact"] in states[node["tick"]], about)
            self.assertIn(node["is"], ("given", "sensed", "derived", "combined", "made"), about)
            if not unranked:
                self.assertNotIn("itself", node.get("note", ""), about)
            self.assertLessEqual(node["tick"], answer["tick"])
            if node["is"] in ("derived", "combined"):
                self.assertTrue(node["ways"], about)
            for way in node["ways"]:
                for part in way["parts"]:
                    self.assertIn(part["is"], ("fact", "absent", "condition"), about)
                    below = nodes[part["node"]] if "node" in part else {}
                    # Whether a group has a value is a recursion of its own, with its own ranks.
                    alike = below.get("fact", "").split("(")[0] == name and ("_" in node["fact"]) == ("_" in below["fact"])
                    if "rank" in node and "rank" in below and UNRANKED not in node.get("note", "") and alike:
                        self.assertLess(below["rank"], node["rank"], about)
        if not unranked:
            self.check_finite(answer, context)

    def check_finite(self, answer, context):
        nodes, done = answer["nodes"], set()
        for root in answer["roots"]:
            path, todo = [], [(root, False)]
            while todo:
                node, leaves = todo.pop()
                if leaves:
                    path.pop()
                    done.add(node)
                    continue
                self.assertNotIn(node, path, context)
                if node in done:
                    continue
                path.append(node)
                todo.append((node, True))
                todo += [(p["node"], False) for w in nodes[node]["ways"] for p in w["parts"] if "node" in p]

    def check_parts(self, program, where, answers, context):
        """What they say is absent, fails or holds is so, as queries tell."""
        asked, commands = [], []
        for answer in answers:
            for node in answer["nodes"]:
                for way in node["ways"]:
                    for part in way["parts"]:
                        # Conditions of aggregates name what is in them; a variable that nothing binds stands for any value.
                        if part["is"] == "condition" or re.search(r"\{|stable|@\d{9}", part["text"]):
                            continue
                        if part["is"] == "fact" and "node" in part:
                            continue
                        asked.append((part.get("tick", node["tick"]), part, node))
        for tick, part, _ in asked:
            commands += [f"to {tick}", f"query {part['text']}"]
        found = self.ask(program, where, commands) if commands else []
        for (tick, part, node), answer in zip(asked, found[1::2]):
            about = f"{context} in tick {tick}: {part} of {node}: {answer}"
            self.assertNotIn("error", answer, about)
            if part["is"] in ("fails", "absent"):
                self.assertEqual(answer["count"], 0, about)
            elif "node" not in part:
                self.assertGreater(answer["count"], 0, about)

    def missing_like(self, fact, rng, catoms):
        """A fact that may not hold: another value, or another catom."""
        name, arguments = re.fullmatch(r"(\w+)\((.*)\)", fact).groups()
        if re.search(r'[(\["]', arguments):
            return fact
        parts = arguments.split(", ")
        if rng.random() < 0.5 or len(parts) == 1:
            parts[0] = f"@{rng.randrange(catoms)}"
        else:
            at = rng.randrange(1, len(parts))
            if re.fullmatch(r"-?\d+", parts[at]):
                parts[at] = str(int(parts[at]) + rng.choice((-2, -1, 1, 3)))
            elif parts[at].startswith("@"):
                parts[at] = f"@{rng.randrange(catoms)}"
        return f"{name}({', '.join(parts)})"

    def examine(self, context, program, where, last, catoms, samples, processes=1, seed=0):
        rng = random.Random(f"{context} {seed}")
        states = self.states(program, where, last)
        ticks = sorted(t for t in states if states[t])
        commands, plan = [], []
        for tick in sorted(rng.choices(ticks, k=samples)):
            # Values that nobody has written, as those of `exists`, cannot be written either.
            written = sorted(f for f in states[tick] if not re.search(r"@\d{9}|\{", f))
            if not written:
                continue
            fact = rng.choice(written)
            other = self.missing_like(rng.choice(written), rng, catoms)
            commands += [f"to {tick}", f"why --depth 0 {fact}"]
            plan.append((tick, fact, True))
            if not any(f == other for f in states[tick]):
                commands += [f"to {tick}", f"why-not {other}"]
                plan.append((tick, other, False))
        answers = self.ask(program, where, commands, processes)[1::2]
        self.assertEqual(len(answers), len(plan))
        for (tick, fact, holds), answer in zip(plan, answers):
            about = f"{context}: {fact} in tick {tick}"
            self.assertNotIn("error", answer, about)
            self.assertEqual(answer["tick"], tick)
            if holds:
                self.check_why(answer, fact, states, about)
            else:
                self.assertTrue(answer["roots"], about)
        self.check_parts(program, where, answers, context)
        return answers


class Fixed(Why):
    def test_every_part_of_every_answer(self):
        for name, (program, where, last) in CASES.items():
            self.write(f"{name}.meld", program)
            self.write(f"{name}.toml", where)
            processes = 3 if name in ("gradient", "tree") else 1
            with self.subTest(program=name, processes=processes):
                self.examine(name, f"{name}.meld", f"{name}.toml", last, 9, 25, processes)

    def test_answers_do_not_depend_on_processes(self):
        program, where, _ = CASES["gradient"]
        self.write("p.meld", program)
        self.write("p.toml", where)
        commands = ["to 10", "why --depth 0 --all dist(_, _)", "why-not dist(@3, 1)", "why nearby(@5, _, _)", "run", "why --all far(_)"]
        answers = [self.ask("p.meld", "p.toml", commands, processes) for processes in (1, 2, 4)]
        self.assertEqual(answers[1:], answers[:1] * 2)
        self.assertGreater(len(answers[0][1]["nodes"]), 9)

    def test_of_a_fact_that_rests_on_the_tick_before(self):
        """While a source is gone and values fall, what a value rests on has left already."""
        program, where, _ = CASES["gradient"]
        self.write("p.meld", program)
        self.write("p.toml", where)
        commands = [c for t in range(9, 14) for c in (f"to {t}", "why --depth 0 --all dist(_, _)")]
        nodes = [n for answer in self.ask("p.meld", "p.toml", commands)[1::2] for n in answer["nodes"]]
        self.assertTrue(any(n["tick"] == 8 and n["is"] == "given" for n in nodes), nodes)
        self.assertFalse([n for n in nodes if n["is"] == "unknown"])

    def test_before_a_checkpoint_nothing_is_known(self):
        program, where, _ = CASES["gradient"]
        self.write("p.meld", program)
        self.write("p.toml", where)
        self.call("meldsim", "run", "p.meld", "--world", "p.toml", "--ticks", "10", "--quiet", "--checkpoint", "kept")
        out, _ = self.call("meldsim", "why", "kept", "dist(_, 2)", "--json", "--quiet")
        root = json.loads(out)["nodes"][0]
        self.assertEqual(root["is"], "unknown")
        self.assertIn("nothing is known of ticks before 10", root["note"])
        # The whole run tells.
        whole = self.ask("p.meld", "p.toml", ["to 10", f"why --depth 0 {root['fact']}"])[1]
        self.assertEqual(whole["nodes"][0]["is"], "derived")
        self.assertIn("dist", {n["fact"].split("(")[0] for n in whole["nodes"] if n["tick"] == 9})

    def test_where_existence_is_kept_apart_from_values(self):
        """A least value that a rule bounds rests on the existence of others, whatever their values: these have ranks of their own."""
        self.write("p.meld", "type i(node, min float, node).\ntype go(node).\ni(A, 8.0, A) :- go(A).\n"
                             "i(A, min(D, 3.0), B) :- i(B, D, _), neighbor(B, A).\ni(A, D + 2.0, B) :- i(B, D, _), neighbor(B, A).\n")
        self.write("p.toml", world(3, {"go": '"id == 0"'}, []))
        answers = self.ask("p.meld", "p.toml", ["run", *(f"why --depth 0 i(@{c}, _, _)" for c in range(9))])[1:]
        states = self.states("p.meld", "p.toml", 20)
        last = max(states)
        for answer in answers:
            self.check_why(answer, answer["nodes"][0]["fact"], {**states, answer["tick"]: states[last]}, str(answer))
            self.assertNotIn(UNRANKED, str(answer))
            self.assertTrue(any(n["fact"].endswith("_, _)") for n in answer["nodes"]), answer)

    def test_linear_facts(self):
        self.write("p.meld", "type linear go(node, int).\ntype seen(node).\ngo(@0, 3).\n"
                             "go(A, N), N > 0 -o seen(A), {B | neighbor(A, B), not seen(B) | go(B, N - 1)}.\n")
        self.write("p.toml", world(3, {}, []))
        state = self.states("p.meld", "p.toml", 6)
        came = min(t for t in state if "seen(@3)" in state[t])
        _, why = self.ask("p.meld", "p.toml", ["run", "why seen(@3)"])
        node = why["nodes"][0]
        self.assertEqual(node["is"], "made")
        self.assertIn(f"made in tick {came}", node["note"])
        for way in node["ways"]:
            self.assertIn("go(@3, ", way["parts"][0]["text"])
            self.assertIn(way["parts"][0]["text"], state[way["parts"][0]["tick"]])
        self.assertTrue(node["ways"])
        _, told = self.ask("p.meld", "p.toml", ["run", "history go(@3, _)"])
        for tick in told["ticks"]:
            for fact in tick["came"]:
                self.assertIn(fact, state[tick["tick"]])
                self.assertNotIn(fact, state[tick["tick"] - 1])
            for fact in tick["went"]:
                self.assertNotIn(fact, state[tick["tick"]])
        self.assertTrue(told["ticks"])

    def test_given_once(self):
        self.write("p.meld", "type linear a(node, int).\ntype b(node, int).\na(@0, 3).\na(A, X) -o b(A, X).\n")
        self.write("p.toml", world(2, {}, []))
        _, given, elsewhere = self.ask("p.meld", "p.toml", ["run", "why-not a(@0, 3)", "why-not a(@1, 3)"])
        (way,) = [w for w in given["nodes"][0]["ways"] if "text" in w]
        self.assertEqual(way["note"], "it is given once, in the first tick")
        (way,) = [w for w in elsewhere["nodes"][0]["ways"] if "text" in w]
        self.assertEqual([p["is"] for p in way["parts"]], ["fails"])

    PAIR = 'lattice = "square"\n[[body]]\nshape = "box(2, 1, 1)"\n'
    HEADS = """type linear start(node).
type linear c(node, int).
type v(node, int).
type odd(node).
type even(node).
type next(node, int).
type total(node, int).
v(A, 3).
v(A, 5).
start(@0).
start(A) -o {B | neighbor(A, B) | c(B, 4)}.
c(A, X) -o (if X % 2 = 0 then even(A) otherwise odd(A) end), N = X + 1, next(A, N),
    [sum => S | V | v(A, V), S = V | | total(A, S)].
"""

    def test_what_conditions_and_names_of_heads_say(self):
        self.write("p.meld", self.HEADS)
        self.write("p.toml", self.PAIR)
        facts = ("even(@1)", "odd(@1)", "next(@1, 7)", "total(@1, 1)")
        _, *found = self.ask("p.meld", "p.toml", ["to 1", *(f"why-not {f}" for f in facts)])
        ways = [answer["nodes"][0]["ways"][0] for answer in found]
        self.assertIn("it fires in the next tick", ways[0]["note"])
        for way, says in ((ways[1], "4 % 2"), (ways[2], "4 + 1")):
            self.assertTrue(any(p["is"] == "fails" and says in p["text"] for p in way["parts"]), way)
        self.assertIn("were not checked", ways[3]["note"])

    # A body, and whether one fact meets it.
    BODIES = (("n(A, X), n(A, Y)", False), ("n(A, X), $n(A, Y)", False), ("$n(A, X), n(A, Y)", False), ("go(A), $n(A, X), $n(A, Y)", True))

    def test_what_a_rule_consumes_no_other_atom_matches(self):
        self.write("p.toml", self.PAIR)
        for body, one_is_enough in self.BODIES:
            for count in (1, 2):
                sent = ", ".join(["go(B)"] + ["n(B, 4)"] * count)
                self.write("p.meld", "type linear start(node).\ntype linear go(node).\ntype linear n(node, int).\ntype big(node, int).\n"
                           f"start(@0).\nstart(A) -o {{B | neighbor(A, B) | {sent}}}.\n{body} -o big(A, X + Y).\n"
                           "n(A, X), go(A) -o big(A, X + X).\n")
                with self.subTest(body=body, count=count):
                    fires = one_is_enough or count == 2
                    _, absent, _, made = self.ask("p.meld", "p.toml", ["to 1", "why-not big(@1, 8)", "to 2", "why big(@1, 8)"])
                    note = "it fires in the next tick" if fires else "by one fact twice"
                    self.assertIn(note, absent["nodes"][0]["ways"][0]["note"])
                    lines = [way["line"] for way in made["nodes"][0]["ways"]]
                    self.assertEqual(fires, 7 in lines)
                    self.assertTrue(lines)

    def test_a_rule_that_waits_is_no_reason_while_another_is(self):
        self.write("p.meld", "type far(node, int).\nfar(B, node2int(A))@+3 :- neighbor(A, B).\nfar(B, node2int(A)) :- neighbor(A, B).\n")
        self.write("p.toml", self.PAIR)
        for options in ([], ["--all"]):
            out, _ = self.call("meldsim", "why", "p.meld", "far(@1, 0)", "--world", "p.toml", "--tick", 1, "--json", *options)
            ways = json.loads(out)["nodes"][0]["ways"]
            self.assertEqual([way["line"] for way in ways], [3])

    def test_what_still_waits_is_not_combined(self):
        self.write("p.meld", "type total(node, sum int).\ntotal(A, 1)@+2 :- id(A, _).\ntotal(A, 1)@+4 :- id(A, _).\n")
        self.write("p.toml", self.PAIR)
        for tick, total, lines in ((3, 1, [2]), (4, 1, [2]), (5, 2, [2, 3])):
            out, _ = self.call("meldsim", "why", "p.meld", f"total(@1, {total})", "--world", "p.toml", "--tick", tick, "--json")
            ways = json.loads(out)["nodes"][0]["ways"]
            self.assertEqual([(way["line"], way["note"]) for way in ways], [(line, "gives total(@1, 1)") for line in lines])

    def test_what_is_computed_may_change_while_it_waits(self):
        """The number of facts changes in ticks 4 and 6: `given(A, 1)` stays one derivation, and another fact of `next` is another."""
        self.write("p.meld", """type given(node, int).
type next(node, int).
type held(node, count int).
type renewed(node, count int).
given(A, 0). given(A, 1).
given(A, 2) :- tick(A, T), T > 3.
given(A, 3) :- tick(A, T), T > 5.
next(A, 3). next(A, 4). next(A, 5).
held(A, N)@+5    :- given(A, 1), N = count : { given(A, _) }, N > 1.
renewed(A, N)@+5 :- N = count : { given(A, _) }, next(A, N + 1).
""")
        self.write("p.toml", self.PAIR)
        for fact, tick, note in (("held(@0, 1)", 6, "gives held(@0, 4)"), ("renewed(@0, 1)", 11, "gives renewed(@0, 4)")):
            self.call("meldsim", "query", "p.meld", fact, "--world", "p.toml", "--tick", tick - 1, code=1)
            out, _ = self.call("meldsim", "why", "p.meld", fact, "--world", "p.toml", "--tick", tick, "--json")
            self.assertEqual([way["note"] for way in json.loads(out)["nodes"][0]["ways"]], [note])

    def test_an_element_that_waits_is_known_by_its_place(self):
        """6 comes between 5 and 7 in tick 6."""
        self.write("p.meld", "type given(node, int).\ntype later(node, sum int).\ngiven(A, 5). given(A, 7).\n"
                             "given(A, 6) :- tick(A, T), T > 5.\nlater(A, X)@+3 :- L = collect G : { given(A, G) }, X in L.\n")
        self.write("p.toml", self.PAIR)
        for tick, total, values in ((5, 12, (5, 7)), (6, 5, (5,)), (9, 18, (5, 6, 7))):
            out, _ = self.call("meldsim", "why", "p.meld", f"later(@0, {total})", "--world", "p.toml", "--tick", tick, "--json")
            notes = [way["note"] for way in json.loads(out)["nodes"][0]["ways"]]
            self.assertEqual(notes, [f"gives later(@0, {value})" for value in values])

    def test_one_firing_is_one_way_by_whichever_head(self):
        self.write("p.meld", "type linear a(node, int).\ntype linear b(node, int).\ntype linear start(node).\nstart(@0).\n"
                             "start(A) -o { B | !neighbor(A, B) | a(B, 7) }.\na(A, X) -o b(A, X), if X > 2 then b(A, X) end.\n")
        self.write("p.toml", self.PAIR)
        out, _ = self.call("meldsim", "why", "p.meld", "b(@1, 7)", "--world", "p.toml", "--tick", 2, "--json")
        node = json.loads(out)["nodes"][0]
        self.assertEqual(node["note"], "made in tick 2")
        self.assertEqual([[part["text"] for part in way["parts"]] for way in node["ways"]], [["a(@1, 7)"]])

    def test_a_group_that_waits_for_its_value(self):
        """@7 loses the value of @8 in tick 20. That @6 has one is known by one step, and its value of @0 by six, so it waits longer."""
        self.write("p.meld", """type src(node, int).
type top(node).
type v(node, max int).
type ok(node).
ok(A) :- v(A, _).
v(A, D) :- src(A, D).
v(A, D) :- neighbor(B, A), top(B), D = 9.
v(A, D) :- neighbor(B, A), id(A, X), id(B, X - 1), v(B, D), ok(B).
src(@0, 5).
src(@6, 1).
""")
        self.write("p.toml", 'lattice = "square"\n[[body]]\nshape = "box(9, 1, 1)"\n'
                             '[[event]]\ntick = 1\ngive = { top = { where = "id == 8" } }\n'
                             '[[event]]\ntick = 20\ntake = { top = { where = "id == 8" } }\n')
        self.call("meldsim", "query", "p.meld", "v(@7, _)", "--world", "p.toml", "--tick", 29, code=1)
        for tick, note in ((29, "it has a value, and which one still waits for a quarantine"), (30, "")):
            out, _ = self.call("meldsim", "why", "p.meld", "ok(@7)", "--world", "p.toml", "--tick", tick, "--json")
            nodes = json.loads(out)["nodes"]
            self.assertEqual([(n["fact"], n.get("note", "")) for n in nodes[:2]], [("ok(@7)", ""), ("v(@7, _)", note)])

    def test_what_never_ends(self):
        """dist(@0, 4) would come of dist(@1, 3), and so on below 0."""
        self.write("p.meld", GRADIENT)
        self.write("p.toml", world(2, {}, []))
        _, found = self.ask("p.meld", "p.toml", ["run", "why-not --depth 0 dist(@0, 4)"])
        self.assertIn("not followed further: the answer has 10000 facts", found["nodes"][-1]["note"])
        self.assertLess(len(found["nodes"]), 20_000)

    def test_a_long_recursion_at_one_catom(self):
        """Each of 20,000 facts has its place in a computation from nothing, which begins with 200."""
        n = 200
        self.write("p.meld", "type link(node, int, int).\ntype path(node, int, int).\ntype linear fill(node, int).\n"
                             f"fill(@0, {n}).\nfill(A, N), N > 0 -o link(A, N, N - 1), fill(A, N - 1).\n"
                             "path(A, X, Y) :- link(A, X, Y).\npath(A, X, Z) :- path(A, X, Y), link(A, Y, Z).\n")
        self.write("p.toml", 'lattice = "square"\n[[body]]\ncells = [[0, 0]]\n')
        _, why, not_so = self.ask("p.meld", "p.toml", ["run", f"why --depth 0 path(@0, {n}, 0)", "why-not path(@0, 0, 5)"])
        facts = [node["fact"] for node in why["nodes"]]
        for k in range(n):
            self.assertEqual((facts.count(f"path(@0, {n}, {k})"), facts.count(f"link(@0, {k + 1}, {k})")), (1, 1))
        self.assertEqual(not_so["nodes"][0]["fact"], "path(@0, 0, 5)")

    def test_why_not_is_of_one_fact(self):
        program, where, _ = CASES["gradient"]
        self.write("p.meld", program)
        self.write("p.toml", where)
        for body in ("dist(@1, D), D > 100", "dist(@1, D), D = 5, D = 6", "dist(@1, D), D = D + 1", "nearby(@1, X, X)"):
            self.refused("meldsim", "why-not", "p.meld", body, "--world", "p.toml", "--quiet", code=2,
                         says="more is asked than whether one fact holds", lines=None)
        _, one, two = self.ask("p.meld", "p.toml", ["run", "why-not dist(@1, D), D = 5", "why-not dist(@1, 5)"])
        self.assertEqual(one["nodes"], two["nodes"])

    def test_links_at_other_ports(self):
        self.write("p.meld", "type p(node, node, int).\np(A, B, P) :- neighbor(A, B, P).\n")
        self.write("p.toml", world(3, {}, []))
        commands = ["run", "query neighbor(@0, B, P)", *(f"why-not neighbor(@0, @{c}, 9)" for c in range(1, 9))]
        _, links, *found = self.ask("p.meld", "p.toml", commands)
        ports = dict(links["rows"])
        self.assertEqual(len(ports), 2)
        for c, answer in enumerate(found, 1):
            says = f"@0 touches @{c} at port {ports[c]}" if c in ports else f"@0 and @{c} do not touch"
            self.assertEqual(answer["nodes"][0]["note"], says)

    def notes(self, program, where, commands):
        self.write("p.meld", program)
        self.write("p.toml", where)
        return [[w.get("note", "") for w in a["nodes"][0]["ways"]] for a in self.ask("p.meld", "p.toml", ["run", *commands])[1:]]

    LINE = 'lattice = "square"\n[[body]]\nshape = "box(3, 1, 1)"\n'

    def test_what_waits_for_all_neighbours(self):
        program = ("type has(node).\ntype total(node, sum int [<- neighbor]).\ntype late(node, sum int [<- neighbor]).\nhas(@0).\n"
                   "total(A, 1) :- neighbor(A, B), has(B).\nlate(A, 1)@+2 :- neighbor(A, B), has(B).\n")
        for (note, *_) in self.notes(program, self.LINE, ["why-not total(@1, 1)", "why-not total(@1, _)", "why-not late(@1, 1)"]):
            self.assertEqual(note, "its body is met, and it waits for what comes from @2")

    def test_of_an_open_group_what_holds_instead(self):
        """A rule gives a part of a sum, which is not the sum."""
        program = "type c(node, int, sum int).\ntype m(node, int, min int).\nc(A, 1, 2) :- neighbor(A, B).\n" \
                  "m(A, 1, 3) :- neighbor(A, B).\nm(A, 1, 2).\n"
        (c, *_), (m, *_) = self.notes(program, self.LINE, ["why-not c(@1, _, 2)", "why-not m(@1, _, 3)"])
        self.assertEqual(c, "its body is met, and c(@1, 1, 4) holds: its sum is of all that there is, as why tells")
        self.assertEqual(m, "its body is met, and m(@1, 1, 2) holds, and min keeps it")

    def test_before_the_first_tick_nobody_has_told_anything(self):
        """A sum over links has nothing in tick 1 of what neighbours give then."""
        self.write("p.meld", "type has(node).\ntype gone(node).\ntype n(node, count int).\nhas(A).\nn(A, 1).\n"
                             "n(A, 2) :- neighbor(A, B), has(B), not (neighbor(B, C), gone(C)).\n")
        self.write("p.toml", self.LINE)
        for tick, catom_0 in ((1, 1), (2, 2)):
            _, why = self.ask("p.meld", "p.toml", [f"to {tick}", "why n(@0, _)"])
            (node,) = why["nodes"][:1]
            self.assertEqual((node["fact"], len(node["ways"]), node.get("note")), (f"n(@0, {catom_0})", catom_0, None))

    def test_what_points_over_a_link_that_has_gone(self):
        """A catom reads what others have pointed at it as long as they are its neighbours."""
        bodies = {"head": "n(A, 1) :- up(B, A), ok(B).",
                  "two": "n(A, 1) :- up(B, A), up(C, B), ok(C).",
                  "own": "n(A, 1) :- down(A, B), ok(B).",
                  "count": "n(A, N) :- id(A, _), N = count : { up(B, A), ok(B) }, N > 0.",
                  "forall": "n(A, 1) :- forall up(B, A)[ok(B)].",
                  "not": "n(A, 1) :- id(A, _), not (up(B, A), ok(B))."}
        for number, (name, body) in enumerate(bodies.items()):
            for cut in ([0, 1], [1, 2]):
                self.write("p.meld", "type route up(node, min node).\ntype route down(node, max node).\ntype ok(node).\n"
                           "type n(node, count int).\nok(A) :- id(A, I), I > 0.\nup(A, B) :- neighbor(A, B).\n"
                           f"down(A, B) :- neighbor(A, B).\nn(A, 0).\n{body}\n")
                self.write("p.toml", self.LINE + f"[[event]]\ntick = 6\ncut = [{cut}]\n")
                asked = [(tick, catom) for tick in (5, 6, 7, 8) for catom in (0, 1)]
                commands = [c for tick, catom in asked for c in (f"to {tick}", f"query n(@{catom}, N)", f"why n(@{catom}, _)")]
                answers = self.ask("p.meld", "p.toml", commands, 1 + number % 3)
                for (tick, catom), facts, why in zip(asked, answers[1::3], answers[2::3]):
                    with self.subTest(name, cut=cut, tick=tick, catom=catom):
                        ((count,),) = facts["rows"]
                        self.assertEqual(len(why["nodes"][0]["ways"]), count, why["nodes"][0])

    def test_a_group_that_may_only_hold_itself_up(self):
        """A value may be there while the run does not trust yet that there is one at all."""
        self.write("p.meld", "type given(node).\ntype least(node, min int).\ntype near(node, min int).\ntype some(node).\n"
                             "least(A, 9) :- given(A).\nsome(A) :- least(A, _).\nnear(A, 8) :- some(B), neighbor(A, B).\n"
                             "least(A, D / 2) :- near(A, D).\n")
        self.write("p.toml", 'lattice = "square"\n[[body]]\nshape = "box(4, 1, 1)"\n[facts]\ngiven = ["id == 0"]\n'
                             '[[event]]\ntick = 10\ntake = { given = { where = "id == 0" } }\n'
                             '[[event]]\ntick = 12\ngive = { given = { where = "id == 3" } }\n')
        for processes in (1, 2, 3):
            answers = self.ask("p.meld", "p.toml", ["to 14", "why-not some(@2)", "facts least", "to 20", "why some(@2)"], processes)
            self.assertEqual([w["note"] for w in answers[1]["nodes"][0]["ways"]],
                             ["its body is met, and that there is least(@2, _) is still in quarantine, whatever its value"])
            self.assertIn("least(@2, 4).", answers[2]["facts"])
            self.assertEqual(answers[4]["nodes"][0]["is"], "derived")

    def test_a_better_value_has_not_lost(self):
        """While values spread, a neighbour's is better than what a catom has read."""
        program, where, last = CASES["leader"]
        self.write("p.meld", program)
        self.write("p.toml", where)
        commands = [c for t in range(1, last) for c in (f"to {t}", "why --all best(_, _)")]
        lost = 0
        for answer in self.ask("p.meld", "p.toml", commands)[1::2]:
            for node in answer["nodes"]:
                held, *others = [re.match(r"best\(@\d+, (\d+)\)", text) for text in (node["fact"], *node.get("others", ()))]
                for other in filter(None, others):
                    lost += 1
                    self.assertLess(int(other.group(1)), int(held.group(1)), node)
        self.assertGreater(lost, 10)

    def test_what_is_stable_is_said_as_it_is_written(self):
        self.write("s.meld", "type p(node).\ntype q(node).\ntype r(node).\nq(A).\np(A) :- tick(A, T), T > 99.\n"
                             "r(A) :- q(A), stable(p(A), 4).\n")
        self.write("s.toml", world(2, {}, ()))
        out, _ = self.call("meldsim", "why-not", "s.meld", "r(@1)", "--tick", 3, "--quiet", code=0)
        self.assertIn("FAILS  stable(p(@1), 4)", out)
        self.assertNotIn("@stable", out)

    def test_quarantine(self):
        """Where a group has lost a value, what is offered is trusted later, in the tick that the answer names."""
        program, where, _ = CASES["gradient"]
        self.write("p.meld", program)
        self.write("p.toml", where)
        state = self.states("p.meld", "p.toml", 60)
        commands, asked = [], []
        for tick in range(11, 24):
            for catom in range(16):
                value = next((f for t in range(tick + 1, 60) for f in state.get(t, ()) if f.startswith(f"dist(@{catom},")), None)
                if value and not any(f.startswith(f"dist(@{catom},") for f in state[tick]):
                    commands += [f"to {tick}", f"why-not --depth 0 {value}"]
                    asked.append(value)
        found = 0
        for value, answer in zip(asked, self.ask("p.meld", "p.toml", commands)[1::2]):
            for node in answer["nodes"]:
                for way in node["ways"]:
                    said = re.search(r"in quarantine until tick (\d+): rank (\d+) against a loss of rank (\d+) in tick (\d+)",
                                     way.get("note", ""))
                    if not said:
                        continue
                    found += 1
                    until, rank, lost, when = map(int, said.groups())
                    self.assertGreater(until, answer["tick"])
                    self.assertEqual(until, when + rank - lost + 2)
                    # It was there with that rank, and went in that tick.
                    group = node["fact"].split(",")[0]
                    self.assertTrue(any(f.startswith(group + ",") for f in state[when - 1]))
                    self.assertFalse(any(f.startswith(group + ",") for f in state[when]))
                    self.assertFalse(node["fact"] in state[until - 1], said)
        self.assertGreater(found, 3)


if __name__ == "__main__":
    main("meldc", "meldsim")
