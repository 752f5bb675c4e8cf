"""`messages`, `depends` and `history`: what they say is compared with counts, facts and sessions by hand, on one to four processes.

    asking_test.py --meldc PATH --meldsim PATH [--test_random PATH --seeds N --first N] [unittest options]
"""
import csv
import io
import json
import random
import re
import sys
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests"))
sys.path.insert(0, str(ROOT / "tests/state"))

from debug_test import DebugTest  # noqa: E402
from frame import TOOLS, main, square  # noqa: E402
from why_test import GRADIENT, LEADER, TREE, world  # noqa: E402

TOKENS = """type linear token(node, int).
type linear echo(node, int).
type passed(node, int).
type last(node, max int).
type linear nap(node).
token(A, N), N > 0 -o passed(A, N), {B | neighbor(A, B) | token(B, N - 1)}.
token(A, 0), neighbor(A, B), A < B -o echo(B, 1)@+3.
last(A, N) :- neighbor(A, B), passed(B, N).
echo(A, N), nap(A) -o nap(A).
nap(@0).
token(@4, 2).
"""
# What a neighbour has of two links away, and sums that are computed where they are sent from.
FAR = """type on(node).
type near(node, int).
type total(node, sum int).
type two(node, node, min int).
type late(node, count int).
near(A, 1) :- on(A).
near(A, 2) :- on(A), neighborCount(A, 2).
total(A, N) :- neighbor(A, B), neighbor(B, C), near(C, N).
two(A, A, 0) :- on(A).
two(B, X, D + 1) :- neighbor(A, B), two(A, X, D), D < 3.
late(A, B) :- neighbor(A, B), stable(on(B), 2).
"""
# Programs, their worlds and ticks.
CASES = {
    "gradient": (GRADIENT, world(4, {"source": '"id == 0"'}, [(9, "take", "source", 0), (11, "give", "source", 13)]), 30),
    "tree": (TREE, world(3, {"root": '"id == 0"'}, [(8, "give", "root", 7), (12, "take", "root", 0)]), 24),
    "leader": (LEADER, world(3, {}, []), 8),
    "tokens": (TOKENS, world(3, {}, []), 9),
    "far": (FAR, world(3, {"on": '"id < 4"'}, [(4, "take", "on", 1), (6, "give", "on", 8), (7, "take", "on", 0)]), 16),
}
WALK = ROOT / "examples/meld/walk.meld"


class Asking(DebugTest):
    FILES = {f"{name}.{end}": text for name, (program, where, _) in CASES.items() for end, text in (("meld", program), ("toml", where))}

    def stats(self, program, where, tick):
        """Messages since the start, by the number of the predicate."""
        if tick == 0:
            return Counter()
        out, _ = self.call("meldsim", "run", program, *where, "--ticks", tick, "--stats", "--json", "--quiet")
        found = json.loads(out)["stats"]
        counts = Counter({p["number"]: p["messages"] for p in found["predicates"]})
        self.assertEqual(sum(counts.values()), found["algorithm"]["messages"])
        return +counts

    def check_counts(self, program, where, ticks, processes=1):
        """What is listed of each tick is as much as is counted in it."""
        commands = [c for t in ticks for c in (f"to {t}", "messages")]
        answers = self.answers(commands, program, *where, "--quiet", "-n", processes)
        total = 0
        for tick, moved, found in zip(ticks, answers[::2], answers[1::2]):
            if moved.get("tick") != tick:
                break
            counted = self.stats(program, where, tick)
            counted.subtract(self.stats(program, where, tick - 1))
            about = f"{program} tick {tick}: {found}"
            self.assertEqual({p["number"]: p["messages"] for p in found["predicates"]}, dict(+counted), about)
            self.assertEqual(found["count"] - found["by_modules"], sum(counted.values()), about)
            self.assertEqual(len(found["messages"]), found["count"], about)
            total += found["count"]
        return total


