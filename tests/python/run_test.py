"""Runs and sweeps from Python: what they are made from, how they end, and what is left of them.

    run_test.py --meldsim PATH [unittest options]
"""
import gc
import os
import pathlib
import signal
import subprocess
import sys
import threading
import time
import tomllib
import unittest
import warnings

import networkx
import numpy
import pandas

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from frame import FOREVER, OPEN_MPI, TOOLS, Case, main, square  # noqa: E402
from running import children, stat  # noqa: E402

import claymeld  # noqa: E402
from claymeld.data.sources import literal, toml  # noqa: E402

GRADIENT = """type source(node).
type dist(node, min int D).
dist(A, 0)     :- source(A).
dist(B, D + 1) :- neighbor(A, B), dist(A, D).
"""
LINE = {"lattice": "square", "body": {"shape": "box(6, 1, 1)"}, "facts": {"source": "id == 0"}}
PLAIN = {"lattice": "square", "body": {"shape": "box(6, 1, 1)"}}


class Runs(Case):
    FILES = {"dir é/gradient.meld": GRADIENT, "dir é/gradient.toml": toml(LINE), "forever.meld": FOREVER, "w.toml": square(3)}

    def setUp(self):
        super().setUp()
        os.environ.update(OPEN_MPI, CLAYMELD_MELDSIM=TOOLS.meldsim)
        here = os.getcwd()
        os.chdir(self.folder)
        self.addCleanup(os.chdir, here)

    def fails(self, kind, says, *arguments, **options):
        with self.assertRaises(kind) as raised:
            claymeld.run(*arguments, **options)
        for text in [says] if isinstance(says, str) else says:
            self.assertIn(text, str(raised.exception))
        return raised.exception


