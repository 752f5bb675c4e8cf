"""Runs that branch off from the checkpoint of another one: fork_test.py --meldc PATH --meldsim PATH [unittest options]

With nothing changed, a run that branches off is the run that goes on, bit for bit. With another program, what was given or is linear is
taken over, and what rules derive is what a run of that program derives.
"""

import json
import pathlib
import signal
import sys
import threading

import h5py

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import resume_test  # noqa: E402
from frame import main, square  # noqa: E402
from resume_test import DAMAGED, KEEP, until  # noqa: E402

GRID = 'lattice = "square"\n[[body]]\nshape = "box(12, 5, 1)"\n[facts]\nsource = "id == 0"\n'
GRADIENT = """type source(node).
type dist(node, min int).
dist(A, 0) :- source(A).
dist(B, D + 1) :- neighbor(A, B), dist(A, D).
"""
EXAMPLES = pathlib.Path(__file__).resolve().parents[2] / "examples/meld"
# Views of every kind of recursion and storage, over the same given facts.
OTHERS = {
    "slower": GRADIENT.replace("D + 1", "D + 2") +
              "type far(node, max int).\nfar(A, D) :- dist(A, D).\nfar(B, D) :- neighbor(A, B), far(A, D).\n",
    "pairs": "type source(node).\ntype near(node, node, min int).\ntype often(node, count int).\ntype flag(node).\n"
             "near(A, A, 0) :- neighborCount(A, _).\nnear(A, C, D + 1) :- neighbor(A, B), near(B, C, D), D < 3.\n"
             "often(A, 1) :- near(A, _, _).\nflag(A) :- often(A, N), N > 10.\n",
    "sums": "type source(node).\ntype reach(node, node).\ntype sized(node, sum int).\ntype words(node, string).\ntype none(node).\n"
            "reach(A, A) :- source(A).\nreach(B, C) :- neighbor(A, B), reach(A, C).\nsized(A, 2) :- reach(A, _).\n"
            "words(A, int2str(N)) :- sized(A, N).\nnone(A) :- not source(A).\n",
}
TOKENS = """type linear token(node, int).
type linear bell(node, int).
type linear spent(node).
type rung(node, int).
type seen(node, max int).
token(@0, 0).
spent(@1).
spent(@15).
token(A, N), N < 12 -o bell(A, N)@+6, rung(A, N)@+2, token(A, N + 1)@+1.
spent(A), neighbor(A, B), rung(B, N), N < 100 -o rung(A, 100).
seen(A, N) :- rung(A, N).
"""


class Case(resume_test.Case):
    def keep(self, program, ticks, *options, world="w.toml", folder="kept"):
        """A run that ends with a checkpoint after so many ticks."""
        self.call("meldsim", "run", program, "--world", world, "--ticks", ticks, "--quiet", "--checkpoint", folder, *options)

    def fork(self, *options, folder="kept"):
        return json.loads(self.call("meldsim", "fork", folder, "--json", *options)[0])

    def facts_of(self, text):
        return sorted(text.decode().splitlines())

    def fresh(self, program, *options, world="w.toml"):
        self.call("meldsim", "run", program, "--world", world, "--quiet", "--facts-out", "fresh", *options)
        return self.facts_of(self.read("fresh"))

    def forked(self, *options, folder="kept"):
        """The summary and the facts of a run that branches off."""
        summary = self.fork("--facts-out", "forked", *options, folder=folder)
        return summary["forked"], self.facts_of(self.read("forked"))

    def bytes_in(self, folder):
        return {p.name: p.read_bytes() for p in (self.folder / folder).iterdir()}