class Messages(Asking):
    def test_as_many_as_are_counted(self):
        for processes, (name, (_, _, last)) in enumerate(CASES.items(), 1):
            with self.subTest(program=name):
                ticks = range(1, last + 1)
                self.assertGreater(self.check_counts(f"{name}.meld", ("--world", f"{name}.toml"), ticks, min(processes, 4)), 20)

    def test_as_many_as_are_counted_where_catoms_move(self):
        self.assertGreater(self.check_counts(WALK, (), (1, 2, 7, 16), 2), 20)

    def test_the_same_on_any_number_of_processes(self):
        for program, where, ticks in ((WALK, (), (3, 11)), *((f"{n}.meld", ("--world", f"{n}.toml"), (1, 3, 6, 10)) for n in CASES)):
            commands = [c for t in ticks for c in (f"to {t}", "messages", "messages @4")]
            with self.subTest(program=program):
                answers = [self.answers(commands, program, *where, "--quiet", "-n", n) for n in (1, 2, 3, 4)]
                self.assertEqual(answers[1:], answers[:1] * 3)
                self.assertTrue(any(a.get("count") for a in answers[0]))

    def links(self, name):
        """Who touches whom."""
        out, _ = self.call("meldsim", "query", f"{name}.meld", "neighbor(A, B)", "--world", f"{name}.toml", "--tick", 0, "--json",
                           "--quiet")
        return {tuple(row) for row in json.loads(out)["rows"]}

    def test_what_each_says(self):
        """What came holds now and did not before; what is sent is at its receiver; and all goes over links that there are."""
        kinds = Counter()
        for name, (_, _, last) in CASES.items():
            links = self.links(name)
            answers = self.answers([c for t in range(last + 1) for c in (f"to {t}", "facts", "messages")], f"{name}.meld", "--world",
                                   f"{name}.toml", "--quiet", "-n", 2)
            states = [{f.removesuffix(".") for f in found["facts"]} for found in answers[1::3]]
            hidden = {p["predicate"].split("/")[0] for found in answers[2::3] for p in found["predicates"] if p["made_by_compiler"]}
            for tick, found in enumerate(answers[2::3]):
                for m in found["messages"]:
                    about = f"{name} tick {tick}: {m}"
                    kinds[m["is"]] += 1
                    self.assertIn((m["from"], m["to"]), links, about)
                    self.assertEqual(m["read"], tick + 1, about)
                    if m["fact"].split("(")[0] in hidden or "due" in m:
                        continue
                    if m["is"] == "sent":
                        self.assertIn(f"(@{m['to']}", m["fact"], about)
                        self.assertIn(m["fact"], states[tick], about)
                        continue
                    self.assertIn(f"(@{m['from']}", m["fact"], about)
                    now, before = m["fact"] in states[tick], tick > 0 and m["fact"] in states[tick - 1]
                    self.assertEqual((before, now), {"came": (False, True), "went": (True, False), "changed": (False, True),
                                                     "ranked": (True, True)}[m["is"]], about)
                    if m["is"] == "changed":
                        self.assertIn(m["was"], states[tick - 1], about)
                        self.assertNotIn(m["was"], states[tick], about)
        for kind in ("came", "went", "changed", "sent"):
            self.assertTrue(kinds[kind], kinds)

    def test_of_one_catom(self):
        commands = ["to 3", "messages", *(f"messages @{c}" for c in range(9))]
        _, whole, *parts = self.answers(commands, "tokens.meld", "--world", "tokens.toml", "--quiet", "-n", 3)
        self.assertGreater(whole["count"], 5)
        for catom, part in enumerate(parts):
            mine = [m for m in whole["messages"] if catom in (m["from"], m["to"])]
            self.assertEqual(part["messages"], mine)
            self.assertEqual((part["catom"], part["count"], part["in"], part["out"]),
                             (catom, len(mine), sum(m["to"] == catom for m in mine), sum(m["from"] == catom for m in mine)))
            self.assertEqual(part["waiting"], [w for w in whole["waiting"] if w["catom"] == catom])
        self.assertEqual(whole["waiting_count"], len(whole["waiting"]))

    def test_delayed_facts(self):
        """They are sent at once, and wait where they are."""
        answers = self.answers([c for t in range(1, 9) for c in (f"to {t}", "messages")], "tokens.meld", "--world", "tokens.toml")[1::2]
        sent = Counter((m["fact"], m["due"]) for a in answers for m in a["messages"] if "due" in m)
        self.assertTrue(sent)
        for answer in answers:
            waiting = Counter((w["fact"], w["due"]) for w in answer["waiting"])
            self.assertEqual(waiting, Counter({k: n for k, n in sent.items() if k[1] > answer["tick"] and
                                               any((m["fact"], m.get("due")) == k for a in answers if a["tick"] <= answer["tick"]
                                                   for m in a["messages"])}))

    def test_limits_tables_and_pictures(self):
        call = ("meldsim", "messages", "gradient.meld", "--world", "gradient.toml", "--tick", 3, "--quiet", "-n", 2)
        whole = json.loads(self.call(*call, "--json")[0])
        some = json.loads(self.call(*call, "--json", "--limit", 3)[0])
        self.assertEqual((some["count"], some["messages"]), (whole["count"], whole["messages"][:3]))
        lines = self.call(*call, "--limit", 2)[0].splitlines()
        self.assertEqual(lines[0], f"tick 3: {whole['count']} messages")
        self.assertEqual(lines[-1], f"... and {whole['count'] - 2} more")
        table = list(csv.DictReader(io.StringIO(self.call(*call, "--csv")[0])))
        self.assertEqual([(int(r["from"]), int(r["to"]), r["fact"]) for r in table],
                         [(m["from"], m["to"], m["fact"]) for m in whole["messages"]])
        dot = self.call(*call, "--dot")[0]
        self.assertEqual(len(re.findall(r'"@\d+" -> "@\d+"', dot)), len({(m["from"], m["to"]) for m in whole["messages"]}))

    def test_refusals(self):
        self.refused("meldsim", "messages", "gradient.meld", "@99", "--world", "gradient.toml", "--quiet", code=2,
                     says="there is no catom @99")
        self.refused("meldsim", "messages", "gradient.meld", "dist", "--world", "gradient.toml", "--quiet", code=2,
                     says="'dist' is no catom")
        self.call("meldsim", "run", "gradient.meld", "--world", "gradient.toml", "--ticks", 5, "--quiet", "--checkpoint", "kept")
        self.refused("meldsim", "messages", "kept", "--quiet", code=2, says="what crossed the links in tick 5 is not known")
        at = json.loads(self.call("meldsim", "messages", "kept", "--tick", 6, "--quiet", "--json")[0])
        _, whole = self.answers(["to 6", "messages"], "gradient.meld", "--world", "gradient.toml")
        self.assertEqual(at, whole)
        (nothing,) = self.answers(["messages"], "gradient.meld", "--world", "gradient.toml")
        self.assertEqual(nothing["count"], 0)


