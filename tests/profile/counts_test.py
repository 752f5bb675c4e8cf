"""`meldsim run --stats`: what it counts is what a plain computation counts, on any number of processes and threads.

    counts_test.py --meldc PATH --meldsim PATH [unittest options]
"""
import json
import pathlib
import re
import sys

import h5py

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests"))

from frame import OPEN_MPI, Case, main, square  # noqa: E402

GRADIENT = """type source(node).
type dist(node, min int D).
dist(A, 0) :- source(A).
dist(B, D + 1) :- neighbor(A, B), dist(A, D).
"""
SOURCE = '[facts]\nsource = ["id == 0"]\n'
# Loses its source.
LOSS = SOURCE + '[[event]]\ntick = 20\ntake.source = "id == 0"\n'
TOKEN = """type linear token(node, int N).
token(A, N), N > 0, neighbor(A, B) -o token(B, N - 1).
"""
# The same counts, however the run is divided.
SETUPS = ((1, 1), (1, 2), (3, 2))


class Counts(Case):
    def stats(self, program, world, processes=1, threads=1, *more):
        self.write("p.meld", program)
        self.write("w.toml", world)
        out, _ = self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--stats", "--json", "-n", processes, "--threads", threads,
                           *more, environment=OPEN_MPI)
        return json.loads(out)

    def predicate(self, summary, name):
        return next(p for p in summary["stats"]["predicates"] if p["predicate"] == name)

    def test_a_gradient_is_counted_as_by_hand(self):
        """The rounds of the rules, made once more over plain dictionaries."""
        side = 5
        summary = self.stats(GRADIENT, square(side) + SOURCE)
        # Catoms are told apart by their evaluations alone, so any numbering will do in which the source is in a corner.
        cells = {(x, y): {(x + dx, y + dy) for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1)) if 0 <= x + dx < side and 0 <= y + dy < side}
                 for x in range(side) for y in range(side)}
        # Before the others have a neighbour with a distance, no rule can do anything at them.
        dist, told, awake = {}, {(0, 0)}, {(0, 0)}
        evaluations = derivations = first = messages = rounds = 0
        loads = dict.fromkeys(cells, 0)
        while told:
            rounds += 1
            now = {}
            for cell in awake:
                loads[cell] += 1
                proposals = [dist[other] + 1 for other in cells[cell] if other in dist]
                derivations += len(proposals)
                if cell == (0, 0):
                    proposals.append(0)
                    first += 1
                if proposals and dist.get(cell) != min(proposals):
                    now[cell] = min(proposals)
            evaluations += len(awake)
            messages += sum(len(cells[cell]) for cell in now)
            dist.update(now)
            told = {other for cell in now for other in cells[cell]}
            # The others learn of nothing better, and are not evaluated.
            awake = {other for cell in now for other in cells[cell] if other not in dist or dist[other] > now[cell] + 1}
        rules = summary["stats"]["rules"]
        self.assertEqual(summary["evaluations"], evaluations)
        self.assertEqual([r["evaluations"] for r in rules], [evaluations, evaluations])
        self.assertEqual([r["derivations"] for r in rules], [first, derivations])
        self.assertEqual([r["firings"] for r in rules], [first, derivations])
        self.assertEqual([r["messages"] for r in rules], [0, messages])
        p = self.predicate(summary, "dist/2")
        self.assertEqual((p["facts"], p["gained"], p["lost"], p["retracted"], p["quarantined"], p["messages"]), (25, 25, 0, 0, 0, messages))
        # One bit for coming or going, an int, and the rank.
        self.assertEqual(p["bits"], messages * (1 + 32 + 32))
        self.assertEqual(p["last_active_tick"], rounds - 1)
        algorithm = summary["stats"]["algorithm"]
        self.assertEqual(algorithm["settling"], [{"from": "start", "tick": 1, "rounds": rounds}])
        self.assertEqual((algorithm["messages"], algorithm["busiest_catom"]["messages"], algorithm["link_in_one_tick"]["messages"]),
                         (messages, 4, 1))
        busiest = [c["evaluations"] for c in summary["stats"]["busiest_catoms"]]
        self.assertEqual(busiest, sorted(loads.values(), reverse=True)[:10])

    def test_a_source_that_goes_is_counted(self):
        summary = self.stats(GRADIENT, square(3) + LOSS)
        p = self.predicate(summary, "dist/2")
        self.assertEqual(p["facts"], 0)
        self.assertEqual(p["gained"], p["lost"])
        # Each catom had one fact, which no better one has replaced; what came back came from a quarantine, or never.
        self.assertGreaterEqual(p["retracted"], 9)
        self.assertGreater(p["quarantined"], 0)
        start, event = summary["stats"]["algorithm"]["settling"]
        self.assertEqual((start["from"], start["tick"], event["from"], event["tick"]), ("start", 1, "event", 20))
        self.assertLess(start["rounds"], 20)
        self.assertEqual(20 + event["rounds"] - 1, summary["ticks"])

    def test_a_token_is_counted_as_by_hand(self):
        """It goes to and fro five times: three times out of the first catom, twice out of the other."""
        world = 'lattice = "square"\n[[body]]\nshape = "box(2, 1, 1)"\n[facts]\ntoken = [{ where = "id == 0", args = [5] }]\n'
        summary = self.stats(TOKEN, world)
        stats = summary["stats"]
        rule = next(r for r in stats["rules"] if r["firings"])
        self.assertEqual((rule["firings"], rule["derivations"], rule["messages"], rule["sent_messages"]), (5, 5, 5, 5))
        p = self.predicate(summary, "token/2")
        self.assertEqual((p["facts"], p["gained"], p["lost"], p["messages"]), (1, 0, 5, 5))
        self.assertEqual(p["bits"] % 5, 0)
        self.assertEqual([(c["catom"], c["messages"]) for c in stats["catoms_with_most_messages"]], [(0, 3), (1, 2)])
        self.assertEqual((stats["algorithm"]["busiest_link"]["catom"], stats["algorithm"]["busiest_link"]["messages"]), (0, 3))

    def test_values_of_several_words_are_counted_by_their_length(self):
        program = ("type name(node, string).\ntype heard(node, node, string).\nname(A, \"abc\") :- id(A, 0).\n"
                   "heard(A, B, S) :- neighbor(A, B), name(B, S).\n")
        world = 'lattice = "square"\n[[body]]\nshape = "box(2, 1, 1)"\n'
        p = self.predicate(self.stats(program, world), "name/2")
        self.assertEqual((p["messages"], p["bits"]), (1, 1 + 32 + 3 * 8))

    def test_the_parts_add_up(self):
        compared = 0
        for name in ("census", "quicksort", "bipartite"):
            path = ROOT / "examples/meld" / f"{name}.meld"
            out, _ = self.call("meldsim", "run", path, "--stats", "--json", "--ticks", 40, "--facts-out", "facts.txt")
            summary = json.loads(out)
            stats = summary["stats"]
            self.assertEqual(sum(r["derivations"] for r in stats["rules"]), summary["derivations"], name)
            self.assertEqual(sum(p["evaluations"] for p in stats["processes"]), summary["evaluations"], name)
            self.assertEqual(sum(p["messages"] for p in stats["predicates"]), stats["algorithm"]["messages"], name)
            facts = self.read("facts.txt").decode().splitlines()
            for p in stats["predicates"]:
                own = p["predicate"].split("/")[0]
                # Actions are no facts in a file.
                if not p["made_by_compiler"] and re.search(rf"^type .*\b{own}\(", path.read_text(), re.MULTILINE):
                    said = sum(line.startswith(own + "(") for line in facts)
                    self.assertEqual(p["facts"], said, f"{name}: {p['predicate']}")
                    compared += 1
        self.assertGreater(compared, 5)

    def test_the_counts_are_the_same_on_any_number_of_processes_and_threads(self):
        wide = 'lattice = "square"\n[[body]]\nshape = "box(24, 12, 1)"\n'
        cases = [(GRADIENT, wide + LOSS), (TOKEN, wide + '[facts]\ntoken = [{ where = "x % 7 == 0", args = [30] }]\n'),
                 ((ROOT / "examples/meld/walk.meld").read_text(), (ROOT / "examples/meld/walk.toml").read_text())]
        for program, world in cases:
            seen = []
            for processes, threads in SETUPS:
                summary = self.stats(program, world, processes, threads, "--ticks", 45)
                stats = summary["stats"]
                self.assertEqual(sum(p["catoms"] for p in stats.pop("processes")), summary["catoms"])
                # Room for more rows depends on how they came.
                for p in stats["predicates"]:
                    del p["bytes"]
                seen.append(stats)
            for (processes, threads), stats in zip(SETUPS, seen):
                self.assertEqual(stats, seen[0], f"{program.splitlines()[0]}: {processes} processes of {threads} threads")

    def test_a_recording_has_the_load_of_each_catom(self):
        """Of each interval, however often a catom has changed its process, and as much in all as the run has counted."""
        walk = (ROOT / "examples/meld/walk.meld").read_text(), (ROOT / "examples/meld/walk.toml").read_text()
        for program, world, ticks in ((GRADIENT, square(9) + LOSS, 40), (*walk, 40)):
            seen = []
            for processes, threads in ((1, 2), (3, 1)):
                summary = self.stats(program, world + "[record]\nevery = 7\n", processes, threads, "--ticks", ticks, "--record", "r.vtkhdf")
                with h5py.File(self.folder / "r.vtkhdf") as file:
                    data = file["VTKHDF/PointData"]
                    seen.append([data[name][...].tolist() for name in ("id", "load.evaluations", "load.messages")])
                    count = file["VTKHDF/NumberOfPoints"][0]
                    self.assertEqual(set(seen[-1][1][:count]), {0})
                _, evaluations, messages = seen[-1]
                self.assertGreaterEqual(min(evaluations), 0)
                self.assertEqual((sum(evaluations), sum(messages)),
                                 (summary["evaluations"], summary["stats"]["algorithm"]["messages"]))
            self.assertEqual(seen[0], seen[1])
        self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--ticks", 9, "--record", "plain.vtkhdf", "--quiet")
        with h5py.File(self.folder / "plain.vtkhdf") as file:
            self.assertNotIn("load.evaluations", file["VTKHDF/PointData"])

    def test_a_run_does_the_same_with_and_without_counters(self):
        world = square(6) + LOSS
        self.stats(GRADIENT, world, 1, 1, "--digest", "with.txt", "--profile", "run.profile")
        self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--quiet", "--digest", "without.txt")
        self.assertEqual(self.read("with.txt"), self.read("without.txt"))

    def test_it_is_printed(self):
        self.write("p.meld", GRADIENT)
        self.write("w.toml", square(5) + SOURCE)
        out, _ = self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--stats")
        for text in ("rounds", "10 from the start", "dist(B, D + 1) :- neighbor(A, B), dist(A, D).", "catoms with most messages",
                     "busiest ticks"):
            self.assertIn(text, out)
        self.assertNotIn("algorithm", self.call("meldsim", "run", "p.meld", "--world", "w.toml")[0])

    def test_a_module_without_counters_is_refused(self):
        self.write("p.meld", GRADIENT)
        self.write("w.toml", square(2))
        self.call("meldc", "compile", "p.meld", "-o", "plain.so")
        self.call("meldc", "compile", "p.meld", "--counters", "-o", "counting.so")
        self.refused("meldsim", "run", "plain.so", "--world", "w.toml", "--stats", code=2, says=["does not count", "--counters"],
                     lines=None)
        self.call("meldsim", "run", "counting.so", "--world", "w.toml", "--stats")
        # Nobody has to look at what it counts.
        self.call("meldsim", "run", "counting.so", "--world", "w.toml", "-n", 2, environment=OPEN_MPI)

    def test_a_run_that_goes_on_counts_from_there(self):
        self.write("p.meld", GRADIENT)
        self.write("w.toml", square(5) + LOSS)
        self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--stats", "--quiet", "--ticks", 6, "--checkpoint", "checkpoints")
        out, _ = self.call("meldsim", "resume", "checkpoints", "--json", "--ticks", 100)
        stats = json.loads(out)["stats"]
        self.assertEqual(stats["first_tick"], 7)
        self.assertEqual(stats["algorithm"]["settling"][0]["from"], "resumed")
        # One that makes no tick covers none.
        stats = json.loads(self.call("meldsim", "resume", "checkpoints", "--json")[0])["stats"]
        self.assertEqual((stats["first_tick"], stats["algorithm"]["settling"]), (stats["last_tick"] + 1, []))

    def test_events_without_end_are_counted(self):
        self.write("p.meld", "type p(node, int).\ntype q(node, int).\nq(A, N) :- p(A, N).\n")
        self.write("w.toml", square(1) + '[[event]]\ntick = 1\nevery = 1\ntimes = 10005\ngive.p = { where = "all", args = [1] }\n')
        run = ("meldsim", "run", "p.meld", "--world", "w.toml", "--stats", "--ticks", 10006)
        algorithm = json.loads(self.call(*run, "--json")[0])["stats"]["algorithm"]
        self.assertEqual((len(algorithm["settling"]), algorithm["settling_left_out"]), (10000, 5))
        self.assertEqual(algorithm["settling"][-1]["tick"], 10000)
        self.assertRegex(self.call(*run)[0], r"rounds  .*, and 9,995 more\n")


if __name__ == "__main__":
    main("meldc", "meldsim")
