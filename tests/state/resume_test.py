"""Runs that are stopped in any way and go on from their checkpoints: resume_test.py --meldc PATH --meldsim PATH [unittest options]

Whatever stopped a run, its digests and facts are in the end those of a run that was never stopped, byte for byte, and its recording
has the same data and attributes.
"""

import json
import os
import pathlib
import random
import shutil
import signal
import sys

import h5py

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import frame  # noqa: E402
from frame import COUNT, FOREVER, files_of, main, square  # noqa: E402
from running import children  # noqa: E402

PROGRAMS = pathlib.Path(__file__).resolve().parent / "programs"
# The program of these tests: it does something in each of 300 ticks, and never ends by itself.
RUN = ("run", "waiting.meld", "--ticks", "300", "--quiet", "--digest", "d", "--facts-out", "f", "--record", "r")
KEEP = ("--checkpoint", "kept", "--checkpoint-every", "20ticks")
CHANGES = ("--checkpoint", "kept", "--checkpoint-every", "2ticks", "--checkpoint-changes")

def until(ticks):
    return [str(ticks) if word == "300" else word for word in RUN]


DAMAGED = 6  # The exit code of a checkpoint that is refused.


def recorded(path):
    """What a recording and its sidecars hold, but for the command that made it."""
    found = {}
    with h5py.File(path) as file:
        def visit(name, item):
            data = (item.shape, str(item.dtype), item[...].tobytes()) if isinstance(item, h5py.Dataset) else ()
            found[name] = data, {key: str(value) for key, value in item.attrs.items() if (name, key) != ("meld", "run")}
        file.visititems(visit)
        found["Steps"] = file["VTKHDF"].get("Steps", getlink=True).path
        for typed in ("meld/arguments", "meld/made_by"):
            found.pop(typed, None)
    for sidecar in (".xdmf", ".lines.xdmf"):
        place = pathlib.Path(f"{path}{sidecar}")
        found[sidecar] = place.read_bytes() if place.exists() else None
    return found


class Case(frame.Case):
    FILES = {"w.toml": square(4), "p.meld": COUNT, "ever.meld": FOREVER, **files_of(PROGRAMS)}

    def undisturbed(self, *options):
        """The digests and facts of a run without checkpoints."""
        self.call("meldsim", *RUN, *options)
        result = self.outcome()
        self.forget()
        return result

    def outcome(self):
        return self.read("d"), self.read("f"), recorded(self.folder / "r")

    def forget(self):
        for name in self.files():
            if name in ("d", "f") or name.split(".")[0] == "r" or ".part-" in name:
                (self.folder / name).unlink()

    def resume(self, *options):
        """Returns what it said of it."""
        return self.call("meldsim", "resume", "kept", "--quiet", *options)[1]

    def shares(self):
        return sorted((self.folder / "kept").glob("*.share"), key=lambda p: int(p.name.split(".")[0]))

    def manifests(self):
        return sorted((self.folder / "kept").glob("*.json"), key=lambda p: int(p.name.split(".")[0]))