class Depends(Asking):
    def by_hand(self, program, where, tick, fact, ticks, processes=1):
        """The same by a session in which the fact is taken."""
        run = [f"to {tick + ticks}", "facts"]
        answers = self.answers([f"to {tick}", *run, f"to {tick}", f"take {fact}", *run], program, *where, "--quiet", "-n", processes,
                               "--ticks", tick + ticks)
        before, after = (Counter(f.removesuffix(".") for f in answers[i]["facts"]) for i in (2, 6))
        return before, after, answers[1]["tick"], answers[5]["tick"]

    def check(self, program, where, tick, fact, ticks=200, processes=1):
        answers = self.answers([f"to {tick}", "where", f"depends --ticks {ticks} {fact}", "where", "events"], program, *where, "--quiet",
                               "-n", processes)
        _, at, found, still, events = answers
        self.assertNotIn("error", found, fact)
        self.assertEqual((still["tick"], still["digest"], events["events"]), (at["tick"], at["digest"], []))
        before, after, ended, ended_without = self.by_hand(program, where, tick, fact, ticks)
        self.assertEqual(Counter(found["gone"]), before - after, found)
        self.assertEqual(Counter(found["came"]), after - before, found)
        for name, change in found["predicates"].items():
            name = name.split(".")[0] + "("
            self.assertEqual(change["gone"] > 0, any(f.startswith(name) for f in before - after))
        self.assertEqual(sum(c["gone"] for c in found["predicates"].values()), len(found["gone"]))
        self.assertEqual((found["tick"], found["with"]["tick"], found["without"]["tick"]), (at["tick"], ended, ended_without))
        return found

    def test_as_by_hand(self):
        where = ("--world", "gradient.toml")
        for processes, tick, ticks, fact in ((1, 5, 3, "source(@0)"), (2, 4, 4, "source(@0)"), (3, 15, 200, "source(@13)")):
            found = self.check("gradient.meld", where, tick, fact, ticks, processes)
            self.assertIn(fact, found["gone"])
            self.assertGreater(len(found["gone"]), 3)
        tokens = self.check("tokens.meld", ("--world", "tokens.toml"), 1, "token(@3, 1)", processes=2)
        self.assertIn("passed(@3, 1)", tokens["gone"])
        self.check("far.meld", ("--world", "far.toml"), 10, "on(@8)", processes=4)

    def test_the_same_on_any_number_of_processes(self):
        commands = ["to 6", "depends --ticks 2 source(@0)", "to 16", "depends --ticks 3 source(@13)"]
        answers = [self.answers(commands, "gradient.meld", "--world", "gradient.toml", "--quiet", "-n", n) for n in (1, 2, 3, 4)]
        self.assertEqual(answers[1:], answers[:1] * 3)
        self.assertEqual(answers[0][3]["without"], {"tick": 19, "ended": "ticks"})

    def test_limit(self):
        call = ("meldsim", "depends", "gradient.meld", "source(@13)", "--world", "gradient.toml", "--quiet", "-n", 2)
        whole = json.loads(self.call(*call, "--json")[0])
        some = json.loads(self.call(*call, "--json", "--limit", 3)[0])
        self.assertEqual(some["predicates"], whole["predicates"])
        self.assertEqual(some["gone"], whole["gone"][:3])
        count = sum(c["come"] + c["gone"] for c in whole["predicates"].values())
        self.assertEqual(self.call(*call, "--limit", 3)[0].splitlines()[-1], f"... and {count - 3} more")
        # @3 comes before @13.
        numbers = [int(re.search(r"@(\d+)", f).group(1)) for f in whole["gone"] if f.startswith("dist(")]
        self.assertEqual(numbers, sorted(numbers))

    def test_refusals(self):
        where = ("--world", "gradient.toml", "--quiet")
        for fact, says in (("dist(@4, 2)", "dist(@4, 2) is not given from outside"), ("source(@3)", "source(@3) does not hold"),
                           ("source(@99)", "there is no catom @99"), ("sorce(@0)", "there is no predicate `sorce`"),
                           ("source(A)", "leaves something open")):
            with self.subTest(fact=fact):
                self.refused("meldsim", "depends", "gradient.meld", fact, *where, code=2, says=says, lines=None)
        self.call("meldsim", "run", "gradient.meld", *where, "--record", "r.vtkhdf")
        self.refused("meldsim", "depends", "r.vtkhdf", "source(@0)", "--tick", 5, "--quiet", code=2, says="a recording says itself")
        self.call("meldsim", "run", "gradient.meld", *where, "--ticks", 5, "--checkpoint", "kept")
        found = json.loads(self.call("meldsim", "depends", "kept", "source(@0)", "--quiet", "--json")[0])
        _, whole = self.answers(["to 5", "depends source(@0)"], "gradient.meld", *where)
        self.assertEqual(found, whole)


