"""Recordings in Python: what is in them, what is asked of their runs, what is shown of them; and files that are none.

    recording_test.py --meldsim PATH [unittest options]
"""
import concurrent.futures
import os
import pathlib
import pickle
import re
import sys
import threading

import h5py
import numpy
import pandas

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from frame import FOREVER, OPEN_MPI, TOOLS, Case, main  # noqa: E402

import claymeld  # noqa: E402
from claymeld import pictures  # noqa: E402
from claymeld.data.sources import toml  # noqa: E402
from claymeld.tool import calls  # noqa: E402

PROGRAM = """type source(node).
type ok(node, bool).
ok(A, H > 2) :- dist(A, H, _).
type mark(node).
type dist(node, min int Hops, node Via).
type half(node, max float).
type far(node).
type name(node, max string).
type push(node, first vec3).
type seen(node).
type near(node, node Who).
type parts(node, list int, set string, :(int, float)).
dist(A, 0, A)     :- source(A).
dist(B, D + 1, A) :- neighbor(A, B), dist(A, D, _).
half(A, int2float(D) / 2.0) :- dist(A, D, _).
far(A)            :- dist(A, D, _), D > 3.
name(A, "a, \\"b\\"") :- dist(A, D, _), D > 1.
push(A, vec3(1.0, 2.5, int2float(D))) :- dist(A, D, _).
near(A, B)        :- neighbor(A, B), source(A).
parts(A, [1, 2], list2set(["x"]), :(D, 0.5)) :- dist(A, D, _), D = 4.
seen(A)           :- mark(A).
setColor(A, 10 * D, 20, 30) :- dist(A, D, _).
setLabel(A, "s")  :- source(A).
"""
WORLD = {"lattice": "square", "body": {"shape": "box(4, 2, 1)"}, "facts": {"source": "id == 0"},
         "event": [{"tick": 4, "every": 3, "times": 2, "give": {"source": "id == 7"}, "take": {"source": "id == 0"}},
                   {"time": "6ms", "give": {"mark": "id == 1"}}, {"tick": 900, "give": {"mark": "id == 1"}}]}
PREDICATES = ["dist", "half", "far", "name", "push", "near"]


class Recorded(Case):
    @classmethod
    def setUpClass(cls):
        os.environ.update(OPEN_MPI, CLAYMELD_MELDSIM=TOOLS.meldsim)
        cls.run_ = claymeld.run(PROGRAM, WORLD, every=2, predicates=PREDICATES, ticks=11)
        cls.recording = cls.run_.recording

    @classmethod
    def tearDownClass(cls):
        cls.recording.close()