class Same(Case):
    """Nothing changes but what is asked for."""

    def test_it_is_the_run_that_goes_on(self):
        wanted = self.undisturbed()
        last = [line for line in wanted[0].splitlines() if int(line.split()[1]) > 100]
        for made_by, processes, threads in ((1, 4, 1), (2, 3, 1), (3, 1, 2)):
            with self.subTest(made_by=made_by, processes=processes):
                folder = f"kept{made_by}{processes}"
                self.call("meldsim", *until(100), "--checkpoint", folder, "-n", made_by)
                before = self.bytes_in(folder), self.outcome()
                summary = self.fork("--ticks", 300, "--digest", "d2", "--facts-out", "f2", "-n", processes, "--threads", threads,
                                    folder=folder)
                self.assertEqual(self.read("d2").splitlines(), last)
                self.assertEqual(self.read("f2"), wanted[1])
                self.assertEqual((self.bytes_in(folder), self.outcome()), before)
                about = summary["forked"]
                self.assertEqual((about["tick"], about["anew"], about["changed"], summary["ticks"]), (100, False, [], 300))
                self.assertEqual("tick 100 " + about["digest"], before[1][0].decode().splitlines()[-1])
                self.forget()

    def test_bodies(self):
        run = ["doze.meld" if word == "waiting.meld" else word for word in until(40)]
        self.call("meldsim", *run)
        wanted = self.read("d").splitlines()[20:], self.read("f")
        self.forget()
        self.call("meldsim", *["20" if word == "40" else word for word in run], "--checkpoint", "kept")
        self.fork("--ticks", 40, "--digest", "d2", "--facts-out", "f2", "-n", 2)
        self.assertEqual((self.read("d2").splitlines(), self.read("f2")), wanted)

    def test_it_keeps_checkpoints_of_its_own(self):
        wanted = self.undisturbed()
        self.call("meldsim", *until(100), "--checkpoint", "kept")
        self.forget()
        self.fork("--ticks", 100, "--digest", "d2", "--facts-out", "f2", "--record", "r2", "--checkpoint", "own")
        # Before its first tick, too: the run that it comes from may go on.
        self.assertEqual(sorted(self.bytes_in("own")), ["100.0-of-1.share", "100.checkpoint.json"])
        self.assertEqual(self.read("d2"), b"")
        self.call("meldsim", "resume", "own", "--ticks", 200, "-n", 2, "--quiet")
        self.call("meldsim", "resume", "own", "--ticks", 300, "--quiet")
        self.assertEqual(self.read("d2").splitlines(), wanted[0].splitlines()[100:])
        self.assertEqual(self.read("f2"), wanted[1])
        with h5py.File(self.folder / "r2") as file:
            steps = list(file["VTKHDF/Steps/Values"])
        self.assertEqual(steps, [100] + [t for t in range(102, 300, 3)] + [300])
        self.refused("meldsim", "replay", "r2", code=DAMAGED, says=["r2 is of a run that branched off from a checkpoint", "kept"])

    def test_its_command_says_all_of_it(self):
        self.write("sub.meld", "const K = 1.\ntype p(node, int, int, string).\np(A, K, @arg1, @arg2) :- neighborCount(A, _).\n")
        self.write("w.toml", square(4))
        self.keep("sub.meld", 2, "--set", "K=5", "--arg", "1", "--arg", "", "-I", ".")
        self.write("there/w.meld", "tell(A) :- p(A, 1, _, _).\n")
        self.call("meldsim", "fork", "../kept", "--arg", "7", "--set", "K=6", "--seed", "9", "-O1", "--strict", "--ticks", "4",
                  "--digest", "d2", "--facts-out", "../f2", "--checkpoint", "own", "--checkpoint-every", "2ticks", "--retries", "1",
                  "--heartbeat", "1min", "--timeout", "50", "--sync", "--quiet", "--junit", "out.xml", "--profile", "pr",
                  "--record", "r", "--stats", "--watch", "w.meld", "--watch", "p(A, 0, _, _)", "--expect", "p(A, 6, _, _)", "--expect",
                  "p(@0, 6, _, _)", "--never", "p(A, 1, _, _)", cwd=self.folder / "there")
        self.assertIn(b'p(@0, 6, 7, "").', self.read("f2"))
        manifest = (self.folder / "there/own/2.checkpoint.json").read_text()
        command = json.loads(manifest[:manifest.rstrip().rindex("\n")])["command"][1:]
        self.assertEqual(command, ["run", "sub.meld", "--world=w.toml", "--library=.", "--ticks=4", "--processes=1", "--threads=1",
                                   "--set=K=5", "--set=K=6", "--arg=7", "--arg", "", "-O1", "--seed=9", "--facts-out=f2",
                                   "--digest=there/d2", "--record=there/r", "--profile=there/pr", "--junit=there/out.xml",
                                   "--watch=there/w.meld", "--watch=p(A, 0, _, _)", "--expect=p(A, 6, _, _)",
                                   "--expect=p(@0, 6, _, _)", "--never=p(A, 1, _, _)", "--checkpoint=there/own",
                                   "--checkpoint-every=2ticks", "--retries=1", "--heartbeat=1min", "--balance=auto",
                                   "--timeout=50", "--strict", "--sync", "--stats", "--quiet", f"--forked-from={self.folder}/kept"])

    def test_it_is_watched_for_what_it_says_itself(self):
        self.write("p.meld", GRADIENT)
        self.write("w.toml", GRID)
        self.keep("p.meld", 10, "--never", "dist(A, D), D < 0", "--junit", "run.xml", folder="watched")
        self.keep("p.meld", 10)
        for folder in ("kept", "watched"):
            self.call("meldsim", "fork", folder, "--quiet")
            self.call("meldsim", "fork", folder, "--quiet", "--expect", "dist(A, D), D > 1000", "-n", 2, code=3)
            self.refused("meldsim", "fork", folder, "--junit", "run.xml", "--facts-out", "run.xml", code=2, says="are the same file")
        self.refused("meldsim", "fork", "watched", "--junit", "run.xml", code=2,
                     says="--junit of the run in watched and --junit are the same file")

    def test_a_run_that_is_counted_from_here_on_is_compiled_anew(self):
        self.write("p.meld", GRADIENT)
        self.write("w.toml", GRID)
        self.keep("p.meld", 10)
        self.keep("p.meld", 10, "--stats", folder="counted")
        for folder, wanted in (("kept", ["how the program is compiled, or what it includes"]), ("counted", [])):
            self.assertEqual(self.fork("--stats", folder=folder)["forked"]["changed"], wanted)

    def test_several_at_once_from_a_run_that_goes_on(self):
        run = self.begin("meldsim", "run", "waiting.meld", "--quiet", "--ticks", 100000000, "--checkpoint", "kept",
                         "--checkpoint-every", "1ticks")
        self.wait_for(lambda: len(self.manifests()) >= 2, run)
        ticks = []

        def branch(number):
            for processes in (1, 2):
                summary = self.fork("--ticks", 1, "--digest", f"d{number}", "-n", processes)
                ticks.append(summary["forked"]["tick"])
                self.assertEqual(summary["forked"]["anew"], False)
        threads = [threading.Thread(target=branch, args=(i,)) for i in range(3)]
        for each in threads:
            each.start()
        for each in threads:
            each.join()
        self.assertEqual(len(ticks), 6)
        self.assertIsNone(run.poll())
        run.send_signal(signal.SIGINT)
        self.assertEqual(run.wait(20), 130)


