"""What commands write, and where: files that are no files, files that are somebody's, two runs at once, streams that take nothing,
disks that are full. Nothing is lost or replaced by surprise, and what could not be written is told with the documented exit code.

    outputs_test.py --meldc PATH --meldsim PATH [unittest options]
"""
import contextlib
import ctypes
import fcntl
import os
import pathlib
import shutil
import signal
import stat
import subprocess
import sys
import threading
import tty

import h5py

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import frame  # noqa: E402
from frame import COUNT, FOREVER, main, no_file_above, square  # noqa: E402

WORLD = square(4)
TALK = "print(A, int2str(N)) :- tick(A, N).\n"
OUTPUTS = ("--facts-out", "--digest", "--record")
RUN = ("run", "p.meld", "--world", "w.toml", "--quiet")


class Case(frame.Case):
    FILES = {"w.toml": WORLD, "p.meld": COUNT, "ever.meld": FOREVER}


class Paths(Case):
    def kind(self, name):
        return stat.S_IFMT(os.lstat(self.folder / name).st_mode)

    def test_fifo_is_written_to(self):
        self.call("meldsim", *RUN, "--facts-out", "f", "--digest", "d")
        for option, whole in (("--facts-out", "f"), ("--digest", "d")):
            os.mkfifo(self.folder / "fifo")
            heard = []
            reader = threading.Thread(target=lambda: heard.append(self.read("fifo")))
            reader.start()
            self.call("meldsim", *RUN, option, "fifo")
            reader.join(60)
            self.assertEqual(heard, [self.read(whole)])
            self.assertEqual(self.kind("fifo"), stat.S_IFIFO)
            os.unlink(self.folder / "fifo")

    def test_device_is_written_to(self):
        # A terminal is the device that anybody may make.
        ours, theirs = os.openpty()
        tty.setraw(theirs)
        device = os.ttyname(theirs)
        threading.Thread(target=self.read_to_the_end, args=(ours,), daemon=True).start()
        self.addCleanup(os.close, theirs)
        for command in (["meldsim", *RUN, "--facts-out"], ["meldsim", *RUN, "--digest"], ["meldc", "compile", "p.meld", "-o"]):
            self.call(*command, device)
            self.assertEqual(self.kind(device), stat.S_IFCHR)
        # A recording is read while it is written.
        self.refused("meldsim", *RUN, "--record", device, code=2, says=[device, "no regular file"])
        self.assertEqual(self.kind(device), stat.S_IFCHR)

    @staticmethod
    def read_to_the_end(descriptor):
        with contextlib.suppress(OSError), open(descriptor, "rb", buffering=0) as file:  # The end of a terminal is an error.
            while file.read(1 << 16):
                pass

    def test_links_are_followed(self):
        (self.folder / "there").mkdir()
        for option, target in zip(OUTPUTS, ("f", "d", "r.vtkhdf")):
            for existing in (False, True):
                link = self.folder / f"link to {target} {existing}"
                if existing:
                    self.write(f"there/{target}", "old")
                else:
                    (self.folder / "there" / target).unlink(missing_ok=True)
                link.symlink_to(f"there/{target}")
                self.call("meldsim", *RUN, option, link.name)
                self.assertTrue(link.is_symlink())
                self.assertNotIn(self.read(f"there/{target}"), (b"", b"old"))
        self.write("there/x.meld", "type  p( node,int ).\n")
        (self.folder / "x.meld").symlink_to("there/x.meld")
        self.call("meldc", "fmt", "x.meld")
        self.assertTrue((self.folder / "x.meld").is_symlink())
        self.assertEqual(self.read("there/x.meld"), b"type p(node, int).\n")

    def test_modes_and_owners_stay(self):
        outputs = [("meldsim", (*RUN, "--facts-out", "f"), "f"), ("meldsim", (*RUN, "--digest", "d"), "d"),
                   ("meldsim", (*RUN, "--record", "r"), "r"), ("meldc", ("compile", "p.meld", "-o", "m.so"), "m.so"),
                   ("meldc", ("fmt", "x.meld"), "x.meld")]
        for mode in (0o600, 0o640, 0o666):
            for tool, arguments, name in outputs:
                self.write(name, "type  p( node,int ).\n")
                os.chmod(self.folder / name, mode)
                if os.geteuid() == 0:
                    os.chown(self.folder / name, 1234, 4321)
                before = os.stat(self.folder / name)
                self.call(tool, *arguments)
                after = os.stat(self.folder / name)
                self.assertNotEqual(before.st_ino, after.st_ino, "replaced, not written over")
                self.assertEqual([oct(before.st_mode), before.st_uid, before.st_gid],
                                 [oct(after.st_mode), after.st_uid, after.st_gid], name)

    def test_new_files_have_the_users_mask(self):
        for mask in (0o022, 0o077):
            self.call("meldsim", *RUN, "--facts-out", f"f{mask}", "--digest", f"d{mask}", "--record", f"r{mask}", umask=mask)
            for name in (f"f{mask}", f"d{mask}", f"r{mask}", f"r{mask}.xdmf"):
                self.assertEqual(oct(stat.S_IMODE(os.stat(self.folder / name).st_mode)), oct(0o666 & ~mask), name)

    def test_no_other_file_is_touched(self):
        names = ("notes", "notes.tmp", "notes.xdmf.tmp", "p.meld.tmp", "m.so.tmp")
        for name in names[1:]:
            self.write(name, "a user's")
        self.call("meldsim", *RUN, "--facts-out", "notes")
        self.call("meldsim", *RUN, "--digest", "notes")
        self.call("meldsim", *RUN, "--record", "notes")
        self.call("meldc", "compile", "p.meld", "-o", "m.so")
        self.write("p.meld", COUNT.replace(",", " ,"))
        self.call("meldc", "fmt", "p.meld")
        for name in names[1:]:
            self.assertEqual(self.read(name), b"a user's")
        self.assertEqual(self.files(), {"w.toml", "p.meld", "ever.meld", "notes.xdmf", "m.so", *names})

    def test_what_is_read_is_not_written(self):
        (self.folder / "hard").hardlink_to(self.folder / "p.meld")
        (self.folder / "soft").symlink_to("w.toml")
        for arguments, says in (
                (("--facts-out", "p.meld"), ["the program and --facts-out"]),
                (("--facts-out", "hard"), ["the program and --facts-out"]),
                (("--digest", "./soft"), ["the world and --digest"]),
                (("--facts-out", "x", "--digest", "./x"), ["--facts-out and --digest"]),
                (("--facts-out", "x.xdmf", "--record", "x"), ["--facts-out and the sidecar of --record"]),
                (("--digest", "y", "--record", "y"), ["--digest and --record"])):
            for n in ("1", "2"):
                self.refused("meldsim", *RUN, *arguments, "-n", n, code=2, says=[*says, "same file"])
        self.refused("meldc", "compile", "p.meld", "-o", "hard", code=2, says=["the program and -o"])
        self.assertEqual(self.read("p.meld").decode() + self.read("w.toml").decode(), COUNT + WORLD)

    def test_names_of_what_other_commands_make(self):
        for name, says, cure in (("r.mp4", "a film", "meldsim movie r.vtkhdf -o r.mp4"), ("r.GIF", "a film", "-o r.mp4"),
                                 ("r.png", "a picture", "meldsim shot r.vtkhdf -o r.png"), ("r.svg", "a picture", "-o r.png"),
                                 ("no/r.csv", "a table", "meldsim export no/r.vtkhdf -o no/r.csv"), ("r.glb", "a model", "-o r.glb"),
                                 ("r.html", "a page", "meldsim view r.vtkhdf --share r.html")):
            with self.subTest(name):
                self.refused("meldsim", *RUN, "--ticks", 3, "--record", name, code=2,
                             says=[f"cannot write {name}: a recording is VTKHDF, and this is the name of {says}",
                                   f"Write --record {name.rpartition('.')[0]}.vtkhdf; `", f"{cure}` makes {says}"])
        for name, says, cure in (("v.vtkhdf", "a recording", "meldsim run p.meld --record v.vtkhdf"),
                                 ("v.webm", "a film", "meldsim movie p.meld -o v.webm")):
            with self.subTest(name):
                self.refused("meldsim", "view", *RUN[1:], "--ticks", 3, "--share", name, code=2,
                             says=[f"cannot write {name}: a run is shared as HTML, and this is the name of {says}",
                                   f"Write --share v.html; `{cure}` makes {says}"])
        self.assertEqual(self.files(), {"p.meld", "ever.meld", "w.toml"})
        # Any other name is as good as those of which docs speak.
        for option, name in (("--record", "r"), ("--record", "r.h5"), ("--record", "r.2")):
            self.call("meldsim", *RUN, "--ticks", 3, option, name)
            self.assertIn(name, self.files())
        self.call("meldsim", "view", *RUN[1:], "--ticks", 3, "--share", "page")
        self.assertIn("page", self.files())

    def test_two_results_on_one_stream(self):
        for arguments, says in ((("--json", "--facts-out", "-"), "--facts-out and --json"),
                                (("--json", "--digest", "-"), "--digest and --json"),
                                (("--digest", "-", "--facts-out", "/dev/stdout"), "--facts-out and --digest")):
            self.refused("meldsim", "run", "p.meld", "--world", "w.toml", *arguments, code=2, says=[says, "standard output"])
        # The summary gives way.
        out, err = self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--facts-out", "-")
        self.call("meldsim", *RUN, "--facts-out", "f")
        self.assertEqual(out.encode(), self.read("f"))
        self.assertIn("catoms", err)

    def test_permission_is_not_absence(self):
        secret = self.folder / "secret"
        secret.mkdir()
        self.write("secret/p.meld", COUNT)
        self.write("locked.meld", COUNT)
        os.chmod(self.folder / "locked.meld", 0)
        os.chmod(secret, 0)
        self.addCleanup(os.chmod, secret, 0o700)
        options = {"preexec_fn": give_up_reading_everything} if os.geteuid() == 0 else {}
        for command in (("check", "locked.meld"), ("check", "secret/p.meld")):
            self.refused("meldc", *command, code=2, says=["Permission denied"], **options)
        self.refused("meldsim", "world", "secret/w.toml", code=2, says=["Permission denied"], **options)
        self.refused("meldc", "fmt", "locked.meld", code=2, says=["Permission denied"], **options)