# Every rule leaves behind where and when it fired.
LOGGED = """type linear ball(node, int).
type linear bat(node).
type log(node, string, int, int).
type heard(node, int).
ball(@4, 3).
bat(@1).
bat(@4).
ball(A, N), N > 1, tick(A, T) -o log(A, "spread", N, T), {B | neighbor(A, B) | ball(B, N - 1)}.
bat(A), ball(A, 1), tick(A, T) -o log(A, "hit", 1, T), ball(A, 0).
heard(A, N) :- neighbor(A, B), log(B, _, N, _).
"""


class History(Asking):
    def test_which_rule_made_and_took_what(self):
        self.write("p.meld", LOGGED)
        self.write("p.toml", square(3))
        lines = {"spread": 8, "hit": 9}
        for processes in (1, 2, 3):
            _, logs, told = self.answers(["to 8", "facts log", "history ball(_, _)"], "p.meld", "--world", "p.toml", "-n", processes)
            fired = {(int(a), lines[n], int(t)) for a, n, t in re.findall(r'log\(@(\d+), "(\w+)", \d+, (\d+)\)', " ".join(logs["facts"]))}
            seen = set()
            for tick in told["ticks"]:
                for change in tick["changes"]:
                    about = f"tick {tick['tick']}: {change}"
                    self.assertIn(change["how"], ("made", "consumed"), about)
                    self.assertTrue(change["rules"], about)
                    ways = {(r["catom"], r["line"], tick["tick"]) for r in change["rules"] if "catom" in r}
                    # One of those that are named has fired.
                    self.assertTrue(ways & fired or tick["tick"] == 1, about)
                    seen |= ways
            self.assertTrue({line for _, line, _ in seen} == set(lines.values()), seen)

    def test_of_views_and_events(self):
        _, told = self.answers(["run", "history dist(@5, _)"], "gradient.meld", "--world", "gradient.toml")
        hows = Counter()
        for tick in told["ticks"]:
            self.assertEqual(sorted(c["fact"] for c in tick["changes"]), sorted(tick["came"] + tick["went"]))
            for change in tick["changes"]:
                hows[change["how"]] += 1
                if change["how"] in ("derived", "lost"):
                    self.assertIn(change["rules"][0]["line"], (5, 6))
                if change["how"] == "replaced":
                    self.assertIn(change["by"], tick["came"])
        self.assertTrue(hows["derived"] and hows["lost"], hows)
        _, told = self.answers(["run", "history source(_)"], "gradient.meld", "--world", "gradient.toml")
        self.assertEqual([[(c["fact"], c["how"]) for c in t["changes"]] for t in told["ticks"]],
                         [[("source(@0)", "given")], [("source(@0)", "taken")], [("source(@13)", "given")]])
        self.assertEqual([t["tick"] for t in told["ticks"]], [1, 9, 11])
        _, told = self.answers(["run", "history best(@0, _)"], "leader.meld", "--world", "leader.toml")
        self.assertIn("replaced", {c["how"] for t in told["ticks"] for c in t["changes"]})

    def test_of_a_fact_taken_with_one_that_came_within_the_tick(self):
        """Either rule can have taken it, and no state shows which: nothing came from outside."""
        self.write("p.meld", "type linear go(node).\ntype linear ready(node).\ntype linear m(node, int).\ntype linear got(node, int).\n"
                             "go(A) -o ready(A).\nready(A), m(A, X) -o got(A, X).\ngot(A, X), m(A, Y) -o got(A, X + Y).\n")
        self.write("p.toml", square(2) + '[facts]\nm = [{ where = "id >= 0", args = [3] }]\n'
                             '[[event]]\ntick = 4\ngive = { go = "id >= 0" }\n')
        _, told = self.answers(["to 6", "history m(@0, _)"], "p.meld", "--world", "p.toml")
        self.assertEqual([(t["tick"], c["is"], c["how"]) for t in told["ticks"] for c in t["changes"]],
                         [(4, "went", "unknown")])

    def test_of_facts_over_several_links(self):
        """A fact that rests on one so many links away goes as many ticks after it."""
        rules = {"not": "far(A, K) :- start(A, K), not (REACH, seen(Z, K), Z <> A).",
                 "has": "far(A, K) :- REACH, seen(Z, K), Z <> A.",
                 "count": "far(A, N) :- start(A, _), N = count : { REACH, seen(Z, _), Z <> A }, N < 2.",
                 "linear": "type linear go(node, int).\ngo(A, K), REACH, seen(Z, K), Z <> A -o far(A, K)."}
        catoms = "ABCDE"
        for links in (1, 2, 3, 4):
            reach = ", ".join(f"neighbor({a}, {b})" for a, b in zip(catoms[:links], catoms[1:links] + "Z"))
            for kind, rule in rules.items():
                with self.subTest(links=links, kind=kind):
                    given = 'go = [{ where = "id == 0", args = [1] }]\n' if kind == "linear" else ""
                    self.write("p.meld", "type start(node, int).\ntype seen(node, int).\ntype far(node, int).\n"
                               + rule.replace("REACH", reach) + "\n")
                    self.write("w.toml", f'lattice = "square"\n[[body]]\nshape = "box({links + 1}, 1, 1)"\n'
                               f'[facts]\nstart = [{{ where = "id == 0", args = [1] }}]\n{given}[[event]]\ntick = 12\n'
                               f'give = {{ seen = {{ where = "id == {links}", args = [1] }} }}\n[[event]]\ntick = 24\n'
                               f'take = {{ seen = {{ where = "id == {links}", args = [1] }} }}\n')
                    *_, told = self.answers(["to 36", "history far(@0, _)"], "p.meld", "--world", "w.toml", "-n", 1 + links % 3)
                    changes = [(t["tick"], c["is"], c["how"], len(c["rules"])) for t in told["ticks"] for c in t["changes"]]
                    self.assertEqual({c[1] for c in changes}, {"came"} if kind == "linear" else {"came", "went"}, changes)
                    self.assertEqual([c for c in changes if c[2] not in ("derived", "lost", "made") or c[3] != 1], [])

    def test_where_messages_take_time(self):
        """What a view has read of a neighbour is what had come over the link, however long ago that was said."""
        self.write("heard.meld", "type source(node).\ntype beat(node, int).\ntype heard(node, int).\ntype latest(node, max int).\n"
                                 "beat(A, T) :- tick(A, T).\nheard(B, T) :- neighbor(A, B), beat(A, T).\n"
                                 "latest(B, T) :- neighbor(A, B), beat(A, T).\n")
        networks = {"far": '[network]\nkind = "latency"\nleast = 3\nmost = 3\n', "near": '[network]\nkind = "latency"\n',
                    "mixed": '[network]\nkind = "latency"\nleast = 1\nmost = 5\n',
                    "lossy": '[network]\nkind = "lossy"\nloss = 0.4\nretry = 2\ntries = 20\n',
                    "clock": '[clock]\nkind = "random"\nrate = 0.3\nmost = 6\n',
                    "jam": '[[event]]\ntick = 6\njam = { where = "id >= 0", ticks = 9 }\n'}
        gone = '[[event]]\ntick = 20\ntake = { source = "id == 0" }\n[[event]]\ntick = 40\ngive = { source = "id == 3" }\n'
        for i, (name, network) in enumerate(networks.items()):
            self.write("line.toml", f'lattice = "graph"\ngraph = "line(4)"\n[facts]\nsource = "id == 0"\n{network}{gone}')
            for program, fact, line in (("gradient", "dist(@2, _)", 6), ("heard", "heard(@1, _)", 6), ("heard", "latest(@1, _)", 7)):
                with self.subTest(network=name, fact=fact):
                    _, told = self.answers(["to 70", f"history {fact}"], f"{program}.meld", "--world", "line.toml", "-n", 1 + i % 3)
                    changes = [(t["tick"], c["is"], c["how"], [r["line"] for r in c["rules"]]) for t in told["ticks"]
                               for c in t["changes"] if c["how"] != "replaced"]
                    self.assertIn("came", {c[1] for c in changes})
                    self.assertTrue(fact != "dist(@2, _)" or "lost" in {c[2] for c in changes}, changes)
                    self.assertEqual([c for c in changes if c[2] not in ("derived", "lost") or c[3] != [line]], [])

    def test_of_a_head_that_computes_from_itself(self):
        """Nothing but the head says what A is."""
        self.write("p.meld", "type best(node, max int).\ntype pair(node, int, int).\nbest(A, node2int(A)).\n"
                             "best(B, X) :- neighbor(A, B), best(A, X).\npair(A, node2int(A) + 1, 7).\n")
        self.write("p.toml", square(3))
        _, why, told, none = self.answers(["to 2", "why best(@1, _)", "history best(@1, _)", "why-not pair(@1, 3, 7)"], "p.meld", "--world",
                                          "p.toml")
        self.assertEqual([w["line"] for w in why["nodes"][0]["ways"]], [4])
        lines = [(t["tick"], c["how"], [r["line"] for r in c["rules"]]) for t in told["ticks"] for c in t["changes"]]
        self.assertEqual(lines, [(1, "derived", [3]), (2, "replaced", []), (2, "derived", [4])])
        (way,) = [w for w in none["nodes"][0]["ways"] if "text" in w]
        self.assertEqual([p["text"] for p in way["parts"] if p["is"] == "fails"], ["(node2int(@1) + 1) = 3"])

    def test_catoms_come_in_the_order_of_their_numbers(self):
        out, _ = self.call("meldsim", "history", ROOT / "examples/meld/gradient.meld", "dist(_, 2)", "--quiet", "-n", 2)
        numbers = [int(n) for n in re.findall(r"dist\(@(\d+)", out)]
        self.assertEqual(numbers, sorted(numbers))
        self.assertTrue(numbers[0] < 10 and numbers[-1] > 100, numbers)

    def test_the_same_on_any_number_of_processes(self):
        for name, fact in (("gradient", "dist(_, _)"), ("tree", "size(_, _)"), ("tokens", "token(_, _)"), ("tokens", "echo(_, _)")):
            answers = [self.answers(["to 14", f"history {fact}"], f"{name}.meld", "--world", f"{name}.toml", "-n", n) for n in (1, 2, 3)]
            self.assertEqual(answers[1:], answers[:1] * 2)
            self.assertTrue(answers[0][1]["ticks"])

    def test_why_names_the_catom_of_the_firing(self):
        self.write("p.meld", LOGGED)
        self.write("p.toml", square(3))
        _, why = self.answers(["to 8", 'why log(@3, "spread", _, _)'], "p.meld", "--world", "p.toml", "-n", 2)
        (way,) = why["nodes"][0]["ways"]
        self.assertEqual((way["line"], way["catom"]), (8, 3))
        self.assertIn("made in tick 2", why["nodes"][0]["note"])


