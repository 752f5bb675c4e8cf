"""`meldsim debug`: `save` writes a checkpoint of the run that goes on as if nobody had walked through it, and `reload` goes on with a
program that has changed as `meldsim fork` does.

    debug_state_test.py --meldc PATH --meldsim PATH [unittest options]
"""
import json
import shutil
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from debug_test import EXAMPLES, OWN, ROOT, DebugTest  # noqa: E402
from frame import COUNT, main, square  # noqa: E402

# Views while catoms move, linear facts that wait, bodies, and a component with a state.
RUNS = ((OWN / "storm.meld", None, 9, 24), (OWN / "waiting.meld", None, 11, 30),
        (ROOT / "tests/programs/bodies/crowd.meld", OWN / "heap.toml", 5, 12), (EXAMPLES / "thermometer.meld", None, 7, 20))
SPREAD = """type linear token(node, int).
type visited(node, int).
type best(node, max int).
token(@0, 0).
token(A, N), neighbor(A, B), N < 50 -o visited(A, N), token(B, N + 1).
best(A, N) :- visited(A, N).
best(B, N) :- neighbor(A, B), best(A, N).
"""
CHANGED = SPREAD.replace("max int", "min int").replace("visited(A, N).\nbest(B", "visited(A, N), N > 3.\nbest(B") + \
    "type many(node, count int).\nmany(A, 1) :- visited(A, _).\n"