class Ways(Case):
    """Ways to stop and to go on."""

    def test_a_run_with_checkpoints_is_the_same_run(self):
        wanted = self.undisturbed()
        self.call("meldsim", *RUN, *KEEP)
        self.assertEqual(self.outcome(), wanted)
        # Two generations, and nothing else.
        self.assertEqual([p.name for p in self.manifests()], ["280.checkpoint.json", "300.checkpoint.json"])
        self.assertEqual(len(self.shares()), 2)

    def test_it_goes_on_with_more_ticks(self):
        wanted = self.undisturbed()
        self.call("meldsim", *until(110), *KEEP)
        for processes, ticks in ((3, 111), (2, 200), (4, 300)):
            self.resume("--ticks", ticks, "-n", processes, "--threads", 1 + ticks % 2)
        self.assertEqual(self.outcome(), wanted)

    def test_bodies_go_on(self):
        for program in ("doze.meld", "tumble.meld"):
            with self.subTest(program=program):
                options = [program if word == "waiting.meld" else word for word in until(80)]
                self.call("meldsim", *options)
                wanted = self.outcome()
                self.forget()
                self.call("meldsim", *["20" if word == "80" else word for word in options], *KEEP)
                for processes, ticks in ((3, 21), (2, 50), (4, 80)):
                    self.resume("--ticks", ticks, "-n", processes, "--threads", 1 + ticks % 2)
                self.assertEqual(self.outcome(), wanted)
                shutil.rmtree(self.folder / "kept")
                self.forget()

    def test_a_recording_goes_on_with_what_bodies_look_like(self):
        """Their sizes, shapes and rotations are recorded after the checkpoint as before it."""
        world = '[[body]]\npositions = [[0, 0, 2], [0, 3, 2], [0, 6, 2]]\n[motion]\nkind = "bodies"\nground = 0\n'
        world += '[[motion.catoms]]\nwhere = "id == 1"\nspin = [1, 2, 0]\n'
        for looks, arrays in (("radius = 0.3\n", {"diameter"}), ('shape = "box"\nedges = [1, 0.5, 0.7]\n', {"core", "orientation"})):
            with self.subTest(arrays=arrays):
                (self.folder / "looks.toml").write_text(world + looks)
                run = ("run", "seen.meld", "--world", "looks.toml", "--quiet", "--digest", "d", "--facts-out", "f", "--record", "r")
                self.call("meldsim", *run, "--ticks", 30)
                wanted = self.outcome()
                self.assertLess({f"VTKHDF/PointData/{name}" for name in arrays}, set(wanted[2]))
                self.forget()
                self.call("meldsim", *run, "--ticks", 10, *KEEP)
                self.resume("--ticks", 20)
                self.resume("--ticks", 30)
                self.assertEqual(self.outcome(), wanted)
                shutil.rmtree(self.folder / "kept")
                self.forget()

    def test_what_is_known_over_a_network_is_no_news(self):
        """Rows that have arrived before the checkpoint are not matched again after it, so the counts in the recording are alike."""
        (self.folder / "news.meld").write_text("type heard(node, node, min int).\nheard(A, A, 0) :- id(A, I), I % 7 = 0.\n"
                                               "heard(A, C, D + 1) :- neighbor(A, B), heard(B, C, D), D < 2.\n")
        (self.folder / "news.toml").write_text('[[body]]\nshape = "box(4, 5, 3)"\n[network]\nkind = "latency"\nmost = 2\n'
                                               '[[event]]\ntick = 3\nkill = "id % 7 == 1"\n')
        run = ("run", "news.meld", "--world", "news.toml", "--quiet", "--digest", "d", "--facts-out", "f", "--record", "r")
        self.call("meldsim", *run, "--ticks", 9)
        wanted = self.outcome()
        self.assertGreater(int(wanted[2]["meld/counts"][1]["derivations"]), 100)
        for ticks in (2, 4, 5):
            with self.subTest(ticks=ticks):
                self.forget()
                shutil.rmtree(self.folder / "kept", ignore_errors=True)
                self.call("meldsim", *run, "--ticks", ticks, *KEEP[:2])
                self.resume("--ticks", 9, "-n", 2)
                self.assertEqual(self.outcome(), wanted)

    def test_resume_of_a_run_that_is_over_does_nothing(self):
        self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--quiet", *RUN[5:], *KEEP)
        before = self.outcome()
        self.resume("-n", 2)
        self.assertEqual(self.outcome(), before)

    def test_interrupt(self):
        wanted = self.undisturbed()
        for sent, code in ((signal.SIGINT, 130), (signal.SIGTERM, 143)):
            for processes in (1, 2):
                with self.subTest(signal=sent, processes=processes):
                    shutil.rmtree(self.folder / "kept", ignore_errors=True)
                    self.forget()
                    run = self.begin("meldsim", *until(100000), *KEEP[:2], "-n", processes)
                    self.wait_for(lambda: (self.folder / "d").exists() and self.read("d").count(b"\n") >= 5)
                    run.send_signal(sent)
                    self.assertEqual(run.wait(20), code)
                    ticks = self.read("d").count(b"\n")
                    # Of the very tick in which it ended, or it was cut in the middle of one.
                    self.assertEqual([p.name for p in self.manifests()], [f"{ticks}.checkpoint.json"])
                    if ticks < 300:
                        self.resume("--ticks", 300, "-n", 3 - processes)
                        self.assertEqual(self.outcome(), wanted)

    def test_it_goes_on_in_the_folder_where_it_was_started(self):
        wanted = self.undisturbed()
        self.call("meldsim", *until(50), *KEEP)
        self.call("meldsim", "resume", self.folder / "kept", "--ticks", 300, cwd="/")
        self.assertEqual(self.outcome(), wanted)

    def test_names_that_are_no_text(self):
        wanted = self.undisturbed()
        name = os.fsdecode(b"kept \xff\n")
        there = self.folder / os.fsdecode(b"\xfe")
        there.mkdir()
        self.folder = there
        for file, text in self.FILES.items():
            self.write(file, text)
        self.call("meldsim", *until(50), "--checkpoint", name)
        self.call("meldsim", "resume", there / name, "--ticks", 300, "--quiet", "-n", 2)
        self.assertEqual(self.outcome(), wanted)

    def test_checkpoints_by_time(self):
        self.call("meldsim", *RUN, "--checkpoint", "kept", "--checkpoint-every", "1ms", "-n", 2)
        self.assertEqual(len(self.manifests()), 2)

    def test_locks_of_a_killed_run_go_with_its_files(self):
        for name in (".13.0-of-2.share.claymeld-lock", "13.0-of-2.share"):
            self.write(f"kept/{name}", "")
        self.call("meldsim", *RUN, *KEEP)
        self.assertEqual(sorted(p.name for p in (self.folder / "kept").iterdir()),
                         ["280.0-of-1.share", "280.checkpoint.json", "300.0-of-1.share", "300.checkpoint.json"])

    def test_what_a_killed_run_left_of_the_same_ticks_goes(self):
        """It was on another number of processes."""
        left = [name for tick in (280, 300) for name in (f"{tick}.0-of-3.part-0123456789abcdef.share", f"{tick}.1-of-3.share",
                                                         f".{tick}.0-of-3.share.claymeld-lock", f".{tick}.1-of-3.share.claymeld-lock")]
        kept = ["280.0-of-1.share", "280.checkpoint.json", "300.0-of-1.share", "300.checkpoint.json"]
        for command in ([*RUN, *KEEP], ["resume", "kept", "--quiet"]):
            for name in left:
                self.write(f"kept/{name}", "")
            self.call("meldsim", *command)
            self.assertEqual(sorted(p.name for p in (self.folder / "kept").iterdir()), kept)

    def test_a_checkpoint_that_one_process_cannot_write(self):
        wanted = self.undisturbed()
        # Where its share would be.
        (self.folder / "kept/40.1-of-2.share/full").mkdir(parents=True)
        said = self.call("meldsim", *RUN, *KEEP, "-n", 2)[1]
        self.assertEqual(self.outcome(), wanted)
        self.assertIn("warning: no checkpoint of tick 40: cannot write kept/40.1-of-2.share", said)
        self.assertIn("The run goes on; the last checkpoint is of tick 20", said)
        self.assertEqual(said.count("\n"), 2, said)

    def test_files_of_an_earlier_run_are_replaced_at_the_end(self):
        wanted = self.undisturbed()
        self.write("d", "of an earlier run\n")
        self.write("r", "of an earlier run\n")
        self.call("meldsim", *until(60), *KEEP)
        self.resume("--ticks", 300)
        self.assertEqual(self.outcome(), wanted)