class Sources(Runs):
    def test_programs_and_worlds_come_as_paths_texts_and_dicts(self):
        program = pathlib.Path("dir é/gradient.meld")
        wanted = list(range(6))
        for given, world in ((program, None), (str(program), program.with_suffix(".toml")), (GRADIENT, LINE), (GRADIENT, toml(LINE)),
                             (GRADIENT.replace("\n", " ").strip(), {**LINE, "body": [LINE["body"]]})):
            run = claymeld.run(given, world)
            self.assertEqual((run.ended, run.summary["catoms"], run.facts("dist")["D"].tolist()), ("quiet", 6, wanted))
            self.assertEqual(list(run.facts()), ["dist", "source"])
        # Without a world there are 1,000 catoms, and nobody is a source.
        self.assertEqual(claymeld.run(GRADIENT, every=5).summary["catoms"], 1000)
        self.assertEqual(claymeld.run("type p(node). p(A) :- id(A, 7).").facts("p")["catom"].tolist(), [7])

    def test_what_is_recorded_is_chosen_in_any_world(self):
        (self.folder / "cells.csv").write_text("0,0\n1,0\n2,0\n")
        for world in (LINE, toml(LINE), {**LINE, "record": {"every": 1, "predicates": ["source"]}}, "dir é/gradient.toml",
                      {**LINE, "body": {"cells": "cells.csv"}}):
            recording = claymeld.run(GRADIENT, world, every=2, predicates=["dist"]).recording
            self.assertEqual((recording.predicates, recording.ticks.tolist()[:3]), (["dist"], [0, 2, 4]))
        self.assertEqual(claymeld.run(GRADIENT, {**LINE, "body": {"cells": "cells.csv"}}, ticks=0).summary["catoms"], 3)
        # Lines of a world that is given as text are those of messages about it.
        self.fails(claymeld.WorldError, "world.toml:1:11: there is no lattice 'cubik'", GRADIENT, 'lattice = "cubik"\n', every=2)
        self.fails(claymeld.WorldError, "world.toml:2:1", GRADIENT, 'radius = 1\n= 3', every=2)

    def test_constants_and_arguments(self):
        program = """const limit = 3. const name = "a". const shift = 0.5. const list = [1]. const flag = false.
type p(node, int, string, float, list int, bool). p(A, limit + @arg1, name, shift, list, flag) :- id(A, 0)."""
        run = claymeld.run(program, square(1), constants={"limit": 5}, name='q"\\\n', shift=1e-07, list=numpy.array([4, 5]), flag=True,
                           arguments=[numpy.int64(10)])
        self.assertEqual(run.facts("p").iloc[0].tolist(), [0, 15, 'q"\\\n', 1e-07, [4, 5], True])
        vector = claymeld.Literal("vec3(0.0, 1.0, 2.0)")
        self.assertEqual([literal(value) for value in (True, -3, 1e300, 2.0, (1, "é"), {2}, [[]], vector)],
                         ["true", "-3", "1.0e+300", "2.0", ':(1, "é")', "{2}", "[[]]", "vec3(0.0, 1.0, 2.0)"])
        for value in (float("nan"), None, object()):
            with self.assertRaises((TypeError, ValueError)):
                literal(value)

    def test_files_that_a_world_names_are_found(self):
        self.write("there/e.csv", "0,1\n1,2\n")
        self.write("there/n.csv", "node,x,y\n0,0,0\n1,1,1\n2,2,2\n")
        self.write("there/cells.csv", "x,y,z\n0,0,0\n1,0,0\n")
        self.write("there/t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
        self.write("there/other.meld", GRADIENT)
        solid = "mesh({0}there/t.obj{0}, size = 4)"
        for catoms, world in (
                (3, {"lattice": "graph", "links": "there/e.csv", "nodes": "there/n.csv"}),
                (2, {"body": [{"cells": "there/cells.csv"}], "program": {"where": "id == 1", "file": "there/other.meld"}}),
                (None, {"body": {"shape": f"union({solid.format(chr(39))}, {solid.format(chr(34))})"}, "facts": {"source": "id == 0"}}),
                (8, {"body": {"shape": "box(2, 2, 2)"}, "facts": {"source": [f"inside({solid.format(chr(39))})"]}})):
            run = claymeld.run(GRADIENT, world)
            self.assertIn(run.summary["catoms"], (catoms,) if catoms else range(1, 1000))
            # The same as a file in the folder of what it names, with something to be recorded.
            self.write("there/w.toml", toml(world).replace("there/", ""))
            self.assertEqual(claymeld.run(GRADIENT, "there/w.toml", every=1, predicates=["dist"]).summary["catoms"], run.summary["catoms"])

    def test_worlds_as_toml(self):
        world = {"lattice": "é\"\\\n\x7f", "seed": 3, "x": 0.1, "ok": True,
                 "facts": {"a b": ["id == 0", {"where": "x < 1", "args": [1.5, "s"]}]},
                 "body": [{"cells": [[0, 0], [1, 0]]}, {"shape": "s"}], "motion": {}, "none": []}
        self.assertEqual(tomllib.loads(toml(world)), world)
        world = {"a": numpy.arange(2), "p": pathlib.Path("x"), "t": (1, 2)}
        self.assertEqual(tomllib.loads(toml(world)), {"a": [0, 1], "p": "x", "t": [1, 2]})
        for world, says in (({"facts": {"source": None}}, "the world's facts.source is None, and a world has no value like it"),
                            ({"facts": {"p": [{"args": [1, None]}]}}, r"the world's facts.p\[0\].args\[1\] is None"),
                            ({"record": {0: 1}}, "the world's record has the key 0 of type int, and the keys of a world are text. "
                                                 "Write '0'"),
                            ({("a", "b"): 1}, r"the world has the key \('a', 'b'\) of type tuple"),
                            ({"event": [{"give": {3: "all"}}]}, r"the world's event\[0\].give has the key 3"),
                            ({"links": networkx.path_graph(3)}, "the world's links is a graph, a Graph. Write `links = G.edges`"),
                            ({"seed": 1j}, "the world's seed is 1j")):
            with self.assertRaisesRegex(claymeld.WorldError, says):
                toml(world)

    def test_worlds_of_other_packages(self):
        graph = networkx.DiGraph([(0, 1), (1, 2), (2, 0)])
        pairs = [[0, 1], [1, 2], [2, 0]]
        for edges in (graph.edges, graph.edges(), graph.edges(data=False), list(graph.edges), graph.edges.keys(), set(graph.edges),
                      numpy.array(graph.edges), numpy.array(graph.edges, dtype=object), pandas.DataFrame(pairs).to_numpy(),
                      (pair for pair in pairs), networkx.MultiDiGraph(graph).edges()):
            self.assertEqual(tomllib.loads(toml({"links": edges})), {"links": pairs}, edges)
        for number in (numpy.int8(3), numpy.uint64(3), numpy.array(3), numpy.float64(3.0), numpy.float32(3.0), numpy.longlong(3)):
            self.assertEqual(tomllib.loads(toml({"a": number, "b": [number], "c": {"d": number}, "e": [{"f": number}]})),
                             {"a": 3, "b": [3], "c": {"d": 3}, "e": [{"f": 3}]}, repr(number))
        mixed = {"a": numpy.bool_(True), "s": numpy.str_("x"), "r": range(3), "k": {"x": 1}.keys(), "v": pandas.Series([1, 2])}
        self.assertEqual(tomllib.loads(toml(mixed)), {"a": True, "s": "x", "r": [0, 1, 2], "k": ["x"], "v": [1, 2]})
        self.assertEqual(tomllib.loads(toml({numpy.str_("lattice"): "graph"})), {"lattice": "graph"})
        run = claymeld.run("type far(node, node).\nfar(A, B) :- neighbor(A, B).\n",
                           {"lattice": "graph", "links": networkx.cycle_graph(5).edges, "seed": numpy.int64(2)})
        self.assertEqual(len(run.facts("far")), 10)


class Endings(Runs):
    def test_errors_have_kinds_messages_and_codes(self):
        problem = self.fails(claymeld.ProgramError, ["error[E0110]", "program.meld:1:5"], "p(A :- q(A).")
        self.assertEqual((problem.exit_code, problem.command[1], problem.run.ended), (1, "run", "failed"))
        self.fails(claymeld.WorldError, ["dir é/none.meld"], "dir é/none.meld")
        self.fails(claymeld.WorldError, ["no constant 'rate'"], GRADIENT, LINE, rate=3)
        self.fails(claymeld.ProgramError, "10 is divided by zero", "type p(node, int).\np(A, 10 / (2 - T)) :- tick(A, T).",
                   options=["--strict"])
        self.write("broken.so", "no module")
        self.fails(claymeld.ModuleRefused, "broken.so", "broken.so")
        problem = self.fails(claymeld.LimitReached, "[limits] max_ticks", FOREVER, {**PLAIN, "limits": {"max_ticks": 4}})
        self.assertEqual(problem.run.recording.ticks.tolist(), [0, 1, 2, 3, 4])
        self.fails(claymeld.LimitReached, "time limit", FOREVER, "w.toml", timeout=0.3)
        self.fails(claymeld.ToolNotFound, "'/no/meldsim' is no program", GRADIENT, meldsim="/no/meldsim")

    def test_properties(self):
        run = claymeld.run(GRADIENT, LINE, until="dist(A, D), D > 2", expect="dist(A, 3)")
        self.assertEqual((run.ended, run.facts("dist")["D"].max()), ("watched", 3))
        problem = self.fails(claymeld.PropertyFailed, "it does not hold: dist(A, 9)", GRADIENT, LINE, until="dist(A, D), D > 2",
                             expect=["dist(A, 3)", "dist(A, 9)"], never="dist(A, 1)")
        self.assertEqual([name for name, _ in problem.failures], ["expect: dist(A, 9)", "never: dist(A, 1)"])
        self.assertEqual(len(problem.run.facts("dist")), 4)

    def test_what_catoms_print_and_warnings(self):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            run = claymeld.run('type action print(node, string).\nprint(A, "{") :- id(A, 2).\nprint(A, "warning") :- id(A, 1).', PLAIN,
                               record=False, facts=False)
        self.assertEqual((run.output.splitlines(), caught), (["@1: warning", "@2: {"], []))
        with self.assertRaisesRegex(ValueError, "record=False"):
            run.recording
        with self.assertWarnsRegex(claymeld.MeldWarning, r"^warning\[W0406\][^$]*program.meld:1:7"):
            claymeld.run("const unused = 3.\ntype p(node). p(A) :- id(A, 7).", PLAIN)

    def test_temporary_files_go_with_what_needs_them(self):
        run = claymeld.run(GRADIENT, LINE)
        recording = run.recording
        folder = pathlib.Path(recording.path).parent
        del run
        gc.collect()
        self.assertEqual(len(recording.facts("dist", 3)), 3)
        recording.close()
        del recording
        gc.collect()
        self.assertFalse(folder.exists())
        claymeld.run(GRADIENT, LINE, record="kept ü.vtkhdf", facts="facts/")
        gc.collect()
        self.assertEqual(len(claymeld.open("kept ü.vtkhdf").frame()), len(claymeld.facts("facts", "dist")))

    def test_ctrl_c_ends_the_run_and_keeps_its_recording(self):
        self.write("stop.py", "import claymeld\ntry:\n    claymeld.run('forever.meld', 'w.toml', record='r.vtkhdf', processes=PROCESSES)\n"
                   "except KeyboardInterrupt as stop:\n"
                   "    print(stop.run.ended, stop.run.recording.ticks[-1] == stop.run.summary['ticks'], len(stop.run.facts('p')))\n")
        for processes in (1, 2):
            (self.folder / "r.vtkhdf").unlink(missing_ok=True)
            self.write("stop.py", self.read("stop.py").decode().replace("PROCESSES", str(processes)))
            process = self.begin(sys.executable, "-B", "stop.py", stdout=subprocess.PIPE, text=True, start_new_session=True,
                                 preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler))
            self.wait_for(lambda: (self.folder / "r.vtkhdf").exists() and (self.folder / "r.vtkhdf").stat().st_size > 1 << 16, process)
            os.killpg(process.pid, signal.SIGINT)
            self.assertEqual(process.communicate(timeout=20)[0], "interrupted True 9\n")

    def test_no_run_outlives_python(self):
        process = self.begin(sys.executable, "-B", "-c", "import claymeld; claymeld.run('forever.meld', 'w.toml', record='r.vtkhdf')")
        self.wait_for((self.folder / "r.vtkhdf").exists, process)
        child, = children(process.pid)
        process.kill()
        self.wait_for(lambda: (stat(child) or ["Z"])[0] == "Z", seconds=20)

    def test_progress_is_one_line_where_it_is_asked_for(self):
        ask = "import claymeld; claymeld.run('forever.meld', 'w.toml', ticks=30000, record=False, progress={})"
        for progress, shown in (("None", False), ("True", True), ("False", False)):
            _, err = self.call(sys.executable, "-B", "-c", ask.format(progress))
            self.assertEqual("tick " in err, shown, err)
            self.assertNotIn("\x1b", err)
        self.assertNotIn("\n", err.rstrip("\r\n"))

    def test_threads(self):
        sizes, runs = range(2, 8), {}

        def one(side):
            runs[side] = claymeld.run(GRADIENT, {**LINE, "body": {"shape": f"box({side}, 1, 1)"}})

        threads = [threading.Thread(target=one, args=(side,)) for side in sizes]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual({side: len(run.recording.facts("dist")) for side, run in runs.items()}, {side: side for side in sizes})


