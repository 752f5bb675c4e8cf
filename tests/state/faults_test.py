"""Disks that break and disks that are full, while a run keeps checkpoints, records and writes digests:

    faults_test.py --meldc PATH --meldsim PATH --fail-calls PATH [--stride N] [unittest options]

Whatever call fails, the run says so and goes on, or ends with the documented code; what was whole before it is whole after it; and the run
goes on from there to the results of one that was never disturbed.
"""

import errno
import os
import pathlib
import shutil
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import resume_test  # noqa: E402
from frame import TOOLS, main, no_file_above  # noqa: E402

# Few ticks, with three checkpoints, a step of the recording between two of them, and steps that the next one does not have.
RUN = ("run", "waiting.meld", "--ticks", "36", "--quiet", "--digest", "digests", "--facts-out", "facts", "--record", "film")
KEEP = ("--checkpoint", "kept", "--checkpoint-every", "13ticks")
LIMIT, DAMAGED = 4, 6


class Case(resume_test.Case):
    def setUp(self):
        super().setUp()
        self.wanted = self.undisturbed()

    def undisturbed(self):
        self.call("meldsim", *RUN)
        result = self.outcome()
        self.again()
        return result

    def outcome(self):
        return self.read("digests"), self.read("facts"), resume_test.recorded(self.folder / "film")

    def again(self):
        """As before the first run."""
        shutil.rmtree(self.folder / "kept", ignore_errors=True)
        for name in self.files():
            if name.split(".")[0] in ("digests", "facts", "film", "log", "") and (self.folder / name).is_file():
                (self.folder / name).unlink()

    def ticks_kept(self):
        return [int(path.name.split(".")[0]) for path in self.manifests()]

    def goes_on(self, *options):
        """From whichever checkpoint there is, to the results of the undisturbed run; without one, from the start."""
        if self.ticks_kept():
            self.resume(*options)
        else:
            self.refused("meldsim", "resume", "kept", code=DAMAGED, says="there is no checkpoint in")
            shutil.rmtree(self.folder / "kept", ignore_errors=True)
            self.call("meldsim", *RUN, *KEEP)
        self.assertEqual(self.outcome(), self.wanted)