class Chains(Case):
    """Checkpoints that hold what has changed."""

    def test_they_are_of_the_same_run(self):
        wanted = self.undisturbed()
        self.call("meldsim", *until(110), *CHANGES)
        self.assertGreater(len(self.manifests()), 2)
        for processes, ticks in ((3, 111), (2, 200), (4, 300)):
            self.resume("--ticks", ticks, "-n", processes, "--threads", 1 + ticks % 2)
        self.assertEqual(self.outcome(), wanted)
        # All files that any of them needs, and no others.
        named = {share for path in self.manifests() for share in json.loads(path.read_text().rsplit("\n", 2)[0])["shares"]}
        self.assertEqual({path.name for path in self.shares()}, named)

    def test_from_each_that_is_kept(self):
        """Each goes on to the results of the run that nobody stopped."""
        wanted = self.undisturbed()
        self.call("meldsim", *until(60), *CHANGES, "-n", 2)
        kept = self.folder / "kept"
        first = {name: self.read(name) for name in "dfr"}
        shutil.copytree(kept, self.folder / "all")
        ticks = [int(path.name.split(".")[0]) for path in self.manifests()]
        self.assertTrue(any("changes_since" in path.read_text() for path in self.manifests()))
        for tick in ticks[-3:]:
            with self.subTest(tick=tick):
                shutil.rmtree(kept)
                shutil.copytree(self.folder / "all", kept)
                for path in self.manifests():
                    if int(path.name.split(".")[0]) > tick:
                        path.unlink()
                for name, data in first.items():
                    (self.folder / name).write_bytes(data)
                self.resume("--ticks", 300, "-n", 1 + tick // 2 % 2)
                self.assertEqual(self.outcome(), wanted)

    def test_one_whose_first_is_damaged(self):
        wanted = self.undisturbed()
        self.call("meldsim", *until(60), *CHANGES)
        self.resume("--ticks", 64)
        *_, first, last = self.manifests()
        self.assertNotIn("changes_since", first.read_text())
        self.assertIn('"changes_since": 62', last.read_text())
        (self.folder / "kept" / "62.0-of-1.share").write_bytes(b"")
        self.assertIn("goes on from that of tick 60", self.resume("--ticks", 300))
        self.assertEqual(self.outcome(), wanted)

    def test_bodies(self):
        options = ["doze.meld" if word == "waiting.meld" else word for word in until(60)]
        self.call("meldsim", *options)
        wanted = self.outcome()
        self.forget()
        self.call("meldsim", *["20" if word == "60" else word for word in options], *CHANGES)
        for processes, ticks in ((3, 21), (2, 50), (4, 60)):
            self.resume("--ticks", ticks, "-n", processes)
        self.assertEqual(self.outcome(), wanted)

    def test_without_a_folder(self):
        self.refused("meldsim", *RUN, "--checkpoint-changes", code=2, says="--checkpoint-changes requires --checkpoint.")


class LongChains(Case):
    def test_where_next_to_nothing_changes(self):
        """A resume opens all files of a series, so it ends before there are too many."""
        self.write("later.meld", "type linear go(node).\ntype done(node, int).\n"
                   f"type x(node{24 * ', int'}).\ngo(@0).\ngo(A) -o done(A, 1)@+600.\n"
                   f"x(A{''.join(f', {i} * I * I * I % 1000003' for i in range(11, 35))}) :- id(A, I).\n")
        self.write("large.toml", 'lattice = "cubic"\n[[body]]\nshape = "box(40, 40, 40)"\n')
        self.call("meldsim", "run", "later.meld", "--world", "large.toml", "--ticks", 590, "--quiet", "--checkpoint", "kept",
                  "--checkpoint-every", "1ticks", "--checkpoint-changes", "--facts-out", "facts")
        whole = [path for path in self.manifests() if "changes_since" not in path.read_text()]
        self.assertEqual(len(whole), 2)
        ticks = [int(path.name.split(".")[0]) for path in (*whole, self.manifests()[-1])]
        self.assertEqual(ticks[1] - ticks[0], 250)
        self.assertEqual(len(self.shares()), ticks[2] - ticks[0] + 1)
        self.resume("--ticks", 602)
        self.assertIn("done(@0, 1)", self.read("facts").decode())


class Damage(Case):
    """Checkpoints that are not whole are refused, and the one before is used."""

    def setUp(self):
        super().setUp()
        self.wanted = self.undisturbed()
        self.call("meldsim", *until(100), *KEEP)
        shutil.copytree(self.folder / "kept", self.folder / "whole")
        self.half = self.outcome()
        self.recording = self.read("r")

    def again(self):
        shutil.rmtree(self.folder / "kept")
        shutil.copytree(self.folder / "whole", self.folder / "kept")
        for name, text in zip("dfr", (*self.half[:2], self.recording)):
            self.write(name, text)

    def damages(self, data, rng):
        """Data that ends too early, or has other bytes."""
        for at in sorted({0, 16, len(data) - 1, rng.randrange(len(data))}):
            yield data[:at]
            yield data[:at] + bytes([data[at] ^ 1 << rng.randrange(8)]) + data[at + 1:]
        yield data + b"\0"

    def test_the_one_before_is_used(self):
        rng = random.Random(2)
        for place in (self.shares()[-1], self.manifests()[-1]):
            self.again()
            whole = place.read_bytes()
            for data in self.damages(whole, rng):
                with self.subTest(file=place.name, bytes=len(data)):
                    self.again()
                    place.write_bytes(data)
                    said = self.resume("--ticks", 300)
                    self.assertIn("warning: a newer checkpoint is not whole, and the run goes on from that of tick 80", said)
                    self.assertEqual(self.outcome(), self.wanted)

    def test_none_is_whole(self):
        for place in self.shares():
            place.write_bytes(place.read_bytes()[:-1])
        self.refused("meldsim", "resume", "kept", code=DAMAGED, says=["no checkpoint in", "is whole", "100.0-of-1.share"])
        self.assertEqual(self.outcome(), self.half)

    def test_a_share_is_missing(self):
        self.shares()[-1].unlink()
        self.assertIn("goes on from that of tick 80", self.resume("--ticks", 300))
        self.assertEqual(self.outcome(), self.wanted)

    def test_what_the_run_wrote_is_not_as_it_was(self):
        self.write("d", "")
        self.refused("meldsim", "resume", "kept", code=2, says=["cannot go on with d", "shorter"])
        self.assertIn("d", self.files())
        self.write("d", "x" * len(self.half[0]))
        self.refused("meldsim", "resume", "kept", code=2, says=["cannot go on with d", "tick 100"])
        (self.folder / "d").unlink()
        self.refused("meldsim", "resume", "kept", code=2, says=["cannot go on with d", "gone"])
        self.assertEqual(recorded(self.folder / "r"), self.half[2])

    def test_a_recording_that_is_not_as_it_was(self):
        self.call("meldsim", *[word if word != "r" else "other" for word in until(100)], "--seed", "9")
        for data, says in ((self.recording[:-4000], "it is shorter than it was"), (b"x" * 10_000_000, "signature not found"),
                           (self.read("other"), "it is a recording of another run")):
            self.write("r", data)
            self.refused("meldsim", "resume", "kept", code=2, says=["cannot go on with r", says, "Put it back as the run left it"])
            self.assertEqual(self.read("r"), data)
        (self.folder / "r").unlink()
        self.refused("meldsim", "resume", "kept", code=2, says=["cannot go on with r", "it is gone"])

    def test_another_program_or_world(self):
        for name, what in (("waiting.meld", "the program"), ("waiting.toml", "the world")):
            with self.subTest(name):
                before = self.read(name)
                self.write(name, before.decode() + ("# more\n" if name.endswith("toml") else "lit(@7) :- given(@7).\n"))
                self.refused("meldsim", "resume", "kept", code=DAMAGED, says=["cannot go on", what, "has changed"])
                self.write(name, before)

    def test_a_program_that_includes_another_file(self):
        self.write("part.meld", "type q(node, int).\nq(A, 1).\n")
        self.write("ever.meld", 'include "part.meld".\ntype p(node, int).\np(A, N) :- tick(A, N).\n')
        self.call("meldsim", "run", "ever.meld", "--world", "w.toml", "--ticks", 5, "--quiet", "--checkpoint", "other")
        self.write("part.meld", "type q(node, int).\nq(A, 2).\n")
        self.refused("meldsim", "resume", "other", code=DAMAGED, says=["cannot go on", "the module"])


class Refusals(Case):
    def test_no_checkpoint(self):
        says = ["there is no checkpoint in", "nowhere", "meldsim run --checkpoint"]
        self.refused("meldsim", "resume", "nowhere", code=DAMAGED, says=says)

    def test_a_folder_with_checkpoints(self):
        self.call("meldsim", *RUN, *KEEP)
        self.refused("meldsim", *RUN, *KEEP, code=2, says=["kept has checkpoints of an earlier run", "meldsim resume kept"])

    def test_intervals(self):
        for wrong in ("0ticks", "-1ticks", "1.5ticks", "ticks", "soon", "0s", "-1s"):
            with self.subTest(wrong):
                self.refused("meldsim", *RUN, "--checkpoint", "kept", f"--checkpoint-every={wrong}", code=2, says=["interval", "10min"])

    def test_an_engine_of_one_process(self):
        self.write("doze.toml", self.read("doze.toml").decode().replace("[motion]", '[motion]\nengine = "ode"'))
        self.call("meldsim", "run", "doze.meld", "--ticks", 5, "--quiet", "--checkpoint", "kept")
        self.refused("meldsim", "resume", "kept", "--ticks", 6, "-n", 2, code=2, says=['the engine "ode" runs on one process'])

    def test_one_run_at_a_time(self):
        run = self.begin("meldsim", "run", "ever.meld", "--world", "w.toml", "--quiet", "--ticks", 100000000,
                         "--checkpoint", "kept", "--checkpoint-every", "1ms")
        self.wait_for(self.manifests)
        # The process that computes has a supervisor.
        computing = children(run.pid)[0]
        self.refused("meldsim", "resume", "kept", code=2, says=["kept", "is writing it", str(computing)])
        # What it leaves of its lock keeps nobody away.
        run.send_signal(signal.SIGSTOP)
        os.kill(computing, signal.SIGKILL)
        run.kill()
        run.wait()
        self.assertIn("kept/.run.claymeld-lock", self.files())
        tick = int(self.manifests()[-1].name.split(".")[0])
        self.resume("--ticks", tick + 5)
        self.assertEqual(self.manifests()[-1].name, f"{tick + 5}.checkpoint.json")


if __name__ == "__main__":
    main("meldc", "meldsim")
