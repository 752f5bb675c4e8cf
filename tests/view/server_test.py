"""meldsim view: what its server answers to pages, and that it is what the other commands say.

    server_test.py --meldc PATH --meldsim PATH [unittest options]
"""
import json
import pathlib
import struct
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import numpy as np  # noqa: E402

from frame import OPEN_MPI, main, square  # noqa: E402
from viewing import CORNER, PURPLE, YELLOW, Viewing  # noqa: E402
from websocket import get  # noqa: E402

MAGIC = 0x46444C4D


class Requests(Viewing):
    def test_hello_says_what_is_run(self):
        hello, _ = self.page(self.view("corner.meld", "--tick", 3)).ask("hello")
        expected = {"ok": True, "program": "corner.meld", "world": "corner.toml", "lattice": "square", "flat": True, "catoms": 36,
                    "tick": 3, "first": 0, "latest": 3, "last": None, "ended": None, "recorded": False, "live": True}
        self.assertEqual({key: hello[key] for key in expected}, expected)
        mine = {p["name"]: (p["arguments"], p["linear"]) for p in hello["predicates"] if p["own"]}
        self.assertEqual(mine, {"source": (0, False), "dist": (1, False), "token": (1, True)})
        self.assertIn("viridis", hello["maps"])

    def test_commands_answer_as_the_debugger_does(self):
        lines = ["step 2", "facts @7", "facts dist", "query dist(A, D), D > 1", "why dist(@7, _)", "why-not dist(@7, 1)", "run",
                 "history dist(@7, _)", "messages @1", "back 2", "give token(@0, 5)", "events", "step 3", "depends source(@0)", "diff 1",
                 "where", "nonsense", "to -1", "facts @99999", "query dist(A, D", "break dist", "breaks", "delete 1", "rules dist",
                 "until dist(A, 99)"]
        for processes in (1, 2):
            with self.subTest(processes=processes):
                self.write("lines.txt", "\n".join(lines))
                page = self.page(self.view("corner.meld", "-n", processes))
                for line in lines:
                    said, _ = page.ask("command", line=line)
                    self.write("one.txt", "\n".join([*self.done(lines, line), line]))
                    if not said["ok"]:
                        expected = self.debug("one.txt", code=None)[-1]
                        self.assertEqual({"error": said["error"]["message"], "suggestion": said["error"]["hint"],
                                          "code": said["error"]["code"]}, expected, line)
                        continue
                    expected = self.debug("one.txt")[-1]
                    for each in (expected, said["answer"]):
                        each.pop("history_bytes", None)
                        each.pop("snapshots", None)
                    self.assertEqual(said["answer"], expected, line)
                self.assertLess(self.interrupt(), 5)

    @staticmethod
    def done(lines, line):
        """What was done before that line and changes what it says, or the snapshots, which a question about dependents adds to."""
        moves = ("step", "run", "back", "give", "until", "break ", "delete", "depends")
        return [each for each in lines[:lines.index(line)] if each.startswith(moves)]

    def debug(self, script, code=0):
        done = self.run_tool("meldsim", "debug", "corner.meld", "--json", "--quiet", "--commands", script)
        if code is not None:
            self.assertEqual(done.returncode, code, done.stderr)
        return [json.loads(line) for line in done.stdout.splitlines()]

    def test_lines_have_the_colours_of_their_numbers(self):
        """What the connections of a row that is held at its end carry: each a weight more than the next one."""
        self.write("row.meld", "type carries(node, float).\nconnect(A, B) :- neighbor(A, B).\ncarries(A, S) :- load(A, _, _, S, _).\n")
        self.write("row.toml", "[[body]]\npositions = [[0, 0, 5], [1, 0, 5], [2, 0, 5], [3, 0, 5]]\n[motion]\nkind = 'bodies'\n"
                               "[[motion.catoms]]\nwhere = 'id == 0'\nfixed = true\n")
        page = self.page(self.view("row.meld", "--tick", 20))
        body = "load(A, B, _, Shear, _), A < B"
        loads = page.ask("command", line=f"query {body}")[0]["answer"]["rows"]
        self.assertEqual([(row[0], row[1]) for row in sorted(loads)], [(0, 1), (1, 2), (2, 3)])
        for look, ends in (({"links": body}, [PURPLE, YELLOW]), ({"arrows": body}, [PURPLE, YELLOW]),
                           ({"links": body, "colour": "id(A, N)"}, []), ({"links": "load(A, B, _, _, _), A < B"}, [])):
            said, block = page.ask("frame", look=look)
            head = struct.unpack_from("<16I", block)
            self.assertEqual((head[4], head[6] + head[7]), (4, 3), look)
            strokes = [struct.unpack_from("<6f4B", block, 64 + 24 * 4 + 28 * i) for i in range(3)]
            colours = {round(stroke[0]): stroke[6:9] for stroke in strokes}
            # The greatest load is where the row is held.
            if ends:
                self.assertEqual([colours[2], colours[0]], ends, look)
                self.assertEqual(said["legend"]["title"], "Shear")
                scale = said["legend"]["scale"]
                self.assertAlmostEqual(scale["high"] / scale["low"], 3, delta=0.02)
            else:
                self.assertEqual(len(set(colours.values())), 1, look)

    def test_frames_have_the_places_and_the_colours(self):
        page = self.page(self.view("corner.meld"))
        said, block = page.ask("frame", tick=4, look={"colour": "dist(A, D)", "links": "neighbor(A, B)"})
        self.assertEqual((said["tick"], said["catoms"], said["shown"]), (4, 36, 36))
        self.assertEqual(page.event("moved")["tick"], 4)
        head = struct.unpack_from("<16I", block)
        self.assertEqual(head[:5], (MAGIC, 2, 4, 0, 36))
        self.assertEqual(said["legend"]["title"], "D")
        # Those that are shown, the others, and what is wrong.
        self.assertEqual(page.ask("frame", look={"only": "dist(A, 2)"})[0]["shown"], 3)
        self.assertEqual(page.ask("frame", look={"hide": "dist(A, 2)"})[0]["shown"], 33)
        for look, message in (({"colour": 7}, '"colour" is no string'), ({"colours": "x"}, '"colours"'),
                              ({"map": "pink"}, '"pink"'), ({"range": [3, 1]}, "range"), ("x", "no object")):
            said, block = page.ask("frame", look=look)
            self.assertFalse(said["ok"])
            self.assertIsNone(block)
            self.assertIn(message, said["error"]["message"])
        self.assertEqual(page.ask("command", line="where")[0]["tick"], 4)

    def test_frames_come_without_bodies_that_are_wrong(self):
        for options in ([], ["-n", "2"]):
            page = self.page(self.view("corner.meld", *options, environment=OPEN_MPI))
            whole, plain = page.ask("frame", tick=4)
            self.assertEqual(whole["mistakes"], [])
            # A mistake in the body; and what is right in Meld, and no colour, line or label.
            for body, lacks in (("dsit(A, D)", "did you mean `dist`?"), ("1 = 1", "no variable is ")):
                for name in ("colour", "only", "hide", "links", "arrows", "labels"):
                    said, block = page.ask("frame", look={name: body})
                    self.assertTrue(said["ok"], said)
                    self.assertEqual((said["tick"], said["shown"], block), (4, 36, plain), f"{name} {options}")
                    (mistake,) = said["mistakes"]
                    self.assertTrue(mistake["message"].startswith(f"{name}: "), mistake)
                    self.assertIn(lacks, mistake["message"])
                    if not options:
                        said, png = page.ask("image", look={name: body}, size=[60, 40], camera={})
                        self.assertEqual((said["mistakes"], png[1:4]), ([mistake], b"PNG"))
            # The others count, and the run goes on.
            said, _ = page.ask("frame", tick=6, look={"only": "dist(A, 2)", "colour": "dsit(A, D)", "labels": "dsit(A, D)"})
            self.assertEqual((said["tick"], said["shown"], len(said["mistakes"])), (6, 3, 2))
            self.interrupt()

    def test_what_is_hidden_is_left_out_of_large_frames(self):
        self.write("cube.toml", '[[body]]\nshape = "box(8, 8, 8)"\n[facts]\nsource = "id == 0"\n')
        page = self.page(self.view("corner.meld", "--world", "cube.toml"))

        def frame(**asked):
            said, block = page.ask("frame", **asked)
            self.assertTrue(said["ok"], said)
            count, flags = struct.unpack_from("<16I", block)[4:6]
            self.assertEqual((said["sent"], bool(flags & 2)), (count, count < said["shown"]))
            self.assertEqual(said["catoms"], 512)
            places = np.frombuffer(block, "<f4", 3 * count, 64).reshape(-1, 3)
            diameters = np.frombuffer(block, "<f4", count, 64 + 12 * count)
            ids = np.frombuffer(block, "<u4", count, 64 + 16 * count)
            self.assertTrue((np.diff(ids.astype(int)) > 0).all())
            covers = np.frombuffer(block, "<i1", 4 * count, 64 + 24 * count).reshape(-1, 4) if flags & 2 else None
            return said, places, diameters, covers

        self.assertEqual(len(frame()[1]), 512)
        # Two layers of balls are seen, the outer ones and those between them.
        said, places, diameters, covers = frame(most=500)
        self.assertEqual((said["coarse"], len(places)), (1, 8 ** 3 - 4 ** 3))
        self.assertEqual(set(diameters), {1})
        outer = np.abs(places - places.mean(axis=0)).max(axis=1) > 3
        self.assertEqual(outer.sum(), 8 ** 3 - 6 ** 3)
        # A corner has three neighbours of six, and they are on its inner side.
        corner = covers[(places == places.min(axis=0)).all(axis=1)][0]
        self.assertEqual([int(c) for c in corner], [42 + 0, 42, 42, 64])
        self.assertTrue((covers[~outer] == [0, 0, 0, 127]).all())
        # Where it is cut, what was inside is seen.
        cut = {"axis": 2, "at": float(places[:, 2].mean())}
        said, below, *_ = frame(most=100, look={"cut": cut})
        self.assertEqual(said["shown"], 256)
        self.assertLess(below[:, 2].max(), cut["at"] + 1)
        # Fewer than can be seen: balls of two diameters, or more.
        said, places, diameters, covers = frame(most=300)
        self.assertEqual((said["coarse"], len(places), set(diameters)), (2, 4 ** 3 - 2 ** 3, {2}))
        # In the end one for all.
        self.assertEqual(len(frame(most=1)[1]), 1)
        for wrong, message in (({"axis": 3, "at": 0}, "axis"), ({"axes": 0}, '"axes"'), ("x", "no object")):
            self.assertIn(message, page.ask("frame", look={"cut": wrong})[0]["error"]["message"])
        self.assertIn("sphere, cube", page.ask("frame", look={"form": "ball"})[0]["error"]["hint"])
        self.assertEqual(struct.unpack_from("<16I", page.ask("frame", look={"form": "rounded"})[1])[9], 4)

    def test_obstacles_are_in_frames(self):
        self.write("fall.meld", "type seen(node).\nseen(A) :- id(A, 0).\n")
        self.write("fall.toml", """
[[body]]
positions = [[0, 0, 3], [1, 0, 3]]
[motion]
kind = "bodies"
ground = -0.5
[[motion.obstacle]]
kind = "box"
centre = [3, 0, 0]
size = [1, 2, 1]
[[motion.obstacle]]
kind = "terrain"
centre = [5, 5, 0]
heights = [[0, 1, 0], [0, 0, 2]]
""")
        page = self.page(self.view("fall.meld"))
        _, block = page.ask("frame")
        count, triangles = struct.unpack_from("<16I", block)[4], struct.unpack_from("<16I", block)[10]
        self.assertEqual((count, triangles), (2, 2 + 12 + 4))
        corners = np.frombuffer(block, "<f4", 9 * triangles, len(block) - 36 * triangles).reshape(-1, 3, 3)
        self.assertTrue((corners[:2, :, 2] == -0.5).all())
        box = corners[2:14].reshape(-1, 3)
        self.assertEqual((box.min(axis=0).tolist(), box.max(axis=0).tolist()), ([2.5, -1, -0.5], [3.5, 1, 0.5]))
        self.assertEqual(sorted({tuple(at) for at in corners[14:].reshape(-1, 3).tolist()}),
                         [(5, 5, 0), (5, 6, 0), (6, 5, 1), (6, 6, 0), (7, 5, 0), (7, 6, 2)])

    def test_links_of_graphs_that_are_cut_are_shown_as_cut(self):
        self.write("ring.meld", CORNER)
        self.write("ring.toml", 'lattice = "graph"\ngraph = "ring(5)"\n[facts]\nsource = "id == 0"\n')
        for processes in (1, 2):
            page = self.page(self.view("ring.meld", "-n", processes))

            def strokes():
                _, block = page.ask("frame")
                head = struct.unpack_from("<16I", block)
                at = np.frombuffer(block, "<u1", 28 * head[6], 64 + 24 * head[4]).reshape(-1, 28)
                return head[6], int((at[:, 24] > 180).sum())

            self.assertEqual(strokes(), (5, 0))
            self.assertTrue(page.ask("command", line="cut @1 @2")[0]["ok"])
            page.ask("command", line="step")
            self.assertEqual(strokes(), (4 + 2, 2))
            page.ask("command", line="heal around @1")
            page.ask("command", line="step")
            self.assertEqual(strokes(), (5, 0))
            self.interrupt()

    def test_pictures_are_painted_here(self):
        page = self.page(self.view("corner.meld"))
        said, png = page.ask("image", tick=3, look={"colour": "dist(A, D)"}, size=[120, 80],
                             camera={"azimuth": -60, "elevation": 30, "angle": 25, "target": [0, 0, 0], "height": 6})
        self.assertEqual((said["width"], said["height"]), (120, 80))
        self.assertEqual(png[:8], b"\x89PNG\r\n\x1a\n")
        self.assertEqual(struct.unpack(">2I", png[16:24]), (120, 80))
        for wrong in ({"size": [1, 1]}, {"size": [9999, 9999]}, {"camera": {"angle": 500}}, {"camera": {"height": 3}}, {"camera": 3}):
            self.assertFalse(page.ask("image", **wrong)[0]["ok"], wrong)

    def test_play_waits_for_frames(self):
        page = self.page(self.view("corner.meld"))
        self.assertTrue(page.ask("play", speed=0, to=4)[0]["ok"])
        for tick in range(1, 5):
            self.assertEqual(page.event("moved")["tick"], tick)
            # Nothing goes on before it has been looked at.
            self.assertEqual(page.ask("command", line="where")[0]["tick"], tick)
            self.assertEqual(page.ask("frame")[0]["tick"], tick)
        stopped = page.event("stopped")
        self.assertEqual((stopped["why"], stopped["tick"]), ("end", 4))
        metrics, _ = page.ask("metrics")
        self.assertEqual(metrics["ticks"], [1, 2, 3, 4])
        self.assertEqual(metrics["series"]["catoms"], [36] * 4)
        self.assertEqual(page.ask("metrics", most=2)[0]["ticks"], [1, 3])
        # Slowly, and then not at all.
        page.ask("play", speed=20)
        begun = time.monotonic()
        for _ in range(3):
            page.event("moved")
            page.ask("frame")
        self.assertGreater(time.monotonic() - begun, 0.09)
        self.assertTrue(page.ask("pause")[0]["ok"])
        self.assertEqual(page.event("stopped")["why"], "paused")
        # A break ends it as well.
        page.ask("command", line="to 0")
        page.ask("command", line="watch dist(A, 2)")
        page.ask("play", speed=0)
        while not [said for said in page.news if said["event"] == "stopped"]:
            page.ask("frame")
        self.assertEqual(page.event("stopped")["why"], "stop")

    def test_frames_have_values(self):
        page = self.page(self.view("corner.meld", "--tick", 4))
        # Numbers; words; none; and numbers with more digits than a double has.
        for colour, expected in (("dist(A, D)", {0: 0, 1: 1}), ("source(A)", {0: "holds"}), ("", {}),
                                 ("id(A, I), N = I + 9007199254740992", {0: 2 ** 53, 1: str(2 ** 53 + 1)})):
            said, block = page.ask("frame", look={"colour": colour}, values=True)
            count, flags = struct.unpack_from("<16I", block)[4:6]
            ids = np.frombuffer(block, "<u4", count, 64 + 16 * count).tolist()
            at, found = 64 + 24 * count, {}
            if flags & 4:
                numbers = np.frombuffer(block, "<f8", count, at)
                found = {id: value for id, value in zip(ids, numbers) if not np.isnan(value)}
                at += 8 * count
            if flags & 8:
                words = np.frombuffer(block, "<u4", count, at)
                found |= {id: said["names"][word - 1] for id, word in zip(ids, words) if word}
            self.assertEqual({id: found.get(id) for id in expected}, expected)
            if colour == "dist(A, D)":
                rows = page.ask("command", line="query dist(A, D)")[0]["answer"]["rows"]
                self.assertEqual(found, dict(rows))
            # Who does not ask gets none.
            self.assertEqual(struct.unpack_from("<16I", page.ask("frame", look={"colour": colour})[1])[5], 0)
        # Those of catoms that are left out are left out too, and balls for several catoms have none.
        self.write("cube.toml", '[[body]]\nshape = "box(8, 8, 8)"\n[facts]\nsource = "id == 0"\n')
        page = self.page(self.view("corner.meld", "--world", "cube.toml", "--tick", 23))
        rows = dict(page.ask("command", line="query dist(A, D)")[0]["answer"]["rows"])
        for most, expected in ((500, rows), (300, {})):
            _, block = page.ask("frame", look={"colour": "dist(A, D)"}, values=True, most=most)
            count, flags = struct.unpack_from("<16I", block)[4:6]
            self.assertLess(count, 512)
            self.assertEqual(bool(flags & 4), bool(expected))
            ids = np.frombuffer(block, "<u4", count, 64 + 16 * count).tolist()
            for id, value in zip(ids, np.frombuffer(block, "<f8", count, 64 + 28 * count)) if expected else ():
                self.assertEqual(value, expected[id])

    def series(self, page, body, **more):
        """All of it, however many answers it takes."""
        while True:
            said, _ = page.ask("series", body=body, **more)
            if not said["ok"]:
                return said["error"]
            if said["done"]:
                return dict(zip(said["ticks"], said["values"]))

    def test_bodies_are_known_over_time(self):
        bodies = {"dist(A, D)": "count : { dist(A, D) }", "max D : { dist(A, D) }": "max D : { dist(A, D) }", "dist(@7, D)": "dist(@7, N)",
                  "token(A, _)": "count : { token(A, _) }"}
        found = []
        for options in ([], ["-n", "2"], ["-n", "3"], ["--history", "0"]):
            page = self.page(self.view("corner.meld", *options, environment=OPEN_MPI))
            page.ask("command", line="to 6")
            known = {body: self.series(page, body) for body in bodies}
            # Where the run is, does not change, and is the same from everywhere.
            self.assertEqual(page.ask("command", line="where")[0]["tick"], 6)
            page.ask("command", line="to 2")
            self.assertEqual({body: self.series(page, body) for body in bodies}, known)
            for tick in range(7):
                page.ask("command", line=f"to {tick}")
                for body, question in bodies.items():
                    line = f"query {question}" if body == "dist(@7, D)" else f"query N = {question}"
                    rows = page.ask("command", line=line)[0]["answer"]["rows"]
                    self.assertEqual(known[body][tick], rows[0][0] if rows else None, f"{options}, {body}, tick {tick}")
            # What is done by hand makes another future.
            page.ask("command", line="to 3")
            page.ask("command", line="give source(@35)")
            self.assertEqual(list(self.series(page, "dist(A, D)")), [0, 1, 2, 3])
            page.ask("command", line="to 6")
            after = self.series(page, "dist(A, D)")
            self.assertEqual([after[tick] for tick in range(4)], [known["dist(A, D)"][tick] for tick in range(4)])
            self.assertGreater(after[6], known["dist(A, D)"][6])
            found.append((known, after))
            for body, says in (("dsit(A, D)", "did you mean `dist`?"), ("dist(_, D)", "Aggregate them"), (" ", "empty")):
                error = self.series(page, body)
                self.assertIn(says, error["message"] + error["hint"])
            # Few points are every second, fourth or further tick, and the last.
            self.assertEqual(list(self.series(page, "dist(A, D)", most=3)), [0, 4, 6])
            self.interrupt()
        self.assertEqual(found, found[:1] * len(found))

    def test_long_runs_are_known_bit_by_bit_and_can_be_interrupted(self):
        page = self.page(self.view("forever.meld"))
        page.ask("command", line="to 600")
        page.news.clear()
        said, _ = page.ask("series", body="sum N : { p(A, N) }", most=10_000)
        self.assertTrue(said["ok"], said)
        if not said["done"]:
            self.assertLess(len(said["ticks"]), 601)
        known = self.series(page, "sum N : { p(A, N) }", most=10_000)
        self.assertEqual(list(known), list(range(601)))
        self.assertEqual([known[tick] for tick in (1, 2, 599, 600)], [1600 * tick for tick in (1, 2, 599, 600)])
        self.assertEqual({known[tick + 1] - known[tick] for tick in range(1, 600)}, {1600})
        # Nobody is told that the run is elsewhere.
        self.assertNotIn("progress", [said["event"] for said in page.news if said.get("tick", 600) < 600])
        # Another page's questions are answered meanwhile, and it ends when it is asked to.
        number = page.send("series", body="max N : { p(A, N) }", most=100_000)
        page.send("interrupt")
        said, _ = page.answer(number)
        self.assertTrue(said["ok"] or said["error"]["code"] == 130, said)
        self.assertTrue(page.ask("command", line="step")[0]["ok"])

    def test_a_recording_is_known_as_a_whole(self):
        self.call("meldsim", "run", "corner.meld", "--record", "corner.vtkhdf", "--quiet", "--ticks", 8)
        page = self.page(self.view("corner.vtkhdf"))
        self.assertEqual(self.series(page, "dist(A, D)"), dict(enumerate([0, 1, 3, 6, 10, 15, 21, 26, 30])))

    def test_several_pages_see_one_run(self):
        link = self.view("corner.meld")
        one, other = self.page(link), self.page(link)
        one.ask("command", line="step 3")
        self.assertEqual(other.event("moved")["tick"], 3)
        self.assertEqual(other.ask("frame", look={"only": "dist(A, 0)"})[0]["shown"], 1)
        self.assertEqual(one.ask("frame")[0]["shown"], 36)
        # The one who plays has gone, and nobody waits for its frames.
        one.ask("play", speed=0)
        one.close()
        self.assertEqual(other.event("stopped")["why"], "paused")

    def test_a_long_run_is_interrupted(self):
        for processes in (1, 2):
            with self.subTest(processes=processes):
                page = self.page(self.view("forever.meld", "-n", processes))
                number = page.send("command", line="run")
                self.assertGreater(page.event("progress")["tick"], 0)
                self.assertIn("tick ", page.event("progress")["text"])
                page.send("interrupt")
                said, _ = page.answer(number)
                self.assertTrue(said["ok"])
                self.assertEqual(said["answer"]["ended"], "interrupted")
                tick = said["tick"]
                # It goes on afterwards, also by playing, which ends in the same way.
                self.assertEqual(page.ask("command", line="step")[0]["tick"], tick + 1)
                page.ask("play", speed=1)
                page.send("interrupt")
                self.assertEqual(page.event("stopped")["why"], "interrupted")
                # Ctrl-C ends a viewer in the middle of a run.
                page.send("command", line="run")
                page.event("progress")
                self.assertLess(self.interrupt(), 5)

    def test_a_recording_is_shown(self):
        self.call("meldsim", "run", "corner.meld", "--record", "corner.vtkhdf", "--quiet", "--ticks", 8)
        page = self.page(self.view("corner.vtkhdf"))
        hello, _ = page.ask("hello")
        self.assertTrue(hello["program"].endswith("corner.vtkhdf"))
        self.assertEqual((hello["recorded"], hello["live"], hello["last"], hello["tick"]), (True, False, 8, 0))
        self.assertEqual(page.ask("frame", tick=5, look={"colour": "dist(A, D)"})[0]["tick"], 5)
        self.assertFalse(page.ask("command", line="give source(@5)")[0]["ok"])
        self.assertFalse(page.ask("world-save", toml=square(3))[0]["ok"])

    def test_two_runs_are_shown_beside_each_other(self):
        self.write("other.toml", self.read("corner.toml").replace(b"id == 0", b"id == 35"))
        for name in ("corner", "other"):
            self.call("meldsim", "run", "corner.meld", "--world", f"{name}.toml", "--record", f"{name}.vtkhdf", "--quiet")
        page = self.page(self.view("corner.vtkhdf", "other.vtkhdf"))
        for run, catom in enumerate((0, 35)):
            said, _ = page.ask("frame", run=run, tick=3, look={"only": "dist(A, 0)"})
            self.assertEqual((said["run"], said["tick"], said["shown"]), (run, 3, 1))
            said, _ = page.ask("command", run=run, line="query dist(A, 0)")
            self.assertEqual(said["answer"]["rows"], [[catom]])
        self.assertEqual(page.ask("command", run=1, line="step")[0]["tick"], 4)
        self.assertEqual(page.ask("command", line="where")[0]["tick"], 3)
        self.assertFalse(page.ask("hello", run=2)[0]["ok"])
        self.refused("meldsim", "view", "corner.vtkhdf", "other.vtkhdf", "-n", 2, "--for", 1, code=2, says="Leave out -n")

    def test_a_checkpoint_is_shown(self):
        self.call("meldsim", "run", "corner.meld", "--checkpoint", "kept", "--quiet", "--ticks", 5)
        page = self.page(self.view("kept"))
        self.assertEqual(page.ask("hello")[0]["tick"], 5)
        self.assertEqual(page.ask("frame")[0]["shown"], 36)
        self.assertEqual(page.ask("command", line="step")[0]["ok"], True)
        self.assertEqual(page.ask("frame", tick=5)[0]["tick"], 5)

    def test_a_program_that_has_changed_goes_on(self):
        page = self.page(self.view("corner.meld", "--tick", 2))
        program = self.read("corner.meld").decode()
        time.sleep(1)  # Two looks at the files.
        self.write("corner.meld", program + "this is no rule\n")
        said = page.event("reloaded")
        self.assertFalse(said["ok"])
        self.assertIn("corner.meld:7:", said["error"]["hint"])
        self.write("corner.meld", program + "type far(node).\nfar(A) :- dist(A, D), D > 8.\n")
        said = page.event("reloaded")
        self.assertTrue(said["ok"], said)
        self.assertEqual(page.ask("command", line="run")[0]["ok"], True)
        self.assertEqual(page.ask("command", line="query far(A)")[0]["answer"]["count"], 3)
        self.assertIn("far", {p["name"] for p in page.ask("hello")[0]["predicates"]})

    def test_worlds_of_bodies_are_seen_as_they_will_start(self):
        """Shapes, sizes and turns are those of a run's first frame, by cells, positions, groups and lists."""
        motion = '[motion]\nkind = "bodies"\nspacing = 2.5\n'
        body = '[[body]]\nshape = "box(9, 9, 1)"\n[[body]]\npositions = [[0, 0, 5], [0.5, 0, 8], [40, 0, 9]]\n'
        plain = body + motion + '[[motion.catoms]]\nwhere = "y > 1"\nradius = 0.7\n'
        shapes = plain + """[[motion.catoms]]
where = "y < 0"
shape = "box"
edges = [1, 2, 0.5]
turned = [0, 90, 0]
[[motion.catoms]]
where = "id == 83"
shape = "capsule"
length = 3
[[motion.catoms]]
where = "id == 82"
shape = "dumbbell"
[[motion.compound]]
name = "dumbbell"
[[motion.compound.part]]
shape = "sphere"
at = [-1, 0, 0]
[[motion.compound.part]]
shape = "sphere"
at = [1, 0, 0]
"""
        self.write("w.meld", "type seen(node).\nseen(A) :- id(A, 0).\n")
        for toml, flags in ((plain, 0), (shapes, 16)):
            self.write("w.toml", toml)
            page = self.page(self.view("w.meld"))
            frame, preview = page.ask("frame")[1], page.ask("world-check", toml=toml)[1]
            self.assertEqual(struct.unpack_from("<16I", preview)[4:6], (84, flags))
            self.assertEqual(preview, frame)
            if flags:
                bodies = np.frombuffer(preview, "<f4", 8 * 84, len(preview) - 32 * 84).reshape(-1, 8)
                self.assertEqual(len(set(map(tuple, bodies.tolist()))), 5)
                # The radius around it, and that it is the first compound of the list.
                self.assertEqual(bodies[82].tolist(), [1.5, 0, 0, -1, 0, 0, 0, 1])
                self.assertEqual(page.ask("frame")[0]["compounds"], [[[0, 0, 0, 0.5, at, 0, 0, 0, 0, 0, 1] for at in (-1, 1)]])
                self.assertEqual(bodies[83].tolist(), [0, 0, 1, 0.5, 0, 0, 0, 1])
            self.interrupt()

    def test_the_world_is_checked_and_written(self):
        page = self.page(self.view("corner.meld", "--world", "corner.toml"))
        now, block = page.ask("world")
        self.assertEqual(struct.unpack_from("<5I", block)[4], 36)
        self.assertIsNone(now["seconds"])
        page.ask("command", line="step 2")
        self.assertGreater(page.ask("world")[0]["seconds"], 0)
        self.assertEqual((now["toml"], now["catoms"], now["valid"], now["writable"]), (self.read("corner.toml").decode(), 36, True, True))
        self.assertLess(now["memory"]["least"], now["memory"]["most"])
        said, block = page.ask("world-check", toml=square(20))
        self.assertEqual(struct.unpack_from("<5I", block)[4], 400)
        self.assertEqual((said["valid"], said["catoms"]), (True, 400))
        said, _ = page.ask("world-check", toml='lattice = "square"\n[[body]]\nshape = "bax(3, 3, 1)"\n')
        self.assertEqual((said["valid"], said["error"]["line"]), (False, 3))
        self.assertIn("bax", said["error"]["message"])
        said, _ = page.ask("world-check", toml='lattice = "cubic"\n[[body]]\nshape = "box(99999, 99999, 99999)"\n')
        self.assertFalse(said["memory"]["fits"])
        self.assertFalse(page.ask("world-save", toml="nonsense")[0]["ok"])
        self.assertFalse(page.ask("world-save", path="/tmp/other.toml", toml=square(7))[0]["ok"])
        self.assertTrue(page.ask("world-save", path="corner.toml", toml=square(7))[0]["ok"])
        self.assertEqual(self.read("corner.toml").decode(), square(7))
        self.interrupt()
        # Without --world nothing is written.
        self.assertFalse(self.page(self.view("corner.meld")).ask("world-save", toml=square(3))[0]["ok"])
        self.assertEqual(self.read("corner.toml").decode(), square(7))

    def test_files_stay_where_the_viewer_was_started(self):
        page = self.page(self.view("corner.meld"))
        page.ask("command", line="give token(@0, 5)")
        for path in ("/tmp/out.toml", "../out.toml", "a/../../out.toml"):
            self.assertIn("leads out", page.ask("command", line=f"save-events {path}")[0]["error"]["message"])
            self.assertIn("leads out", page.ask("command", line=f"save {path}")[0]["error"]["message"])
        self.assertTrue(page.ask("command", line="save-events mine.toml")[0]["ok"])
        self.assertIn("token", self.read("mine.toml").decode())
        self.assertTrue(page.ask("command", line="save kept")[0]["ok"])
        self.call("meldsim", "resume", "kept", "--ticks", 3, "--quiet")