class OtherProgram(Case):
    def test_views_are_those_of_a_fresh_run(self):
        self.write("grid.toml", GRID)
        self.write("p.meld", GRADIENT)
        for name, text in OTHERS.items():
            self.write(f"{name}.meld", text)
            wanted = self.fresh(f"{name}.meld", world="grid.toml")
            for ticks in (3, 60):
                with self.subTest(name, ticks=ticks):
                    self.keep("p.meld", ticks, world="grid.toml", folder=f"{name}{ticks}")
                    digests = set()
                    for processes in (1, 3) if ticks == 3 else (2,):
                        about, facts = self.forked("--program", f"{name}.meld", "--digest", "d", "-n", processes, folder=f"{name}{ticks}")
                        self.assertEqual(facts, wanted)
                        self.assertEqual((about["anew"], about["changed"], about["taken_over"]), (True, ["the program"], {"source": 1}))
                        self.assertIn("dist" if name == "slower" else "flag" if name == "pairs" else "none", about["derived_anew"])
                        digests.add(self.read("d"))
                    self.assertEqual(len(digests), 1)

    def test_examples(self):
        """A program that only reads differently; its views come to what they were."""
        for name, ticks in (("shortest_paths", 17), ("census", 37), ("minimum_spanning_tree", 34), ("spanning_tree", 20)):
            with self.subTest(name):
                text = (EXAMPLES / f"{name}.meld").read_text()
                self.write(f"{name}.toml", (EXAMPLES / f"{name}.toml").read_text())
                self.write(f"{name}.meld", text)
                wanted = self.fresh(f"{name}.meld", world=f"{name}.toml")
                self.keep(f"{name}.meld", ticks, world=f"{name}.toml", folder=name)
                self.write(f"{name}.meld", text + "// The same.\n")
                about, facts = self.forked(folder=name)
                self.assertEqual((facts, about["anew"]), (wanted, True))

    def test_a_rule_that_was_saved(self):
        """Without --program, the file is taken as it is now; facts that nothing supports any more are gone."""
        self.write("grid.toml", GRID)
        self.write("p.meld", GRADIENT + "dist(@30, 1).\n")
        self.keep("p.meld", 40, world="grid.toml")
        self.write("p.meld", GRADIENT.replace("D + 1 ", "D + 3 "))
        self.assertEqual(self.forked()[1], self.fresh("p.meld", world="grid.toml"))

    def test_linear_facts_go_on(self):
        """Those that wait for their time, too. Axioms that were consumed do not come back, and new ones do not come."""
        self.write("t.meld", TOKENS)
        wanted = self.fresh("t.meld", "--ticks", 40)
        for made_by, ticks in ((1, 2), (2, 7)):
            self.keep("t.meld", ticks, "-n", made_by, folder=f"kept{ticks}")
            self.write("u.meld", TOKENS.replace("token(@0, 0).", "token(@0, 0). token(@5, 7). late(@1).") +
                       "type linear late(node).\ntype more(node, int).\nmore(A, N + 1) :- seen(A, N).\n")
            for processes in (1, 2) if made_by == 1 else (3,):
                about, facts = self.forked("--program", "u.meld", "--ticks", 40, "-n", processes, folder=f"kept{ticks}")
                self.assertEqual([f for f in facts if not f.startswith("more")], wanted)
                self.assertTrue(any(f.startswith("more(@0") for f in facts))
                self.assertEqual(about["dropped"], {})
                self.assertGreater(about["taken_over"]["bell"], 0)

    def test_what_is_gone_is_told(self):
        self.write("t.meld", TOKENS)
        self.keep("t.meld", 9)
        self.write("u.meld", "type rung(node, int).\ntype new(node, count int).\nnew(A, 1) :- rung(A, _).\n")
        out, err = self.call("meldsim", "fork", "kept", "--program", "u.meld", "--json", "--facts-out", "forked", "-n", 2)
        about = json.loads(out)["forked"]
        self.assertEqual((sorted(about["dropped"]), list(about["taken_over"])), (["bell", "rung", "spent", "token"], ["rung"]))
        self.assertIn("warning: ", err)
        self.assertRegex(err, r"facts? of bell, \d+ of rung, 1 of spent and 1 of token are dropped")
        rung = [f for f in self.facts_of(self.read("forked")) if f.startswith("rung")]
        self.assertEqual(len(rung), about["taken_over"]["rung"])
        # What rules derive now has no place for facts that were given.
        self.write("u.meld", TOKENS.replace("rung(A, N)@+2, ", "").replace("spent(A), neighbor(A, B), rung(B, N), N < 100 -o rung(A, 100).",
                                                                           "rung(A, 1) :- neighborCount(A, _)."))
        self.assertEqual(list(self.forked("--program", "u.meld", "--ticks", 30)[0]["dropped"]), ["rung"])

    def test_another_declaration(self):
        self.write("t.meld", TOKENS)
        self.keep("t.meld", 9)
        for change, says in (("rung(node, float)", ["facts of rung(node, int)", "now declares rung(node, float)"]),
                             ("rung(node, int, int)", ["facts of rung(node, int)", "now declares rung(node, int, int)"]),
                             ("linear rung(node, int)", ["facts of rung(node, int)", "now declares linear rung(node, int)"])):
            with self.subTest(change):
                body = f"rung(A{', _' * change.count(',')})"
                rule = f"{body} -o any(A)" if "linear" in change else f"any(A) :- {body}"
                self.write("u.meld", f"type {change}.\ntype any(node).\n{rule}.\n")
                for n in (1, 2) if "float" in change else (1,):
                    self.refused("meldsim", "fork", "kept", "--program", "u.meld", "-n", n, code=DAMAGED,
                                 says=["cannot be taken over", *says, "Declare rung as it was"])
        # Only rules derive `seen`.
        self.write("u.meld", TOKENS.replace("seen(node, max int)", "seen(node, int, int)").replace("seen(A, N)", "seen(A, N, N)"))
        self.assertIn("seen", self.forked("--program", "u.meld", "--ticks", 30)[0]["derived_anew"])

    def test_lists_and_other_values(self):
        program = ("type linear box(node, list int, string).\ntype kept(node, set int, :(int, float)).\ntype all(node, list int).\n"
                   "box(A, [1, 2, 3], \"one\").\n"
                   "box(A, L, S), S = \"one\" -o box(A, [9 | L], \"two\"), kept(A, list2set(L), :(4, 0.5)).\n")
        self.write("l.meld", program)
        self.keep("l.meld", 3)
        wanted = self.fresh("l.meld")
        self.write("m.meld", "type extra(node, int).\n" + program + "all(A, [1]) :- kept(A, _, _).\n")
        facts = self.forked("--program", "m.meld", "-n", 2)[1]
        self.assertEqual([f for f in facts if not f.startswith("all")], wanted)

    def test_actions(self):
        """What held has been carried out; what was asked for in the last tick is carried out in the next."""
        self.write("moves.toml", 'lattice = "cubic"\nheld = 1\n[[body]]\nshape = "box(3, 1, 1)"\n[motion]\nkind = "lattice"\n')
        program = ("type linear birth(node).\ntype done(node, int).\ntype action print(node, string).\nbirth(A).\n"
                   "birth(A), id(A, I) -o done(A, I).\nprint(A, \"I am \" ++ int2str(I)) :- done(A, I).\n"
                   "create(@0, 2) :- tick(@0, T), T >= 5.\n")
        self.write("a.meld", program)
        for ticks in (4, 5, 6):
            with self.subTest(ticks=ticks):
                self.keep("a.meld", ticks, world="moves.toml", folder=f"kept{ticks}")
                self.write("b.meld", program + "type other(node).\nother(A) :- done(A, _).\n")
                for processes in (1, 2) if ticks == 5 else (1,):
                    out, _ = self.call("meldsim", "fork", f"kept{ticks}", "--program", "b.meld", "--ticks", 10, "--quiet",
                                       "-n", processes, "--facts-out", "forked")
                    # The fourth is born in tick 6, with its linear axiom.
                    self.assertEqual(out.splitlines(), ["@3: I am 3"] if ticks < 6 else [])
                    self.assertEqual([f for f in self.facts_of(self.read("forked")) if f.startswith("other")],
                                     [f"other(@{i})." for i in range(4)])

    def test_a_watch_goes_on(self):
        self.write("w.meld", "type action watch(node, string).\ntype p(node, int).\nwatch(@0, \"p\").\np(@0, T / 10) :- tick(@0, T).\n")
        self.keep("w.meld", 15)
        self.write("v.meld", "type q(node).\n" + self.read("w.meld").decode().replace("T / 10", "T / 5"))
        said = self.call("meldsim", "fork", "kept", "--program", "v.meld", "--ticks", 21, "--quiet")[0]
        self.assertEqual(said.splitlines(), ["tick 16: - p(@0, 1)", "tick 16: + p(@0, 3)", "tick 20: - p(@0, 3)", "tick 20: + p(@0, 4)"])

    def test_colours_stay(self):
        self.write("c.meld", "type linear once(node).\nonce(A).\nonce(A) -o setColor(A, 255, 0, 0).\n")
        self.keep("c.meld", 3, "--record", "r")
        self.write("e.meld", "type q(node).\n" + self.read("c.meld").decode())
        self.fork("--program", "e.meld", "--ticks", 5, "--record", "r2", "-n", 2)
        with h5py.File(self.folder / "r2") as file:
            colours = file["VTKHDF/PointData/colour"][...]
        self.assertTrue((colours == [255, 0, 0]).all(), colours)

    def test_hand_written_modules_keep_what_they_have(self):
        self.write("t.toml", square(4) + '[components]\nthermometer = "drift"\n')
        program = "type sensed temperature(node, first float).\ntype warm(node, float).\nwarm(A, X) :- temperature(A, X).\n"
        self.write("t.meld", program)
        self.keep("t.meld", 10, world="t.toml")
        self.write("u.meld", program.replace("warm(A, X) :-", "warm(A, X + 1.0) :-"))
        wanted = self.fresh("u.meld", "--ticks", 30, world="t.toml")
        for processes in (1, 2):
            self.assertEqual(self.forked("--program", "u.meld", "--ticks", 30, "-n", processes)[1], wanted)

    def test_bodies_go_on(self):
        """What moves does not depend on the program here, and what it senses now the other did not."""
        self.write("b.toml", self.read("doze.toml").decode())
        self.write("b.meld", "type source(node).\ntype high(node, float).\nhigh(A, Z) :- position(A, _, _, Z).\n")
        self.keep("b.meld", 12, world="b.toml")
        self.write("c.meld", self.read("b.meld").decode() + "type fast(node, vec3).\nfast(A, V) :- velocity(A, V).\n")
        wanted = self.fresh("c.meld", "--ticks", 30, world="b.toml")
        # Velocities are sensed when they have changed enough, from when they are sensed on.
        slow = lambda facts: [f for f in facts if f.startswith(("high", "source"))]
        for processes in (1, 2):
            facts = self.forked("--program", "c.meld", "--ticks", 30, "-n", processes)[1]
            self.assertEqual(slow(facts), slow(wanted))
            self.assertTrue(any(f.startswith("fast") for f in facts))