class Sweeps(Runs):
    def test_grid(self):
        program = "const far = 1.\ntype hit(node, int).\nhit(A, I) :- id(A, I), I % far = 0."
        worlds = {"small": PLAIN, "none": {"body": {"shape": "bix(1, 1, 1)"}}}
        frame = claymeld.sweep(program, worlds, {"far": [1, 2, 0]}, seeds=2, measure=lambda run: {"hits": len(run.facts("hit"))}, workers=4)
        self.assertEqual(frame[["world", "far", "seed"]].values.tolist(),
                         [[world, far, seed] for world in worlds for far in (1, 2, 0) for seed in (1, 2)])
        small = frame[frame["world"] == "small"]
        self.assertEqual(small["hits"].fillna(-1).tolist(), [6, 6, 3, 3, -1, -1])
        self.assertEqual(small["error"].fillna("").tolist(), [""] * 4 + ["ProgramError"] * 2)
        self.assertIn("divided by zero", small["message"].iloc[-1])
        self.assertEqual(set(frame[frame["world"] == "none"]["error"]), {"WorldError"})
        self.assertEqual(list(frame.columns[-2:]), ["error", "message"])

    def test_nothing_else_is_needed(self):
        frame = claymeld.sweep(pathlib.Path("dir é/gradient.meld"), pathlib.Path("dir é/gradient.toml"))
        self.assertEqual((len(frame), frame["world"][0], frame["ticks"][0] > 5, frame["error"][0]), (1, "dir é/gradient.toml", True, None))
        frame = claymeld.sweep(GRADIENT, [LINE, LINE], [{}], ticks=2, measure=lambda run: {}["missing"])
        self.assertEqual((frame["world"].tolist(), set(frame["error"])), ([0, 1], {"KeyError"}))
        frame = claymeld.sweep(GRADIENT, {"lattice": "graph", "graph": "ring(8)"})
        self.assertEqual((frame["world"].tolist(), frame["catoms"].tolist()), ([0], [8]))

    def test_a_study(self):
        """The file that `meldsim sweep` reads. A row that has failed is a row."""
        self.write("flood.meld", GRADIENT)
        self.write("study.toml", 'program = "flood.meld"\nseeds = 2\n[world]\nlattice = "graph"\ngraph = "ring({n})"\n[set]\nn = [8, 16]\n'
                                 '[measure]\nsize = "catoms"\n[expect]\nsmall = "count : { id(_, _) } = 8"\n')
        for workers in (None, 1):
            frame = claymeld.sweep("study.toml", workers=workers)
            self.assertEqual(frame[["n", "seed", "size", "status"]].values.tolist(),
                             [[8, 1, 8, "fine"], [8, 2, 8, "fine"], [16, 1, 16, "failed"], [16, 2, 16, "failed"]])
        with self.assertRaises(TypeError):
            claymeld.sweep("study.toml", seeds=3)
        self.write("study.toml", "program = 7\n")
        with self.assertRaisesRegex(claymeld.WorldError, "study.toml:1:11: program is an integer"):
            claymeld.sweep("study.toml")

    def test_ctrl_c_ends_all(self):
        self.write("stop.py", "import claymeld\ntry:\n    claymeld.sweep('forever.meld', 'w.toml', seeds=20, workers=2)\n"
                   "except claymeld.Interrupted:\n    print('ended')\n")
        process = self.begin(sys.executable, "-B", "stop.py", stdout=subprocess.PIPE, text=True,
                             preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler))
        tasks = pathlib.Path(f"/proc/{process.pid}/task")
        self.wait_for(lambda: sum(len((task / "children").read_text().split()) for task in tasks.iterdir()) == 2, process)
        time.sleep(0.5)
        process.send_signal(signal.SIGINT)
        self.assertEqual(process.communicate(timeout=20)[0], "ended\n")


if __name__ == "__main__":
    unittest.TestCase.maxDiff = None
    main("meldsim")