class Calls(Case):
    """The n-th call that writes to some files fails, for all n (for every --stride-th)."""

    def each_failure(self, path, command, prepare, number=errno.ENOSPC, on=False, many=False):
        """Runs the command with the n-th call failed, for all n, and gives how it ended and which call it was."""
        step = TOOLS.stride
        # Of hundreds of writes fewer are tried in a short test.
        step = 1 + (step - 1) * (12 if many else 1)
        n = 1 + step // 2 * on
        while True:
            self.again()
            prepare()
            environment = {"LD_PRELOAD": TOOLS.fail_calls, "FAIL_PATH": path, "FAIL_AT": n, "FAIL_ERRNO": number,
                           "FAIL_ON": int(on), "FAIL_LOG": self.folder / "log"}
            done = self.run_tool("meldsim", *command, environment=environment)
            if "log" not in self.files():
                break
            call = self.read("log").decode().replace(str(self.folder), "").split("\n")[0]
            with self.subTest(n=n, call=call, on=on):
                self.assertNotIn(done.returncode, (1, 70, 134, 139), done)
                yield done, call
            n += step
        self.assertEqual(done.returncode, 0, done)
        self.assertGreater(n, step)
        print(f"{(n - 1) // step} failures of calls for *{path}*", file=sys.stderr)

    def test_checkpoints(self):
        """The run goes on without that checkpoint, and says so."""
        changes = ("--checkpoint-changes", "--checkpoint-every", "5ticks")
        for processes, on, more in ((1, False, ()), (1, True, ()), (2, False, ()), (1, False, changes), (1, True, changes)):
            command = [*RUN, *KEEP[:2 if more else 4], "-n", processes, *more]
            for done, call in self.each_failure("/kept/", command, lambda: None, on=on, many=processes > 1):
                if done.returncode != 0:
                    # The folder could not be taken: nothing has begun.
                    self.assertEqual(done.returncode, LIMIT, done)
                    self.assertIn("cannot write kept: No space left", done.stderr)
                    self.assertEqual(self.ticks_kept(), [])
                    continue
                self.assertEqual(self.outcome(), self.wanted)
                if 36 not in self.ticks_kept():
                    self.assertIn("warning: no checkpoint of tick 36: cannot write", done.stderr)
                    self.assertIn("The run goes on", done.stderr)
                if not more:
                    self.assertLessEqual(len(self.ticks_kept()), 3)
                self.goes_on()

    def of_a_result(self, name, number=errno.EIO):
        for on in (False, True):
            for done, call in self.each_failure("/" + name, [*RUN, *KEEP], lambda: None, number, on, name == "film"):
                if done.returncode != 0:
                    self.assertIn(done.returncode, (2, LIMIT), done)
                    self.assertIn("cannot write " + name, done.stderr)
                self.goes_on()

    def test_digests(self):
        self.of_a_result("digests")

    def test_recording(self):
        self.of_a_result("film")

    def test_recording_that_goes_on(self):
        """A failure while the recording is opened again and cut loses nothing that the checkpoint speaks of."""
        self.call("meldsim", *[word if word != "36" else "30" for word in RUN], *KEEP)
        (self.folder / "kept/30.checkpoint.json").unlink()
        shutil.copytree(self.folder, self.folder / "saved")

        def prepare():
            for name in ("kept", "digests", "facts", "film", "film.xdmf"):
                place = self.folder / "saved" / name
                (shutil.copytree if place.is_dir() else shutil.copyfile)(place, self.folder / name)

        for on in (False, True):
            for done, call in self.each_failure("/film", ["resume", "kept", "--ticks", "36", "--quiet"], prepare, errno.EIO, on, True):
                if done.returncode != 0:
                    self.assertIn("film", done.stderr)
                self.goes_on("--ticks", "36")


class Full(Case):
    """A disk that becomes full while checkpoints, a recording and digests are written to it; and then there is room again."""

    def limited(self, size_bytes, *command):
        return self.run_tool("meldsim", *command, preexec_fn=no_file_above(size_bytes))

    def test_files_that_become_too_large(self):
        codes = set()
        for size_bytes in (0, 1500, 60_000, 550_000, 700_000, 10_000_000):
            self.again()
            done = self.limited(size_bytes, *RUN, *KEEP)
            codes.add(done.returncode)
            with self.subTest(size_bytes=size_bytes):
                self.assertIn(done.returncode, (0, LIMIT), done)
                if done.returncode == LIMIT:
                    self.assertIn("cannot write", done.stderr)
                if (self.folder / "kept").exists():
                    self.goes_on()
        self.assertEqual(codes, {0, LIMIT})

    def test_small_disk(self):
        disk = self.small_disk("8m")
        for name in self.files() - {"disk"}:
            shutil.copy(self.folder / name, disk)
        self.folder = disk
        codes = set()
        for free in (4096, 900_000, 1_500_000, 2_500_000, 6_000_000):
            self.again()
            (disk / "rest").unlink(missing_ok=True)
            space = os.statvfs(disk)
            (disk / "rest").write_bytes(b"x" * max(0, space.f_bavail * space.f_bsize - free))
            done = self.run_tool("meldsim", *RUN, *KEEP)
            codes.add(done.returncode)
            with self.subTest(free=free):
                self.assertIn(done.returncode, (0, LIMIT), done)
                self.assertTrue(done.returncode == 0 or "space" in done.stderr, done)
                (disk / "rest").unlink()
                if (self.folder / "kept").exists():
                    self.goes_on()
        self.assertEqual(codes, {0, LIMIT})


if __name__ == "__main__":
    main("meldc", "meldsim", "fail-calls", stride={"type": int, "default": 1})