class OtherWorld(Case):
    PROGRAM = "const STEP = 1.\n" + GRADIENT.replace("D + 1", "D + STEP")

    def setUp(self):
        super().setUp()
        self.write("grid.toml", GRID)
        self.write("g.meld", self.PROGRAM)

    def test_constants(self):
        self.keep("g.meld", 40, world="grid.toml")
        wanted = self.fresh("g.meld", "--set", "STEP=4", world="grid.toml")
        about, facts = self.forked("--set", "STEP=4")
        self.assertEqual((facts, about["changed"]), (wanted, ["the parameters"]))

    def test_events_after_the_end(self):
        """The run had come to rest, and goes on for what happens later. What is past is past."""
        self.keep("g.meld", 40, world="grid.toml")
        wanted = self.fresh("g.meld", world="grid.toml")
        events = ('[[event]]\ntick = 7\ngive = { source = "id == 33" }\n', '[[event]]\ntick = 50\ntake = { source = "id == 0" }\n'
                  'give = { source = "id == 59" }\n')
        self.write("one.toml", GRID + events[0])
        about, facts = self.forked("--world", "one.toml")
        self.assertEqual((facts, about["changed"], about["anew"]), (wanted, ["[[event]] of the world"], False))
        self.write("two.toml", GRID + "".join(events))
        self.write("there.toml", GRID.replace("id == 0", "id == 59"))
        summary = self.fork("--world", "two.toml", "--facts-out", "forked", "-n", 2)
        self.assertEqual(self.facts_of(self.read("forked")), self.fresh("g.meld", world="there.toml"))
        self.assertGreater(summary["ticks"], 50)
        self.write("bad.toml", GRID + '[[event]]\ntick = 60\ngive = { sauce = "id == 0" }\n')
        self.refused("meldsim", "fork", "kept", "--world", "bad.toml", "--quiet", code=2, says=["no predicate sauce", "source"])

    def test_seed(self):
        self.write("r.meld", "type linear go(node).\ntype action print(node, string).\ngo(@0).\n"
                             "go(A) -o print(A, int2str(randint(1000000))), go(A)@+1.\n")
        self.keep("r.meld", 3)
        said = [self.call("meldsim", "fork", "kept", "--ticks", 8, "--quiet", "--seed", seed)[0] for seed in (1, 2, 1)]
        whole = self.call("meldsim", "run", "r.meld", "--world", "w.toml", "--ticks", 8, "--quiet")[0]
        self.assertTrue(whole.endswith(said[0]))
        self.assertEqual(said[0], said[2])
        self.assertNotEqual(said[0], said[1])

    def test_target(self):
        self.write("in.meld", "type inside(node).\ntype beside(node, int).\ninside(A) :- target(A).\nbeside(A, P) :- target(A, P).\n")
        world = GRID.replace("[facts]\nsource = \"id == 0\"\n", "")
        self.write("a.toml", world + '[target]\nshape = "box(3, 3, 1)"\n')
        self.write("b.toml", world + '[target]\nshape = "box(12, 2, 1)"\n')
        self.keep("in.meld", 5, world="a.toml")
        about, facts = self.forked("--world", "b.toml")
        self.assertEqual((facts, about["changed"]), (self.fresh("in.meld", world="b.toml"), ["[target] of the world"]))

    def test_what_cannot_change(self):
        self.keep("g.meld", 5, world="grid.toml")
        for old, new, says in (('"box(12, 5, 1)"', '"box(12, 6, 1)"', "[[body]] of the world is not as it was"),
                               ('"square"', '"cubic"', "lattice of the world is not as it was"),
                               ('"id == 0"', '"id == 1"', "[facts] of the world is not as it was"),
                               ("[facts]", "[motion]\nkind = \"lattice\"\n[facts]", "[motion] of the world is not as it was"),
                               ("[facts]", "[time]\ntick = \"2ms\"\n[facts]", "[time] of the world is not as it was")):
            with self.subTest(says):
                self.assertIn(old, GRID)
                self.write("other.toml", GRID.replace(old, new))
                self.refused("meldsim", "fork", "kept", "--world", "other.toml", "--quiet", code=DAMAGED, says=[says, "only [[event]]"])
        # Comments and layout say nothing.
        self.write("other.toml", "# the same\n" + GRID.replace(" = ", "="))
        self.assertEqual(self.forked("--world", "other.toml")[0]["changed"], [])