class Reads(Recorded):
    def test_ticks_are_labels(self):
        recording = self.recording
        self.assertEqual(recording.ticks.tolist(), [0, 2, 4, 6, 8, 10, 11])
        self.assertEqual([recording.step_of(tick) for tick in (None, 0, 4, 11, -1, -7)], [6, 0, 2, 6, 6, 0])
        for method, steps in (("pad", [0, 2, 5, 6]), ("backfill", [1, 3, 5, None]), ("nearest", [0, 2, 5, 6])):
            for tick, step in zip((1, 5, 10, 99), steps):
                with self.subTest(method=method, tick=tick):
                    if step is not None:
                        self.assertEqual(recording.step_of(tick, method), step)
                    else:
                        self.assertRaises(KeyError, recording.step_of, tick, method)
        for ticks, steps in ((slice(4, 10), [2, 3, 4, 5]), (slice(3, 7), [2, 3]), (slice(None, -2), list(range(6))), (slice(50, 60), []),
                             ("all", list(range(7))), ([2, -1], [1, 6]), (slice(None, None, 3), [0, 3, 6])):
            self.assertEqual(recording.steps_of(ticks), steps)
        with self.assertRaisesRegex(KeyError, "tick 5 is not recorded; next to it are 4 and 6"):
            recording.frame(5)
        with self.assertRaisesRegex(KeyError, "there is no step -8"):
            recording.frame(-8)
        with self.assertRaisesRegex(ValueError, "method is 'before'"):
            recording.frame(5, "before")

    def test_frame(self):
        frame = self.recording.frame(4)
        self.assertEqual({name: str(kind) for name, kind in frame.dtypes.items()},
                         {"catom": "int64", "x": "float32", "y": "float32", "z": "float32", "red": "uint8", "green": "uint8",
                          "blue": "uint8", "label": "object", "dist.Hops": "Int64", "dist.Via": "Int64", "half": "float64",
                          "far": "bool", "name": "object",
                          "push.x": "float64", "push.y": "float64", "push.z": "float64", "near.facts": "int64"})
        self.assertEqual(frame.attrs["tick"], 4)
        # Each column says the same as the facts do.
        dist, name = (self.recording.facts(predicate, 4).set_index("catom") for predicate in ("dist", "name"))
        held = frame.set_index("catom")
        self.assertTrue(0 < len(dist) <= 8 and 0 < len(name) < 8)
        self.assertEqual(held["dist.Hops"].dropna().astype("int64").to_dict(), dist["Hops"].to_dict())
        self.assertEqual(held["name"].dropna().to_dict(), name["arg1"].to_dict())
        self.assertEqual(held["half"].dropna().to_dict(), (dist["Hops"] / 2).to_dict())
        first = self.recording.frame(0)
        self.assertEqual((first["dist.Hops"].isna().all(), first["push.x"].isna().all(), first["far"].any()), (True, True, False))
        self.assertEqual([tick for tick, _ in self.recording], self.recording.ticks.tolist())
        self.assertEqual([tick for tick, _ in self.recording.frames(slice(3, 8))], [4, 6, 8])

    def test_an_amoebot_may_have_two_cells(self):
        program = 'expand(A, 0) :- not expanded(A). contract(A, "head") :- expanded(A).'
        world = {"lattice": "hex", "body": {"cells": [[0, 0]]}, "motion": {"kind": "amoebot"}}
        with claymeld.run(program, world, every=1, ticks=4).recording as recording:
            frames = [frame for _, frame in recording]
            self.assertEqual([frame["x"][0] - frame["tail_x"][0] for frame in frames], [0, 0, 1, 0, 1])
            self.assertEqual([tuple(frame[["tail_y", "tail_z"]].iloc[0]) for frame in frames], [(0, 0)] * 5)
            axes = [recording.plot(tick) for tick in (1, 2)]
            self.assertEqual([len(ax.collections[1].get_segments()) for ax in axes], [0, 1])

    def test_bodies_that_are_no_spheres_have_their_shapes(self):
        program = "type up(node, max float).\nup(A, W) :- orientation(A, W, _, _, _).\n"
        # A box that falls freely, turned by a quarter about x, with a capsule and a ball beside it.
        world = {"body": {"positions": [[0, 0, 0], [5, 0, 0], [9, 0, 0]]}, "record": {"predicates": ["up"]},
                 "motion": {"kind": "bodies", "catoms": [
                     {"where": "id == 0", "shape": "box", "edges": [0.5, 2, 3], "rounding": 0.1, "turned": [90, 0, 0]},
                     {"where": "id == 1", "shape": "capsule", "length": 2}]}}
        parts = ["core_x", "core_y", "core_z", "rounding", "orientation_w", "orientation_x", "orientation_y", "orientation_z"]
        half = 0.5 ** 0.5
        with claymeld.run(program, world, every=1, ticks=4).recording as recording:
            for tick, frame in recording:
                self.assertEqual(list(frame.columns), ["catom", *"xyz", "red", "green", "blue", *parts, "up"])
                self.assertTrue(all(frame[name].dtype == "float64" for name in parts))
                self.assertTrue(numpy.allclose(frame[parts].iloc[0], [0.15, 0.9, 1.4, 0.1, half, half, 0, 0]), tick)
                self.assertTrue(numpy.allclose(frame[parts].iloc[1], [0, 0, 0.5, 0.5, 1, 0, 0, 0]), tick)
                self.assertEqual(frame[parts].iloc[2].tolist(), [0, 0, 0, 0.5, 1, 0, 0, 0])
                if tick > 0:
                    self.assertEqual(frame["up"].tolist(), frame["orientation_w"].tolist())
            # As thick as they are, in space also if all are in one plane.
            axes = recording.plot(0)
            self.assertEqual(axes.name, "3d")
            sizes = numpy.sqrt(axes.collections[0].get_sizes())
            self.assertTrue(numpy.allclose(sizes / sizes[2], [0.5, 1, 1]))
        # What a program calls so is a predicate, where there are no shapes.
        self.assertEqual([name for name in self.recording.frame(0) if name.startswith(("core", "rounding", "orientation"))], [])
        with claymeld.run("type core(node, max int).\ncore(A, 3) :- id(A, _).\n", {"body": {"shape": "box(2, 1, 1)"}}, predicates=["core"],
                          ticks=2).recording as recording:
            self.assertEqual(recording.frame()["core"].tolist(), [3, 3])

    def test_joints_are_where_their_catoms_hold_them(self):
        """A pendulum, a rail aslant and a catom on a ball that is killed; and a hinge that breaks."""
        world = {"body": {"positions": [[0, 0, 0], [1, 0, 0], [0, 3, 0], [1, 3, 0], [0, 6, 0], [1, 6, 0], [0, 9, 0], [1, 9, 0]]},
                 "motion": {"kind": "bodies", "steps": 4, "catoms": [{"where": "x == 0", "fixed": True}],
                            "joint": [{"between": [0, 1], "anchor": [0, 0, 0], "axis": [0, 1, 0]},
                                      {"between": [2, 3], "kind": "slider", "axis": [0.6, 0, -0.8]},
                                      {"between": [4, 5], "kind": "ball"},
                                      {"between": [6, 7], "axis": [0, 1, 0], "breaking_force": 12}]},
                 "event": [{"tick": 15, "kill": "id == 5"}]}
        with claymeld.run("type here(node, float).\nhere(A, X) :- at(A, X, _, _).\n", world, every=10, ticks=30).recording as recording:
            first, last = recording.joints(0), recording.joints()
            self.assertEqual(first.attrs["tick"], 0)
            self.assertEqual(first["kind"].tolist(), ["hinge", "slider", "ball", "hinge"])
            self.assertEqual(first[["first", "second"]].to_numpy().tolist(), [[0, 1], [2, 3], [4, 5], [6, 7]])
            self.assertEqual([set(first["fate"]), last["fate"].tolist()], [{"holds"}, ["holds", "holds", "gone", "broken"]])
            self.assertTrue(numpy.allclose(first[["x", "y", "z"]], [[0, 0, 0], [0.5, 3, 0], [0.5, 6, 0], [0.5, 9, 0]], atol=1e-6))
            self.assertTrue(numpy.allclose(first.loc[:1, ["axis_x", "axis_y", "axis_z"]], [[0, 1, 0], [0.6, 0, -0.8]]))
            self.assertTrue(first.loc[2, ["axis_x", "axis_y", "axis_z"]].isna().all() and last.loc[2, ["x", "slid"]].isna().all())
            # The pendulum turns about where it hangs; the rail moves along its axis.
            self.assertTrue(numpy.allclose(last.loc[0, ["x", "y", "z"]].astype(float), [0, 0, 0], atol=1e-3))
            frame = recording.frame().set_index("catom")
            self.assertLess(frame.loc[1, "z"], -0.2)
            self.assertLess(frame.loc[1, "orientation_w"], 0.99)
            self.assertGreater(last.loc[1, "slid"], 0.2)
            self.assertAlmostEqual(frame.loc[3, "x"], 1 + 0.6 * last.loc[1, "slid"], places=3)
            self.assertRaises(KeyError, recording.joints, 5)
        self.assertEqual(self.recording.joints(0).shape, (0, 11))

    def test_facts_of_any_predicate_and_tick_are_those_of_the_run(self):
        """Whether they are in the file or are made again."""
        for tick in (0, 3, 5, 11):
            run = claymeld.run(PROGRAM, WORLD, ticks=tick, record=False)
            for name, frame in run.facts().items():
                pandas.testing.assert_frame_equal(self.recording.facts(name, tick), frame, obj=f"{name} in tick {tick}")
        self.assertEqual(list(self.recording.all_facts(4)), sorted([*PREDICATES, "mark", "ok", "parts", "seen", "source"]))
        every = self.recording.facts("dist", "all")
        self.assertEqual(every.groupby("tick").size().reindex(self.recording.ticks, fill_value=0).tolist(),
                         [len(self.recording.facts("dist", tick)) for tick in self.recording.ticks])
        self.assertEqual(self.recording.facts("source", [-1, 3])["tick"].tolist()[-1], 3)
        self.assertEqual(len(self.recording.facts("dist", [])), 0)
        with self.assertRaisesRegex(KeyError, "no facts named 'neighbor'; it has .*dist.*query"):
            self.recording.facts("neighbor")
        with self.assertRaisesRegex(KeyError, "ends with tick 11, before tick 12"):
            self.recording.facts("dist", 12)

    def test_metrics_and_events(self):
        metrics = self.recording.metrics()
        self.assertEqual(metrics.index.tolist(), self.recording.ticks.tolist())
        self.assertEqual((set(metrics["catoms"]), set(metrics["moved"])), ({8}, {0}))
        self.assertEqual(metrics["facts.dist"].tolist(), [len(self.recording.facts("dist", tick)) for tick in self.recording.ticks])
        self.assertEqual(metrics["facts.near"].tolist(), [len(self.recording.facts("near", tick)) for tick in self.recording.ticks])
        events = self.recording.events()
        self.assertEqual(events.values.tolist(), [
            [4, "take", "source", "id == 0"], [4, "give", "source", "id == 7"], [6, "give", "mark", "id == 1"],
            [7, "take", "source", "id == 0"], [7, "give", "source", "id == 7"]])
        program, world = self.write("p.meld", PROGRAM), self.write("w.toml", toml(WORLD))
        self.call("meldsim", "run", program, "--world", world, "--ticks", 11, "--digest", "d", "--quiet")
        digests = dict(line.split()[1:] for line in self.read("d").decode().splitlines())
        self.assertEqual(metrics["digest"].iloc[1:].tolist(), [digests[str(tick)] for tick in metrics.index[1:]])

    def test_events_are_in_the_ticks_of_the_run(self):
        """Times count the whole ticks that fit, in units of all kinds; other files of events count as well."""
        from claymeld.data.planned import events, seconds

        program = "type mark(node, int).\ntype on(node).\non(A) :- mark(A, _)."
        times = ["6.9ms", "7000us", 0.0085, "0.0001s", "9e-3s"]
        world = {"lattice": "square", "body": {"shape": "box(2, 1, 1)"}, "time": {"tick": "1ms"},
                 "event": [{"time": time, "give": {"mark": {"where": "id == 0", "args": [number]}}} for number, time in enumerate(times)]}
        more = self.write("more.toml", '[[event]]\ntick = 3\ngive = { mark = { where = "id == 1", args = [9] } }\n')
        recording = claymeld.run(program, world, options=["--events", more]).recording
        history = recording.history("mark(_, _)")
        came = dict(zip(history["fact"], history["tick"]))
        planned = recording.events()
        self.assertEqual({f"mark(@{row.what['where'][-1]}, {row.what['args'][0]})": row.tick for row in planned.itertuples()}, came)
        self.assertEqual(sorted(came.values()), [1, 3, 6, 7, 8, 9])
        bodies = {"motion": {"kind": "bodies"}, "event": {"time": "1s", "give": {"mark": "id == 0"}}}
        self.assertTrue(events(bodies, 9)["tick"].isna().all())
        self.assertEqual(events({**bodies, "motion": {"kind": "bodies", "step": 0.1, "steps": 2}}, 9)["tick"].tolist(), [5])
        self.assertEqual([seconds(time) for time in ("2", "1.5 min", "3h", 7)], [2, 90, 10800, 7])
        self.assertRaises(ValueError, seconds, "soon")
        dying = {"event": [{"tick": 2, "every": 3, "times": 2, "kill": [4, "x > 1"], "take": {"mark": "all"}}]}
        self.assertEqual(events(dying, 9).values.tolist(), [[2, "kill", None, [4, "x > 1"]], [2, "take", "mark", "all"],
                                                            [5, "kill", None, [4, "x > 1"]], [5, "take", "mark", "all"]])
        failing = {"event": {"tick": 4, "heal": "all", "hang": 3, "cut": [[1, 2]]}}
        self.assertEqual(events(failing, 9).values.tolist(), [[4, "hang", None, 3], [4, "cut", None, [[1, 2]]], [4, "heal", None, "all"]])

    def test_a_recording_that_is_being_written_is_read(self):
        self.write("w.toml", 'lattice = "square"\n[[body]]\nshape = "box(3, 3, 1)"\n[record]\nevery = 100\npredicates = ["p"]\n')
        run = self.begin("meldsim", "run", self.write("p.meld", FOREVER), "--world", "w.toml", "--record", "live.vtkhdf", "--quiet")
        self.wait_for(lambda: (self.folder / "live.vtkhdf").exists() and (self.folder / "live.vtkhdf").stat().st_size > 1 << 16, run)
        for _ in range(10):
            with claymeld.open(self.folder / "live.vtkhdf") as live:
                last = int(live.ticks[-1])
                # Nothing is derived before the first tick.
                said = [last] * 9 if last > 0 else []
                self.assertEqual((live.facts("p", last)["arg1"].tolist(), len(live.metrics())), (said, len(live)))
        run.kill()
        run.wait()
        with claymeld.open(self.folder / "live.vtkhdf") as killed:
            self.assertGreaterEqual(killed.ticks[-1], last)

    def test_what_is_half_written_is_read_again(self):
        whole = bytearray(pathlib.Path(self.recording.path).read_bytes())
        # Of each header of a group or column.
        half = bytearray(whole)
        for found in re.finditer(b"OHDR", whole):
            half[found.start() + 40] ^= 1

        def frame(then):
            self.write("half.vtkhdf", bytes(half))
            timer = threading.Timer(0.004, lambda: (self.folder / "half.vtkhdf").write_bytes(then))
            timer.start()
            try:
                with claymeld.open(self.folder / "half.vtkhdf") as recording:
                    return recording.frame(4)
            except claymeld.RecordingError as problem:
                return str(problem)
            finally:
                timer.join()

        self.assertRegex(frame(half), "half.vtkhdf (is damaged|cannot be read)")
        # On a machine that has other work the other half may come too late.
        for _ in range(20):
            found = frame(whole)
            if not isinstance(found, str):
                break
        self.assertNotIsInstance(found, str, found)
        pandas.testing.assert_frame_equal(found, self.recording.frame(4))

    def test_metrics_of_catoms_that_move_and_come(self):
        program = """type linear go(node).
go(@0).
go(A), id(A, 0) -o moveTo(A, 7, 0, 0)@+1.
create(A, 3) :- id(A, 1), tick(A, 2)."""
        world = {"lattice": "square", "body": {"cells": [[0, 0], [1, 0], [2, 0]]}, "motion": {"kind": "lattice"}, "held": 1}
        run = claymeld.run(program, world, ticks=6)
        metrics = run.recording.metrics()
        self.assertEqual(metrics["moved"].sum(), 1, metrics.to_string())
        self.assertEqual(metrics["catoms"].iloc[-1], 3 + metrics["appeared"].sum())

    def test_what_it_is_of(self):
        recording = self.recording
        self.assertEqual((recording.program, recording.world["lattice"]), (PROGRAM, "square"))
        self.assertEqual((recording.lattice, recording.seed), ("square", 1))
        self.assertEqual(recording.provenance["version"], claymeld.__version__)
        self.assertEqual(recording.command[1], "run")
        self.assertRegex(repr(recording), r"<Recording .*: 7 steps, ticks 0 to 11, 8 catoms, dist, half")
        again = pickle.loads(pickle.dumps(recording))
        pandas.testing.assert_frame_equal(again.frame(), recording.frame())
        again.close()
        with self.assertRaisesRegex(ValueError, "is closed"):
            again.frame()

    def test_threads(self):
        ticks = [tick for tick in range(12) for _ in range(2)]
        with concurrent.futures.ThreadPoolExecutor(4) as pool:
            counts = list(pool.map(lambda tick: len(self.recording.facts("dist", tick)), ticks))
        self.assertEqual(counts, [len(self.recording.facts("dist", tick)) for tick in ticks])