class StateTest(DebugTest):
    def digests(self, program, ticks, *options):
        lines = self.call("meldsim", "run", program, "--ticks", ticks, "--quiet", "--digest", "-", *options)[0].splitlines()
        return {int(t): d for _, t, d in (line.split() for line in lines if line.startswith("tick "))}

    def manifest(self, folder, tick):
        text = (self.folder / folder / f"{tick}.checkpoint.json").read_text()
        return json.loads(text[:text.rstrip().rindex("\n")])

    def resumed(self, folder, ticks, processes=1):
        """The digest after this tick, of a copy that goes on."""
        copy = self.folder / "copy"
        shutil.copytree(self.folder / folder, copy)
        out, _ = self.call("meldsim", "resume", copy, "-n", processes, "--ticks", ticks, "--quiet")
        digest = self.manifest("copy", ticks)["digest"]
        shutil.rmtree(copy)
        return digest, out

    def serve(self, *arguments):
        """A session that forgives mistakes; each call gives a command and returns the answer."""
        run = self.begin("meldsim", "debug", *arguments, "--served", stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

        def ask(command):
            run.stdin.write(command + "\n")
            run.stdin.flush()
            return json.loads(run.stdout.readline())
        return ask


class Save(StateTest):
    def test_it_goes_on_as_the_run_does(self):
        for i, (program, world, tick, last) in enumerate(RUNS):
            options = ["--world", world] if world else []
            digests = self.digests(program, last, *options)
            for processes in (1, 2):
                with self.subTest(program=program.name, processes=processes):
                    folder = f"kept {i} {processes}"
                    commands = [f"to {last}", f"to {tick}", f"save {folder}", "where"]
                    *_, saved, at = self.answers(commands, program, "-n", processes, *options)
                    self.assertEqual(saved, {"saved": str(self.folder / folder), "tick": tick, "digest": at["digest"], "events": None})
                    self.assertEqual(digests[tick], at["digest"])
                    for n in (1, 2, 3) if i == 0 or processes == 2 else (1,):
                        self.assertEqual(self.resumed(folder, last, n)[0], digests[last])

    def test_other_commands_take_it(self):
        program = OWN / "storm.meld"
        digests = self.digests(program, 15)
        self.answers(["to 9", "save kept"], program, "-n", 2, "--ticks", 15)
        self.call("meldsim", "fork", "kept", "--quiet", "--digest", "d", "--ticks", 15)
        self.assertIn(digests[15], self.read("d").decode())
        self.assertEqual(self.answers(["to 12", "where"], "kept")[1]["digest"], digests[12])
        rows = json.loads(self.call("meldsim", "query", "kept", "neighborCount(A, N)", "--json")[0])["rows"]
        self.assertEqual(rows, self.answers(["to 9", "query neighborCount(A, N)"], program)[1]["rows"])
        # A session of a checkpoint saves as well, whatever its run has written.
        self.call("meldsim", "run", program, "--ticks", 5, "--quiet", "--checkpoint", "of run", "--record", "r.vtkhdf", "--expect",
                  "neighborCount(_, _)")
        self.answers(["to 8", "save again", "to 11", "save later"], "of run", "--ticks", 15)
        for folder in ("again", "later"):
            self.assertEqual(self.resumed(folder, 15)[0], digests[15])

    def test_before_the_first_tick(self):
        digests = self.digests(OWN / "storm.meld", 6)
        self.answers(["save kept"], OWN / "storm.meld", "-n", 2)
        self.assertEqual(self.resumed("kept", 6)[0], digests[6])

    def test_a_watch_goes_on(self):
        self.write("w.meld", "type action watch(node, string).\ntype p(node, int).\nwatch(@0, \"p\").\np(@0, T / 10) :- tick(@0, T).\n")
        for processes in (1, 2):
            self.answers(["to 15", f"save kept{processes}"], "w.meld", "--ticks", 30, "-n", processes)
            self.assertEqual(self.resumed(f"kept{processes}", 21)[1].splitlines(), ["tick 20: - p(@0, 1)", "tick 20: + p(@0, 2)"])

    def test_what_was_done_by_hand(self):
        self.write("n.meld", "type wall(node).\ntype d(node, min int).\nd(A, 0) :- wall(A).\nd(B, D + 1) :- neighbor(A, B), d(A, D).\n")
        self.write("n.toml", square(5))
        for processes in (1, 2):
            with self.subTest(processes=processes):
                events, folder = f"events{processes}.toml", f"kept{processes}"
                commands = ["to 2", "give wall(@3)", "to 6", "give wall(@20)", "take wall(@3)", "save-events " + events, f"save {folder}",
                            "to 7", f"save {folder} later"]
                answers = self.answers(commands, "n.meld", "-n", processes)
                self.assertEqual(answers[6]["events"], str(self.folder / folder / "by-hand.toml"))
                self.assertIsNone(answers[8]["events"])
                both = self.write("both.toml", self.read("n.toml") + self.read(events))
                digests = self.digests("n.meld", 12, "--world", both)
                self.assertEqual(self.digests("n.meld", 12, "--events", events), digests)
                for n in (1, 2, 3):
                    shutil.rmtree(self.folder / "copy", ignore_errors=True)
                    self.assertEqual(self.resumed(folder + " later", 12, n)[0], digests[12])
                self.call("meldsim", "resume", folder, "-n", 3, "--ticks", 12, "--quiet")
                self.assertEqual(self.manifest(folder, 12)["digest"], digests[12])

    def test_events_of_a_file(self):
        self.write("c.toml", square(2))
        self.write("c.meld", "type wall(node).\ntype p(node).\np(A) :- wall(A).\n")
        self.write("e.toml", "[[event]]\ntick = 2\ngive = { wall = \"id == 1\" }\n")
        self.write("more.toml", "[limits]\nmax_ticks = 9\n")
        self.write("bad.toml", "[[event]]\ntick = 0\n")
        run = ("meldsim", "run", "c.meld", "--quiet", "--facts-out", "-")
        self.assertIn("p(@1).", self.call(*run, "--events", "e.toml")[0])
        self.refused(*run, "--events", "more.toml", code=2, says="--events more.toml: there is more than [[event]] tables in it")
        self.refused(*run, "--events", "bad.toml", code=2, says="--events: bad.toml:")
        self.refused(*run, "--events", "none.toml", code=2, says="none.toml")

    def test_refusals(self):
        program, world = self.write("c.meld", COUNT), self.write("c.toml", square(3))
        self.call("meldsim", "run", program, "--quiet", "--checkpoint", "kept")
        self.call("meldsim", "run", program, "--quiet", "--checkpoint", "counted", "--stats")
        self.call("meldsim", "run", program, "--quiet", "--record", "r.vtkhdf")
        before = self.files()
        for processes in (1, 2):
            self.refuses(["save kept"], program, "-n", processes, says="has checkpoints of an earlier run")
            self.refuses(["save counted2"], "counted", "-n", processes, says="counts what its rules do")
            self.refuses(["save new"], "r.vtkhdf", "-n", processes, says="the run of a recording cannot be saved")
        self.refuses(["save /proc/none"], program, says="/proc/none")
        self.refuses(["save"], program, says="save: the folder is missing")
        self.assertEqual(self.files(), before)
        self.answers(["step", "save saved"], program)
        program.write_text(COUNT + "// changed\n")
        self.refused("meldsim", "resume", "saved", code=6, says="the program")
        served = self.serve(program)
        served("step")
        world.write_text(square(4))
        self.assertIn("the world", served("save other")["error"])


class Reload(StateTest):
    def setUp(self):
        super().setUp()
        self.write("s.toml", square(6))
        self.write("s.meld", SPREAD)

    def test_it_goes_on_as_a_fork_does(self):
        self.call("meldsim", "run", "s.meld", "--ticks", 20, "--checkpoint", "kept", "--quiet")
        self.write("changed.meld", CHANGED)
        about = json.loads(self.call("meldsim", "fork", "kept", "--program", "changed.meld", "--digest", "d", "--json")[0])["forked"]
        forked = {int(t): d for _, t, d in (line.split() for line in self.read("d").decode().splitlines() if line.startswith("tick "))}
        for processes, history in ((1, "1GiB"), (2, "0"), (3, "1")):
            with self.subTest(processes=processes):
                self.write("s.meld", SPREAD)
                ask = self.serve("s.meld", "-n", processes, "--history", history)
                ask("to 30")
                self.assertEqual(ask("to 20")["tick"], 20)
                self.write("s.meld", CHANGED)
                done = ask("reload")
                self.assertEqual((done["tick"], done["reloaded"], done["gone"]), (20, True, []))
                for key in ("taken_over", "dropped", "derived_anew"):
                    self.assertEqual(done[key], about[key])
                self.assertIn("derived anew: best, many\n", done["text"])
                start = ask("where")
                self.assertEqual((start["tick"], start["first_tick"]), (20, 20))
                for tick in (23, 21, 35, 20, 22):
                    self.assertEqual(ask(f"to {tick}")["tick"], tick)
                    self.assertEqual(ask("where")["digest"], forked[tick] if tick > 20 else start["digest"])
                self.assertIn("The program was read again there", ask("to 19")["suggestion"])
                self.assertEqual(ask("query many(@0, N)")["columns"][0]["name"], "N")
                ask("to 25")
                saved = ask(f"save saved{processes}")
                self.assertEqual(saved["digest"], forked[25])
                for n in (1, 2, 3):
                    self.assertEqual(self.resumed(f"saved{processes}", 40, n)[0], forked[40])

    def test_a_program_that_does_not_compile_changes_nothing(self):
        for processes in (1, 2):
            self.write("s.meld", SPREAD)
            ask = self.serve("s.meld", "-n", processes)
            ask("to 5")
            before = ask("where")["digest"]
            self.write("s.meld", SPREAD + "best(A, N) :- vsited(A, N).\n")
            wrong = ask("reload")
            self.assertEqual(wrong["code"], 1)
            self.assertIn("error[E0301]", wrong["suggestion"])
            self.assertIn("did you mean `visited`?", wrong["suggestion"])
            self.write("s.meld", SPREAD.replace("visited(node, int)", "visited(node, float)").replace("visited(A, N)", "visited(A, 0.5)")
                       .replace("best(A, N) :- visited(A, 0.5)", "best(A, 1) :- visited(A, _)"))
            wrong = ask("reload")
            self.assertEqual(wrong["code"], 6, wrong)
            self.assertIn("facts of visited(node, int)", wrong["error"])
            self.assertIn("now declares visited(node, float)", wrong["error"])
            self.assertEqual([ask("where")["digest"], ask("back 2")["tick"], ask("to 5")["tick"]], [before, 3, 5])
            self.assertEqual(ask("where")["digest"], before)
            self.write("s.meld", SPREAD)
            same = ask("reload")
            self.assertEqual((same["reloaded"], same["text"]), (False, "tick 5: the program is the one that there was\n"))
            self.assertEqual(ask("back")["tick"], 4)

    def test_in_a_script_it_ends_the_session(self):
        run = self.begin("meldsim", "debug", "s.meld", stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        run.stdin.write("step\n")
        run.stdin.flush()
        self.assertEqual(run.stdout.readline(), "tick 1\n")
        self.write("s.meld", "type")
        out, err = run.communicate("reload\nstep\n", timeout=60)
        self.assertEqual((run.returncode, out), (1, ""))
        self.assertTrue(err.startswith("meldsim: standard input:2: the program is not as it can be run"), err)
        self.assertIn("error[", err)

    def test_breaks_and_what_was_done_by_hand(self):
        ask = self.serve("s.meld", "-n", 2)
        ask("break best if N > 40")
        ask("break 6")
        ask("watch visited(@3, N)")
        ask("delete 1")
        ask("watch best(A, 49)")
        ask("to 2")
        ask("give token(@7, 30)")
        ask("to 4")
        ask("give visited(@8, 44)")
        self.write("s.meld", CHANGED.replace("best", "least"))
        done = ask("reload")
        self.assertEqual([b["what"] for b in done["gone"]], ["best(A, 49)"])
        self.assertIn("gone: 4: watch best(A, 49)\n", done["text"])
        self.assertEqual([(b["number"], b["what"]) for b in ask("breaks")["breaks"]], [(2, "6"), (3, "visited(@3, N)")])
        ask("delete all")
        self.assertEqual(len(ask("events")["events"]), 2)
        ask("step")
        self.assertEqual(ask("query visited(@8, 44)")["rows"], [[]])
        # An event that the new program does not know has happened, or is to happen.
        self.write("s.meld", CHANGED.replace("visited", "seen"))
        self.assertEqual(ask("reload")["dropped"].keys(), {"visited"})
        ask("give seen(@1, 5)")
        self.write("s.meld", CHANGED)
        self.assertIn("seen", ask("reload")["error"])
        ask("step")
        self.assertTrue(ask("reload")["reloaded"])
        self.assertEqual(ask("save-events all.toml")["events"], 3)

    def test_what_cannot_be_read_again(self):
        self.call("meldsim", "run", "s.meld", "--ticks", 5, "--quiet", "--record", "r.vtkhdf", "--checkpoint", "kept")
        self.refuses(["reload"], "r.vtkhdf", says="a recording carries its program")
        self.call("meldc", "compile", "s.meld", "-o", "s.so")
        self.refuses(["reload"], "s.so", "--world", "s.toml", says="the session runs a module")
        # A checkpoint's run has a program of its own, in its folder.
        ask = self.serve("kept", "-n", 2, "--ticks", 9)
        ask("where")
        self.write("s.meld", CHANGED)
        self.assertEqual(ask("reload")["derived_anew"], ["best", "many"])
        self.assertEqual(ask("step")["tick"], 6)


if __name__ == "__main__":
    main("meldc", "meldsim")