class Refusals(Case):
    def test_no_checkpoint(self):
        self.refused("meldsim", "fork", "nowhere", code=DAMAGED, says=["there is no checkpoint in", "nowhere", "meldsim run --checkpoint"])

    def test_damage(self):
        self.call("meldsim", *until(100), *KEEP)
        place = self.shares()[-1]
        place.write_bytes(place.read_bytes()[:-1])
        for n in (1, 2):
            err = self.call("meldsim", "fork", "kept", "--ticks", 90, "--quiet", "-n", n)[1]
            self.assertIn("warning: a newer checkpoint is not whole, and the run branches off from that of tick 80", err)
        for place in self.shares():
            place.write_bytes(b"")
        self.refused("meldsim", "fork", "kept", code=DAMAGED, says=["no checkpoint in", "is whole"])

    def test_it_writes_elsewhere(self):
        self.call("meldsim", *until(20), "--checkpoint", "kept")
        before = self.bytes_in("kept"), self.outcome()
        for option, file, theirs in (("--digest", "d", "--digest"), ("--facts-out", "f", "--facts-out"), ("--record", "r", "--record"),
                                     ("--digest", "f", "--facts-out")):
            self.refused("meldsim", "fork", "kept", option, file, "--quiet", code=2,
                         says=f"{theirs} of the run in kept and {option} are the same file")
        self.refused("meldsim", "fork", "kept", "--checkpoint", "kept", code=2, says=["has checkpoints of an earlier run"])
        self.assertEqual((self.bytes_in("kept"), self.outcome()), before)


if __name__ == "__main__":
    main("meldc", "meldsim")