class Command(Viewing):
    def test_it_ends(self):
        link = self.view("p.meld")
        status, headers, body = get(self.port(link), link.split(str(self.port(link)))[1])
        self.assertEqual(status, 200)
        self.assertIn("default-src 'none'", headers["content-security-policy"])
        self.assertIn(b"<!doctype html>", body[:100].lower())
        page = self.page(link)
        page.ask("hello")
        self.assertLess(self.interrupt(), 5)
        out, _ = self.call("meldsim", "view", "p.meld", "--for", 0.2, "--no-open")
        self.assertRegex(out, r"\Ap\.meld is shown at http://127\.0\.0\.1:\d+/\?token=[0-9a-f]{32}\nIt ends after 200 ms\n\Z")

    def test_what_cannot_be_shown_is_refused(self):
        port = self.port(self.view("p.meld"))
        self.refused("meldsim", "view", "p.meld", "--port", port, "--for", 1, "--no-open", code=2,
                     says=["cannot listen", "--port"])
        self.refused("meldsim", "view", "p.meld", "--tick", 10**6, "--for", 1, "--no-open", code=2, says="ends with tick", lines=None)
        self.refused("meldsim", "view", "none.meld", "--for", 1, code=2, says="none.meld", lines=None)


if __name__ == "__main__":
    main("meldc", "meldsim")