class Asks(Recorded):
    def test_text_in_many_threads(self):
        # h5py alone ends the process here, nearly always.
        self.addCleanup(sys.setswitchinterval, sys.getswitchinterval())
        sys.setswitchinterval(1e-5)
        path = self.folder / "facts.h5"
        self.write("w.toml", 'lattice = "square"\n[[body]]\nshape = "box(40, 40, 1)"\n[facts]\nsource = "id == 0"\n')
        self.call("meldsim", "run", self.write("p.meld", PROGRAM), "--world", "w.toml", "--facts-out", path, "--quiet")
        wanted = claymeld.facts(path, "name")
        with concurrent.futures.ThreadPoolExecutor(4) as pool:
            for found in pool.map(lambda _: claymeld.facts(path, "name"), range(200)):
                pandas.testing.assert_frame_equal(found, wanted)

    def test_query(self):
        found = self.recording.query("dist(A, D, B), D > 0, half(A, H), push(A, V), name(A, S), ok(A, F)")
        self.assertEqual({name: str(kind) for name, kind in found.dtypes.items()},
                         {"A": "int64", "D": "int64", "B": "int64", "H": "float64", "V.x": "float64", "V.y": "float64", "V.z": "float64",
                          "S": "object", "F": "bool"})
        self.assertEqual((set(found["S"]), set(found["V.y"]), found.attrs["tick"]), ({'a, "b"'}, {2.5}, 11))
        parts = self.recording.query("parts(A, L, S, P)")
        self.assertEqual(parts.iloc[0].tolist()[1:], [[1, 2], frozenset(["x"]), (4, 0.5)])
        pandas.testing.assert_frame_equal(parts.set_axis(["catom", "arg1", "arg2", "arg3"], axis=1), self.recording.facts("parts"))
        self.assertEqual(self.recording.query("dist(A, D, B), D > 99").shape, (0, 3))
        self.assertEqual(self.recording.query("-1 < D, dist(A, D, _)", 3).attrs["tick"], 3)
        self.assertEqual(self.recording.query("dist(A, D, _), X = 1 / D").attrs["left_out"], 1)
        with self.assertRaisesRegex(claymeld.WorldError, "did you mean `dist`"):
            self.recording.query("dits(A, D, B)")

    def test_why_and_history(self):
        dist = self.recording.facts("dist", 3)
        catom = dist["catom"][dist["Hops"] == 2].iloc[0]
        why = self.recording.why(f"dist(@{catom}, _, _)", 3)
        text = str(why)
        self.assertTrue(why)
        self.assertIn("dist(@7, 0", str(self.recording.why("dist(@7, _, _)")))
        self.assertRegex(text.splitlines()[0], rf"^dist\(@{catom}, 2, .*rank")
        self.assertIn("source(@0)  given", text)
        self.assertIn("source(@0)", why.facts())
        page = why._repr_html_()
        self.assertEqual((page.count("<details"), page.count("&lt;") > 0), (page.count("</details>"), "<" in text))
        none = self.recording.why("far(@0)", 1)
        self.assertEqual((bool(none), str(none)), (False, "far(@0)  does not hold in tick 1"))
        reason = self.recording.why_not("far(@0)", 1)
        self.assertTrue(reason)
        self.assertIn("far(@0)  does not hold", str(reason))
        self.assertIn("<code>", none._repr_html_())
        history = self.recording.history("source(_)")
        self.assertEqual(history[["tick", "fact", "change"]].values.tolist(),
                         [[0, "source(@0)", "there"], [4, "source(@0)", "went"], [4, "source(@7)", "came"]])
        lines = self.recording.history(f"dist(@{catom}, _, _)", 3)["line"].tolist()
        self.assertEqual(set(lines), {PROGRAM.split("\n").index("dist(B, D + 1, A) :- neighbor(A, B), dist(A, D, _).") + 1})

    def test_graph(self):
        try:
            import networkx
        except ImportError:
            self.skipTest("networkx is not installed")
        graph = self.recording.graph(tick=4)
        self.assertEqual((graph.number_of_nodes(), graph.number_of_edges()), (8, 20))
        frame = self.recording.frame(4).set_index("catom")
        self.assertEqual(graph.nodes[5]["pos"], tuple(frame.loc[5, ["x", "y", "z"]]))
        tree = self.recording.graph("dist", 3)
        dist = self.recording.facts("dist", 3)
        self.assertEqual({(a, b): hops for a, b, hops in tree.edges(data="Hops")},
                         {(a, via): hops for a, hops, via in dist.values.tolist()})
        lengths = networkx.single_source_shortest_path_length(graph, 0)
        self.assertTrue(all(lengths[a] == hops for a, hops, _ in dist.values.tolist()))
        self.assertEqual(self.recording.graph("neighbor(A, B), neighbor(B, C), dist(A, D, _)", multi=True).number_of_nodes(), 8)
        with self.assertRaisesRegex(ValueError, "no two catoms in 'half'"):
            self.recording.graph("half")