def keys_of(value):
    if isinstance(value, list):
        return {k for item in value for k in keys_of(item)}
    return set(value) | {k for item in value.values() for k in keys_of(item)} if isinstance(value, dict) else set()


class Keys(Asking):
    def test_the_docs_name_all_keys_of_all_answers(self):
        section = re.search(r"^## JSON$(.*?)^## ", (ROOT / "docs/reference/debugging.md").read_text(), re.M | re.S).group(1)
        named = set(re.findall(r"`(\w+)`", section))
        sessions = {
            "gradient": ["break 6", "watch dist(@1, _)", "breaks", "delete 1", "run", "until dist(@15, _)", "facts", "facts @3", "step",
                         "query dist(A, D)", "query D = 1 / N, dist(A, N)", "why --all dist(_, _)", "why-not dist(@0, 9)",
                         "why nearby(@1, _, _)", "history dist(_, _)", "messages", "messages @1", "give source(@3)", "events",
                         "save-events e.toml", "depends source(@0)", "rules", "predicates", "where", "diff 1", "back", "to 3", "help",
                         "why sorce(@1)"],
            "tokens": ["step", "messages", "why passed(@3, _)", "step 2", "messages", "why-not token(@1, 9)", "history token(_, _)"],
        }
        for name, commands in sessions.items():
            # A mistake ends a session that is not typed.
            code = 2 if name == "gradient" else 0
            out, _ = self.session(commands, f"{name}.meld", "--world", f"{name}.toml", "--json", "--quiet", code=code)
            answers = [json.loads(line) for line in out.splitlines()]
            self.assertEqual(len(answers), len(commands))
            for command, answer in zip(commands, answers):
                # Those are keys of the program.
                by_name = answer.get("predicates")
                if isinstance(by_name, dict):
                    answer["predicates"] = list(by_name.values())
                for node in answer.get("nodes", ()):
                    for way in node["ways"]:
                        way["with"] = list(way.get("with", {}).values())
                self.assertEqual(keys_of(answer) - named, set(), command)


