"""What tests of the commands stand on: a folder for each test with files in it, the tools that it runs there, and the command line of
the file. A new file of tests begins with this:

    import pathlib
    import sys

    sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

    from frame import COUNT, Case, main, square  # noqa: E402

    class Runs(Case):
        FILES = {"w.toml": square(2), "p.meld": COUNT}

        def test_it_ends_well(self):
            self.call("meldsim", "run", "p.meld", "--world", "w.toml")

    if __name__ == "__main__":
        main("meldsim")
"""
import argparse
import math
import os
import pathlib
import resource
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

# The campaign (`scripts/test --all`) takes more of everything: programs, worlds, numbers of processes.
CAMPAIGN = os.environ.get("CLAYMELD_TEST_SIZES") == "all"
# What the command line gives: paths of tools, and further options of the file.
TOOLS = argparse.Namespace()
# Programs whose facts come in the first tick, and in every one.
COUNT = "type p(node, int).\np(A, N) :- neighborCount(A, N).\n"
FOREVER = "type p(node, int).\np(A, N) :- tick(A, N).\n"
# A front goes through the catoms; distances grow with it.
FRONT = """
type source(node).
type dist(node, min int).
source(A)      :- id(A, 0).
dist(A, 0)     :- source(A).
dist(B, D + 1) :- neighbor(A, B), dist(A, D).
"""
# What mpirun needs to start processes as root, and more of them than there are processors; meldsim sets it for those that it starts.
OPEN_MPI = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "OMPI_MCA_rmaps_base_oversubscribe": "1"}


def one_in(count, cases):
    """One in so many of the cases; all of them in the campaign."""
    return list(cases)[:: 1 if CAMPAIGN else count]


def square(side):
    """A world of this many catoms a side."""
    return f'lattice = "square"\n[[body]]\nshape = "box({side}, {side}, 1)"\n'


def files_of(folder):
    """To be written into the folder of a test."""
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def words_of(tool, *arguments):
    """meldc and meldsim are those that are tested; other programs are found as a shell finds them."""
    return [getattr(TOOLS, tool) if tool in ("meldc", "meldsim") else str(tool), *map(str, arguments)]


def environment_with(changes):
    """The environment with other values of these variables; None takes one away."""
    return {name: str(value) for name, value in {**os.environ, **changes}.items() if value is not None}


def no_file_above(size_bytes):
    """For preexec_fn: a limit on the size of files, which stands for a disk that is full, with an error at the same places."""
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size_bytes, size_bytes))