class Shows(Recorded):
    def test_shot(self):
        picture = self.recording.shot(3, size=(64, 48), colour="dist(A, D, _)", range=(0, 3), bare=True, title=None, ground=False)
        self.assertEqual((picture.png[:8], picture.size), (b"\x89PNG\r\n\x1a\n", (64, 48)))
        self.assertEqual(picture._repr_png_(), picture.png)
        self.assertEqual(self.recording.shot([0, "end"], size=(64, 48)).size, (64, 48))
        self.assertEqual(pictures.words_of({"catom_size": 0.5, "range": (-1, 2), "bare": True, "only": None, "azimuth": -60}),
                         ["--catom-size", "0.5", "--range=-1:2", "--bare", "--azimuth=-60"])
        with self.assertRaisesRegex(claymeld.WorldError, "did you mean '--colour'"):
            self.recording.shot(colur="dist(A, D, _)")

    def test_notebooks_show_a_page_or_a_picture(self):
        bundle = self.recording._repr_mimebundle_()
        self.assertEqual(set(bundle) - {"text/plain"}, {"text/html"} if calls.has("view", "--share") else {"image/png"})
        self.assertEqual(set(self.run_._repr_mimebundle_()), set(bundle))
        self.write("fake", FAKE).chmod(0o755)
        fake = claymeld.open(self.recording.path, meldsim=self.folder / "fake")
        page = fake._repr_mimebundle_()["text/html"]
        self.assertIn('srcdoc="&lt;p&gt;a &amp; &quot;b&quot;&lt;/p&gt;\n"', page)
        self.assertNotIn("allow-same-origin", page)
        self.assertIn("srcdoc", fake.share(self.folder / "page.html")._repr_html_())
        self.assertIn("data:video/mp4;base64,ZmlsbQo=", fake.movie(self.folder / "film.mp4", fps=3)._repr_html_())
        fake.close()
        # Without meldsim there is its text.
        nobody = claymeld.open(self.recording.path, meldsim="/no/meldsim")
        self.assertEqual(list(nobody._repr_mimebundle_()), ["text/plain"])
        self.assertIn("&lt;Recording", nobody._repr_html_())
        nobody.close()

    def test_what_this_meldsim_lacks_is_said(self):
        self.write("old", "#!/bin/sh\nexit 2\n").chmod(0o755)
        with claymeld.open(self.recording.path, meldsim=self.folder / "old") as old:
            self.assertRaisesRegex(claymeld.ToolNotFound, "no command movie", old.movie, "film.mp4")
            self.assertRaisesRegex(claymeld.ToolNotFound, "no `view --share`", old.share, "page.html")

    def test_plots(self):
        try:
            import matplotlib
        except ImportError:
            self.skipTest("matplotlib is not installed")
        matplotlib.use("Agg")
        import matplotlib.pyplot

        recording = self.recording
        frame = recording.frame(4)
        collection = recording.plot(4).collections[0]
        self.assertTrue(numpy.allclose(collection.get_facecolors()[:, :3] * 255, frame[["red", "green", "blue"]]))
        self.assertTrue(numpy.allclose([path.vertices[:4].mean(axis=0) for path in collection.get_paths()], frame[["x", "y"]]))
        for colour in ("half", "dist(A, D, _)", numpy.arange(8), frame.set_index("catom")["half"], "name", "far(A)", "far"):
            axes = recording.plot(4, colour)
            self.assertEqual((axes.get_title(), len(axes.collections[0].get_facecolors())), ("tick 4", 8))
        paints = recording.plot(4, "half", vmin=0, vmax=9).collections[0].get_facecolors()
        wanted = matplotlib.colormaps["viridis"](frame["half"][frame["half"].notna()] / 9)
        self.assertTrue(numpy.allclose(paints[frame["half"].notna()], wanted))
        self.assertTrue(numpy.allclose(recording.plot(0, "half").collections[0].get_facecolors()[:, :3], 0.69))
        self.assertRaisesRegex(KeyError, "no column .*hlaf", recording.plot, 4, "hlaf")
        self.assertRaisesRegex(ValueError, "3 values, and there are 8 catoms", recording.plot, 4, [1, 2, 3])
        axes = recording.plot_metrics()
        self.assertIn("facts.dist", [line.get_label() for line in axes.lines])
        matplotlib.pyplot.close("all")

    def test_only_catoms_that_are_seen_are_plotted(self):
        from claymeld.plots import exposed

        for lattice, neighbours in (("cubic", 6), ("fcc", 12)):
            run = claymeld.run("type n(node, int). n(A, N) :- neighborCount(A, N).",
                               {"lattice": lattice, "body": {"shape": "box(5, 5, 5)"}})
            frame = run.recording.frame()
            seen = exposed(frame[["x", "y", "z"]].to_numpy("float64"), lattice)
            self.assertEqual(seen.tolist(), (run.facts("n")["arg1"] < neighbours).tolist())
            self.assertLess(seen.sum(), len(seen))