def give_up_reading_everything():
    """In a child of root: the program that it becomes may read only what permissions allow, as another user's."""
    drop_from_bounding_set, override_permissions, read_everything = 24, 1, 2  # As in <linux/prctl.h> and <linux/capability.h>.
    for capability in (override_permissions, read_everything):
        ctypes.CDLL(None, use_errno=True).prctl(drop_from_bounding_set, capability, 0, 0, 0)


class Locks(Case):
    def start(self, *arguments):
        return self.begin("meldsim", "run", "ever.meld", "--world", "w.toml", "--quiet", *arguments,
                          stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def locked_by(self, name):
        lock = self.folder / f".{name}.claymeld-lock"
        return int(lock.read_text() or 0) if lock.exists() else 0

    def test_second_run_is_refused_and_names_the_first(self):
        for option, name in zip(OUTPUTS, ("f", "d", "r")):
            first = self.start(option, name)
            self.wait_for(lambda: self.locked_by(name) == first.pid)
            self.refused("meldsim", *RUN, option, f"./{name}", code=2, says=[f"./{name}: process {first.pid}", "still runs"])
            first.send_signal(signal.SIGINT)
            self.assertEqual(first.wait(60), 130)
            self.call("meldsim", *RUN, option, name)
            self.assertEqual(self.locked_by(name), 0)

    def test_lock_of_a_killed_run_is_taken_over(self):
        first = self.start("--facts-out", "f")
        self.wait_for(lambda: self.locked_by("f") == first.pid)
        first.kill()
        first.wait()
        self.assertIn(".f.claymeld-lock", self.files())
        self.call("meldsim", *RUN, "--facts-out", "f")
        self.assertEqual(self.files(), {"w.toml", "p.meld", "ever.meld", "f"})

    def test_digest_of_a_killed_run_stays_and_an_earlier_one_too(self):
        first = self.start("--digest", "d")
        self.wait_for(lambda: "d" in self.files() and self.read("d").count(b"\n") > 3)
        first.kill()
        first.wait()
        before = self.read("d")
        self.assertTrue(before.startswith(b"tick 1 "))
        second = self.start("--digest", "d")
        self.wait_for(lambda: any(".part-" in name for name in self.files()))
        second.kill()
        second.wait()
        self.assertEqual(self.read("d"), before)


class Streams(Case):
    def closing(self, *descriptors):
        return lambda: [os.close(d) for d in descriptors]

    def test_full_standard_output(self):
        self.write("talk.meld", TALK)
        with open("/dev/full", "wb") as full:
            for n in ("1", "2"):
                for arguments in ((), ("--json",), ("--quiet", "--digest", "-"), ("--quiet", "--facts-out", "-")):
                    self.refused("meldsim", "run", "p.meld", "--world", "w.toml", "-n", n, *arguments, code=4,
                                 says=["standard output", "No space left"], stdout=full)
            self.refused("meldsim", "run", "talk.meld", "--world", "w.toml", "--quiet", "--ticks", "9", code=4,
                         says=["standard output", "No space left"], stdout=full)
            for command in (("meldsim", "world", "w.toml"), ("meldsim", "--help"), ("meldsim", "run", "--help"), ("meldc", "help"),
                            ("meldc", "--version"), ("meldc", "compile", "p.meld"), ("meldc", "compile", "p.meld", "--emit=cpp"),
                            ("meldc", "explain", "E0501"), ("meldc", "check", "--json", "p.meld"), ("meldc", "fmt", "--stdout", "p.meld"),
                            ("meldc", "completion", "bash")):
                self.refused(*command, code=4, says=[f"{command[0]}: cannot write standard output: No space left"], stdout=full)

    def test_full_devices(self):
        for option in ("--facts-out", "--digest"):
            self.refused("meldsim", *RUN, option, "/dev/full", code=4, says=["/dev/full", "No space left"])

    def test_full_standard_error(self):
        self.write("wrong.meld", "p(A) :- q(A).\n")
        with open("/dev/full", "wb") as full:
            for n in ("1", "2"):
                self.call("meldsim", *RUN, "-n", n, stderr=full)
                self.call("meldsim", "run", "wrong.meld", "--world", "w.toml", "-n", n, stderr=full, code=1)
            self.call("meldsim", "run", "p.meld", "--world", "none", stderr=full, code=2)
            self.call("meldc", "check", "wrong.meld", stderr=full, code=1)

    def test_closed_descriptors(self):
        """A file that is opened must not take the place of a closed stream and get what is meant for it."""
        self.call("meldsim", *RUN, "--facts-out", "f")
        for closed in ((0,), (1,), (2,), (0, 1, 2)):
            for n in ("1", "2"):
                self.call("meldsim", *RUN, "-n", n, "--facts-out", "x", "--record", "r", stdin=None, stdout=None, stderr=None,
                          preexec_fn=self.closing(*closed))
                self.assertEqual(self.read("x"), self.read("f"))
                with h5py.File(self.folder / "r") as recording:
                    self.assertGreater(recording["VTKHDF/Steps"].attrs["NSteps"], 0)
        for command in (("run", "p.meld", "--world", "w.toml"), ("world", "w.toml")):
            self.refused("meldsim", *command, code=2, says=["standard output", "closed"], stdout=None, preexec_fn=self.closing(1))
        self.refused("meldc", "compile", "p.meld", code=2, says=["standard output", "closed"], stdout=None, preexec_fn=self.closing(1))

    def test_reader_that_leaves(self):
        self.write("talk.meld", TALK)
        for n in ("1", "2"):
            for program, arguments in (("talk.meld", ()), ("ever.meld", ("--digest", "-"))):
                process = self.begin("meldsim", "run", program, "--world", "w.toml", "--quiet", "-n", n, *arguments,
                                     stdout=subprocess.PIPE, stderr=subprocess.PIPE)
                self.assertTrue(process.stdout.readline())
                process.stdout.close()
                err = process.stderr.read().decode()
                process.stderr.close()
                self.assertEqual((process.wait(60), err), (4, ""))

    def test_reader_of_an_answer_that_leaves(self):
        """`meldsim world FILE | head -n 1` has shown what its user wanted."""
        self.call("meldsim", *RUN, "--record", "r")
        self.call("meldsim", "run", "ever.meld", "--world", "w.toml", "--quiet", "--ticks", "5", "--record", "other")
        for command in (("meldsim", "world", "w.toml"), ("meldsim", "about", "r"), ("meldsim", "diff", "r", "other"),
                        ("meldsim", "shot", "p.meld", "--world", "w.toml", "--tick", "1", "-o", "x.png"),
                        ("meldc", "explain", "E0304"), ("meldc", "compile", "--explain-rules", "p.meld")):
            reader, writer = os.pipe()
            os.close(reader)
            process = self.begin(*command, stdout=writer, stderr=subprocess.PIPE)
            os.close(writer)
            err = process.stderr.read().decode()
            process.stderr.close()
            self.assertEqual((process.wait(60), err), (4, ""), command)


class Shown(Case):
    """Pictures, films, models and pages respect what is there as facts and recordings do."""
    MADE = (("x.png", ("shot", "p.meld", "--world", "w.toml", "--tick", "1", "-o")),
            ("x.ply", ("export", "p.meld", "--world", "w.toml", "--tick", "1", "-o")),
            ("x.html", ("view", "p.meld", "--world", "w.toml", "--ticks", "1", "--share")))

    def test_fifo_link_mode_and_full_disk(self):
        for name, command in self.MADE:
            self.write("there", "old")
            os.chmod(self.folder / "there", 0o640)
            (self.folder / name).symlink_to("there")
            self.call("meldsim", *command, name)
            self.assertTrue((self.folder / name).is_symlink())
            self.assertEqual(oct(stat.S_IMODE(os.stat(self.folder / "there").st_mode)), oct(0o640))
            whole = self.read("there")
            self.assertNotEqual(whole, b"old")
            self.refused("meldsim", *command, name, code=4, says=["File too large"], preexec_fn=no_file_above(64))
            self.assertEqual(self.read("there"), whole)
            os.unlink(self.folder / name)
            (self.folder / name).symlink_to("/dev/full")
            self.refused("meldsim", *command, name, code=4, says=[name, "No space left"])
            os.unlink(self.folder / name)
            os.mkfifo(self.folder / name)
            heard = []
            reader = threading.Thread(target=lambda at=name, all=heard: all.append(self.read(at)))
            reader.start()
            self.call("meldsim", *command, name)
            reader.join(60)
            self.assertEqual([len(each) for each in heard], [len(whole)])
            self.assertTrue(stat.S_ISFIFO(os.lstat(self.folder / name).st_mode))
            self.refused("meldsim", *command, "p.meld", code=2, says="p.meld")
            with open("/dev/full", "wb") as full:
                self.refused("meldsim", *command, f"y{name}", code=4, says=["standard output", "No space left"], stdout=full)
        self.assertEqual(self.read("p.meld").decode(), COUNT)

    def test_a_film_is_no_stream(self):
        os.mkfifo(self.folder / "x.mp4")
        (self.folder / "x.webm").symlink_to("/dev/full")
        for name in ("x.mp4", "x.webm"):
            self.refused("meldsim", "movie", "p.meld", "--world", "w.toml", "-o", name, code=2, says=[name, "a film is no stream"])

    def test_two_films_do_not_share_a_folder(self):
        """Before either has a picture in it."""
        with open(self.write("film/.film.claymeld-lock", f"{os.getpid()}\n"), "rb") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            self.refused("meldsim", "movie", "p.meld", "--world", "w.toml", "--size", "64x48", "-o", "film/", code=2,
                         says=[f"process {os.getpid()}", "still runs"])
        self.call("meldsim", "movie", "p.meld", "--world", "w.toml", "--size", "64x48", "--quiet", "-o", "film/")
        self.assertIn("00000.png", self.files("film"))
        self.assertNotIn(".film.claymeld-lock", self.files("film"))


class Disks(Case):
    """A limit on the size of files stands for the disk; a small disk where one may be mounted."""

    def test_file_that_becomes_too_large(self):
        self.write("w.toml", square(60))
        # Both are in the cache then.
        self.call("meldsim", *RUN)
        self.call("meldsim", "run", "ever.meld", "--world", "w.toml", "--quiet", "--ticks", "1")
        for name in ("f", "d", "r"):
            self.write(name, "old")
        # With several processes too, although Open MPI has files of its own.
        for processes in (1, 2, 3):
            for size_bytes in (4096, 100_000):
                many = ("-n", processes)
                with self.subTest(processes=processes, size_bytes=size_bytes):
                    self.refused("meldsim", *RUN, *many, "--facts-out", "f", code=4 if size_bytes < 10_000 else 0,
                                 says=["cannot write f: File too large. Raise the limit on the size of files (ulimit -f)"]
                                 if size_bytes < 10_000 else [], lines=None, preexec_fn=no_file_above(size_bytes))
            self.write("f", "old")
            self.refused("meldsim", "run", "ever.meld", "--world", "w.toml", "--quiet", "--digest", "d", *many, code=4,
                         says=["cannot write d: File too large"], preexec_fn=no_file_above(4096))
            self.refused("meldsim", *RUN, *many, "--record", "r", code=4, says=["cannot write r: "], preexec_fn=no_file_above(4096))
        for name in ("f", "d", "r"):
            self.assertEqual(self.read(name), b"old")
        self.refused("meldc", "compile", "p.meld", "-o", "m.so", code=4, says=["cannot write m.so: File too large"],
                     preexec_fn=no_file_above(4096))
        self.assertNotIn("m.so", self.files())

    def test_cache_that_is_full(self):
        for size_bytes in (0, 1000, 4096, 20_000):
            cache = self.folder / f"cache {size_bytes}"
            done = self.run_tool("meldc", "compile", "p.meld", "--quiet", environment={"CLAYMELD_CACHE": cache},
                                 preexec_fn=no_file_above(size_bytes))
            if done.returncode != 0:
                self.assertEqual(done.returncode, 4, (size_bytes, done))
                self.assertIn("File too large", done.stderr)

    def test_cache_on_a_disk_that_is_nearly_full(self):
        place = self.small_disk("1m")
        cache = place / "cache"
        codes = set()
        for free in range(0, 900_000, 49_152):
            shutil.rmtree(cache, ignore_errors=True)
            (place / "rest").unlink(missing_ok=True)
            space = os.statvfs(place)
            (place / "rest").write_bytes(b"x" * max(0, space.f_bavail * space.f_bsize - free))
            done = self.run_tool("meldc", "compile", "p.meld", "--quiet", environment={"CLAYMELD_CACHE": cache})
            codes.add(done.returncode)
            self.assertIn(done.returncode, (0, 4), done)
            if done.returncode != 0:
                self.assertIn("No space left", done.stderr, done)
        self.assertEqual(codes, {0, 4})

    def test_full_disk_keeps_what_was_there(self):
        place = self.small_disk("2m")
        self.write("w.toml", square(60) + "[record]\nevery = 1\n")
        for name in ("f", "d", "r"):
            (place / name).write_bytes(b"old")
        (place / "rest").write_bytes(b"x" * 1_300_000)
        err = self.refused("meldsim", "run", "ever.meld", "--world", "w.toml", "--quiet", "--record", place / "r", code=4,
                           says="cannot write")
        self.assertIn("space", err)
        self.assertEqual((place / "r").read_bytes(), b"old")
        # What there is of the new one is said, and can be read.
        begun = [path for path in place.iterdir() if path.name.startswith("r.part-")]
        for path in begun:
            self.assertIn(str(path), err)
            with h5py.File(path) as recording:
                steps = recording["VTKHDF/Steps"]
                self.assertEqual(len(steps["Values"]), steps.attrs["NSteps"])
            path.unlink()
        space = os.statvfs(place)
        with open(place / "rest", "ab") as rest:
            rest.write(b"x" * (space.f_bavail * space.f_bsize - 8192))
        self.refused("meldsim", *RUN, "--facts-out", place / "f", code=4, says=["No space left"])
        self.assertEqual((place / "f").read_bytes(), b"old")
        self.refused("meldc", "compile", "p.meld", "-o", place / "m.so", code=4, says=["No space left"])


if __name__ == "__main__":
    main("meldc", "meldsim")