class Case(unittest.TestCase):
    FILES = {}  # Written into the folder before each test: texts or bytes, by name.

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="meld test ")).resolve()  # With a space: paths may have one.
        self.addCleanup(shutil.rmtree, self.folder)
        for name, text in self.FILES.items():
            self.write(name, text)

    def expect_normal(self, values, spread, least):
        """At least so many values, with this standard deviation around 0."""
        count = len(values)
        self.assertGreater(count, least)
        mean = sum(values) / count
        self.assertLess(abs(mean), 4 * spread / math.sqrt(count))
        deviation = math.sqrt(sum((value - mean) ** 2 for value in values) / count)
        self.assertLess(abs(deviation / spread - 1), 4 / math.sqrt(2 * count))
        # Two of three are within one deviation.
        self.assertAlmostEqual(sum(abs(value) < spread for value in values) / count, 0.6827, 1)

    def expect_goes_on(self, ticks):
        """p.meld in w.toml has the same digests and facts if it goes on from a checkpoint, also on another number of processes."""
        run = ("meldsim", "run", "p.meld", "--world", "w.toml", "--quiet")
        self.call(*run, "--ticks", ticks, "--facts-out", "whole", "--digest", "whole.d")
        for tick, n, m in ((1, 2, 1), (20, 1, 3), (33, 3, 2)):
            self.call(*run, "--ticks", tick, "--facts-out", "f", "--digest", "d", "--checkpoint", f"c{tick}", "-n", n)
            self.call("meldsim", "resume", f"c{tick}", "--quiet", "--ticks", ticks, "-n", m)
            self.assertEqual(self.read("d"), self.read("whole.d"), f"tick {tick}")
            self.assertEqual(self.read("f"), self.read("whole"), f"tick {tick}")

    # ---- files

    def write(self, name, text):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    def read(self, name):
        return (self.folder / name).read_bytes()

    def files(self, within=""):
        """Everything below a folder."""
        return {str(path.relative_to(self.folder / within)) for path in (self.folder / within).rglob("*")}

    def small_disk(self, size):
        """In the folder, where one may be mounted."""
        place = self.folder / "disk"
        place.mkdir()
        mount = shutil.which("mount")
        command = [mount, "-t", "tmpfs", "-o", f"size={size}", "tmpfs", place]
        if mount is None or subprocess.run(command, capture_output=True).returncode != 0:
            self.skipTest("no disk may be mounted here")
        self.addCleanup(subprocess.run, ["umount", "-l", place], check=True)
        return place

    # ---- tools

    def run_tool(self, tool, *arguments, seconds=60, environment=None, **options):
        """Runs it to its end, whatever that is: the process, with what it said as text. The environment is that of the test with
        changes; options are those of subprocess.run()."""
        options = {"cwd": self.folder, "stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **options}
        done = subprocess.run(words_of(tool, *arguments), env=environment_with(environment or {}), timeout=seconds, **options)
        # Text mode would change the ends of lines.
        done.stdout, done.stderr = (said if said is None else said.decode(errors="replace") for said in (done.stdout, done.stderr))
        return done

    def call(self, tool, *arguments, code=0, **options):
        """It ends with this code; returns standard output and standard error."""
        done = self.run_tool(tool, *arguments, **options)
        self.assertEqual(done.returncode, code, f"{done.args}\n{done.stdout}{done.stderr}")
        return done.stdout, done.stderr

    def refused(self, tool, *arguments, code, says, lines=1, **options):
        """It ends with this code and a message that holds each of these texts once; nothing goes to standard output. The message has
        so many lines; None: as many as it takes."""
        out, err = self.call(tool, *arguments, code=code, **options)
        self.assertFalse(out)
        for text in [says] if isinstance(says, str) else says:
            self.assertEqual(err.count(text), 1, f"{text!r} should be said once:\n{err}")
        if lines is not None:
            self.assertEqual(err.count("\n"), lines, err)
        return err

    def begin(self, tool, *arguments, environment=None, **options):
        """Starts it; whatever is left of it is killed after the test. Options are those of Popen()."""
        options = {"cwd": self.folder, "stdin": subprocess.DEVNULL, **options}
        process = subprocess.Popen(words_of(tool, *arguments), env=environment_with(environment or {}), **options)
        self.addCleanup(self.end, process)
        return process

    def end(self, process):
        with process:
            process.kill()

    def wait_for(self, condition, process=None, seconds=60):
        """Until the condition holds, or this process has ended."""
        end = time.monotonic() + seconds
        while not condition() and (process is None or process.poll() is None):
            self.assertLess(time.monotonic(), end, f"it takes more than {seconds} s")
            time.sleep(0.01)


def main(*paths, **options):
    """Runs the tests of the file that was started. Its command line has an option for each of these paths and for each further one,
    given as argparse takes it; what is left over is for unittest."""
    parser = argparse.ArgumentParser(description=sys.modules["__main__"].__doc__, formatter_class=argparse.RawDescriptionHelpFormatter,
                                     epilog="Further arguments go to unittest: names of classes and tests, -v, -k PATTERN.")
    for name in paths:
        parser.add_argument(f"--{name}", type=os.path.abspath, required=True, metavar="PATH")
    for name, how in options.items():
        parser.add_argument(f"--{name}", **how)
    _, rest = parser.parse_known_args(namespace=TOOLS)
    unittest.main(argv=[sys.argv[0], *rest])