# Has the commands that an older meldsim lacks.
FAKE = """#!/bin/sh
case "$1 $2" in
    "help "*) echo "Usage: meldsim $2 [OPTIONS] TARGET --share FILE" ;;
    "view "*) printf '<p>a & "b"</p>\\n' > "$4" ;;
    "movie "*) echo film > "$4" ;;
    *) exit 2 ;;
esac
"""


class Hostile(Recorded):
    def opened(self, name):
        recording = claymeld.open(self.folder / name)
        self.addCleanup(recording.close)
        return recording

    def test_files_that_are_none(self):
        self.write("text.vtkhdf", "hello")
        self.write("empty.vtkhdf", "")
        with h5py.File(self.folder / "other.h5", "w") as file:
            file["x"] = 1
        with h5py.File(self.folder / "hollow.h5", "w") as file:
            file.create_group("meld").attrs["format"] = "claymeld recording"
        (self.folder / "folder").mkdir()
        for name, says in (("text.vtkhdf", "no HDF5 file"), ("empty.vtkhdf", "no HDF5 file"), ("other.h5", "is no recording"),
                           ("hollow.h5", "is damaged"), ("folder", "cannot be read")):
            with self.subTest(name=name), self.assertRaisesRegex(claymeld.RecordingError, says):
                self.opened(name)
        self.assertRaisesRegex(FileNotFoundError, "there is no file .*none.vtkhdf", self.opened, "none.vtkhdf")

    def test_every_truncation_is_an_error_that_says_so(self):
        whole = pathlib.Path(self.recording.path).read_bytes()
        wanted = self.recording.frame(4)
        for size in range(0, len(whole), len(whole) // 40):
            self.write("cut.vtkhdf", whole[:size])
            try:
                pandas.testing.assert_frame_equal(self.opened("cut.vtkhdf").frame(4), wanted)
            except claymeld.RecordingError as problem:
                self.assertIn("cut.vtkhdf", str(problem))

    def test_changed_files(self):
        whole = pathlib.Path(self.recording.path).read_bytes()

        def changed(change):
            self.write("changed.vtkhdf", whole)
            with h5py.File(self.folder / "changed.vtkhdf", "r+") as file:
                change(file)
            return claymeld.open(self.folder / "changed.vtkhdf")

        def version(file):
            file["meld"].attrs["version"] = 3

        def no_colours(file):
            del file["VTKHDF/PointData/colour"]

        def far_away(file):
            file["VTKHDF/Steps/PointOffsets"][:] = 1 << 40

        def no_json(file):
            del file["meld/predicates"]
            file["meld/predicates"] = b"{nonsense"

        def too_many(file):
            file["VTKHDF/NumberOfPoints"][:] = 1 << 40

        self.assertRaisesRegex(claymeld.RecordingError, "of version 3, and this package reads versions 1 and 2", changed, version)
        self.assertRaisesRegex(claymeld.RecordingError, "is damaged", changed, no_json)
        for change in (no_colours, far_away, too_many):
            with self.subTest(change=change.__name__), changed(change) as recording:
                self.assertRaisesRegex(claymeld.RecordingError, "changed.vtkhdf is damaged", recording.frame)


if __name__ == "__main__":
    main("meldsim")