class RandomAsked(Asking):
    """Programs of the reference's generator, in a small world in which facts are given and taken at random."""

    def literal(self, kind, rng, catoms):
        if kind == "int":
            return str(rng.randrange(4))
        if kind == "bool":
            return rng.choice(("true", "false"))
        if kind == "node":
            return f'"@{rng.randrange(catoms)}"'
        return {"float": "1.5", "string": '"ab"'}.get(kind)

    def make(self, seed, rng, catoms, last):
        """Program and world; nothing if facts of it are of types that are not made here."""
        text, _ = self.call(TOOLS.test_random, "--show", seed)
        program, trial = text.split("//: seed", 1)
        kinds = {}
        for name in re.findall(r"^//: given (\w+) ", trial, re.M):
            declared = re.search(rf"^type (?:\w+ )?{name}\((.*)\)\.", program, re.M).group(1)
            kinds[name] = [a.split()[-1] if " " in a and not a.startswith("list") else a for a in declared.split(", ")[1:]]
        where = f'lattice = "square"\nseed = {seed}\n[[body]]\nshape = "box(3, {catoms // 3}, 1)"\n'
        for tick in range(1, last):
            if rng.random() < 0.4:
                for change in rng.sample(("give", "take"), rng.choice((1, 2))):
                    name = rng.choice(sorted(kinds)) if kinds else None
                    arguments = [self.literal(k, rng, catoms) for k in kinds.get(name, ())]
                    if name is None or None in arguments:
                        continue
                    where += (f'[[event]]\ntick = {tick}\n{change} = {{ {name} = {{ where = "id % 3 == {rng.randrange(3)}", '
                              f'args = [{", ".join(arguments)}] }} }}\n')
        return program, where

    def programs(self):
        for seed in range(TOOLS.first, TOOLS.first + TOOLS.seeds):
            rng = random.Random(seed)
            program, where = self.make(seed, rng, 9, 14)
            self.write("p.meld", program)
            self.write("p.toml", where)
            done = self.run_tool("meldsim", "run", "p.meld", "--world", "p.toml", "--ticks", "20", "--quiet")
            if done.returncode == 0:
                yield seed, rng, 1 + seed % 4

    def test_as_many_messages_as_are_counted(self):
        total = 0
        for seed, rng, processes in self.programs():
            with self.subTest(seed=seed):
                total += self.check_counts("p.meld", ("--world", "p.toml"), sorted(rng.sample(range(1, 20), 5)), processes)
        self.assertTrue(total or TOOLS.seeds == 0)

    def test_depends_as_by_hand(self):
        checked = 0
        for seed, rng, processes in self.programs():
            given = sorted(set(re.findall(r"(?:give|take) = \{ (\w+)", self.read("p.toml").decode())))
            tick = rng.randrange(3, 16)
            answers = self.answers([f"to {tick}", *(f"facts {name}" for name in given)], "p.meld", "--world", "p.toml")[1:]
            facts = [f.removesuffix(".") for a in answers for f in a.get("facts", ())]
            if not facts:
                continue
            fact = rng.choice(facts)
            with self.subTest(seed=seed, tick=tick, fact=fact):
                asked = self.answers([f"to {tick}", f"depends {fact}"], "p.meld", "--world", "p.toml", "--quiet")
                if "error" in asked[1]:
                    continue
                Depends.check(self, "p.meld", ("--world", "p.toml"), tick, fact, 30, processes)
                checked += 1
        self.assertTrue(checked or TOOLS.seeds < 4)

    by_hand = Depends.by_hand

    def test_history_as_facts_and_events_say(self):
        hows = Counter()
        for seed, rng, processes in self.programs():
            program, where = self.read("p.meld").decode(), self.read("p.toml").decode()
            lines = program.splitlines()
            events, tick = set(), 0
            for line in where.splitlines():
                found = re.match(r"(?:tick = (\d+)|(give|take) = \{ (\w+))", line)
                if found and found.group(1):
                    tick = int(found.group(1))
                elif found:
                    events.add((tick, found.group(2), found.group(3)))
            answers = self.answers([c for t in range(21) for c in (f"to {t}", "facts")], "p.meld", "--world", "p.toml", "--quiet")
            states = {m["tick"]: {f.removesuffix(".") for f in a["facts"]} for m, a in zip(answers[::2], answers[1::2])}
            names = sorted({f.split("(")[0] for state in states.values() for f in state})
            for name in rng.sample(names, min(3, len(names))):
                pattern = self.open_fact(program, name)
                if pattern is None:
                    continue
                with self.subTest(seed=seed, name=name):
                    _, told = self.answers(["to 20", f"history {pattern}"], "p.meld", "--world", "p.toml", "--quiet", "-n", processes)
                    self.assertNotIn("error", told, pattern)
                    # In a program of linear rules alone, much is made and taken within a tick, and shows in no state.
                    self.check_history(told, name, states, lines, events, hows if ":-" in program else Counter())
        if TOOLS.seeds > 0:
            self.assertTrue(hows["derived"], hows)
            self.assertLessEqual(hows["unknown"], sum(hows.values()) / 20, hows)

    def open_fact(self, program, name):
        """With _ for all of its arguments."""
        found = re.search(rf"^type (?:\w+ )?{name}\((.*)\)\.", program, re.M)
        depth = commas = 0
        for c in found.group(1) if found else "":
            depth += (c in "([{") - (c in ")]}")
            commas += c == "," and depth == 0
        return f"{name}({', '.join('_' * (commas + 1))})" if found else None

    def check_history(self, told, name, states, lines, events, hows):
        changed = {}
        for tick in told["ticks"]:
            for change in tick["changes"]:
                about = f"tick {tick['tick']}: {change}"
                hows[change["how"]] += 1
                changed.setdefault(tick["tick"], {"came": set(), "went": set()})[change["is"]].add(change["fact"])
                for rule in change["rules"]:
                    self.assertIn(name if change["how"] in ("derived", "lost", "made") else "(", lines[rule["line"] - 1], about)
                if change["how"] == "replaced":
                    self.assertIn(change["by"], tick["came"], about)
                if change["how"] in ("given", "taken") and tick["tick"] > 1:
                    self.assertIn((tick["tick"], "give" if change["how"] == "given" else "take", name), events, about)
        for tick in sorted(states)[1:]:
            own = [{f for f in states[t] if f.startswith(name + "(")} for t in (tick - 1, tick)]
            at = changed.get(tick, {"came": set(), "went": set()})
            self.assertEqual((at["came"], at["went"]), (own[1] - own[0], own[0] - own[1]), f"{name} tick {tick}")


if __name__ == "__main__":
    main("meldc", "meldsim", test_random={"default": None, "metavar": "PATH"}, seeds={"type": int, "default": 0, "metavar": "N"},
         first={"type": int, "default": 1, "metavar": "N"})
