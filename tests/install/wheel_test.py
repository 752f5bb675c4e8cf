"""The wheel with the programs in it: installed into an empty environment of Python it runs programs, with nothing of Claymeld in PATH.

    wheel_test.py --build FOLDER [unittest options]
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import zipfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from frame import TOOLS, main  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
# Debian's, which has pandas and h5py, and pip.
PYTHON = "/usr/bin/python3"
ASK = "import claymeld; print(claymeld.find_meldsim())"


@unittest.skipIf(subprocess.run([PYTHON, "-c", "import setuptools, pip, wheel, venv"], capture_output=True).returncode != 0,
                 "setuptools, pip, wheel or venv is missing (scripts/install test)")
class Wheel(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="meld wheel "))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        made = subprocess.run([PYTHON, "-B", ROOT / "packaging/wheel/make.py", "--build", TOOLS.build, "--out", cls.folder / "made"],
                              check=True, capture_output=True, text=True)
        cls.wheel = pathlib.Path(made.stdout.strip())
        # Without a pip of its own, which would want ensurepip: that of the system does.
        subprocess.run([PYTHON, "-m", "venv", "--system-site-packages", "--without-pip", cls.folder / "there"], check=True)
        cls.bin = cls.folder / "there/bin"
        subprocess.run([cls.bin / "python3", "-m", "pip", "--no-cache-dir", "install", "--quiet", "--no-index", "--no-deps", cls.wheel],
                       check=True, capture_output=True)
        cls.package = next((cls.folder / "there").glob("lib/python3*/site-packages/claymeld"))
        cls.environment = {"PATH": "/nowhere", "HOME": str(cls.folder), "CLAYMELD_CACHE": str(cls.folder / "cache"), "LC_ALL": "C.UTF-8"}

    def call(self, name, *words, code=0, **changes):
        done = subprocess.run([self.bin / name, *map(str, words)], cwd=self.folder, env={**self.environment, **changes},
                              capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, code, f"{name} {words}\n{done.stdout}{done.stderr}")
        return done.stdout, done.stderr

    def test_it_says_what_its_python_lacks(self):
        subprocess.run([PYTHON, "-m", "venv", "--without-pip", self.folder / "bare"], check=True)
        done = subprocess.run([self.folder / "bare/bin/python3", "-B", ROOT / "packaging/wheel/make.py", "--build", TOOLS.build,
                               "--out", self.folder / "bare"], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertRegex(done.stderr, r"bare/bin/python3 has no setuptools and no wheel\. Install python3-setuptools python3-wheel, or")

    def test_its_name_says_version_and_platform(self):
        version = re.search(r'kVersion\[\] = "(.*)"', (ROOT / "runtime/base/version.h").read_text())[1]
        self.assertEqual(self.wheel.name, f"claymeld-{version}-py3-none-linux_{os.uname().machine}.whl")

    def test_python_runs_a_program_with_the_meldsim_of_the_wheel(self):
        self.assertEqual(self.call("python3", "-c", ASK)[0], f"{self.package / 'programs/bin/meldsim'}\n")
        program = self.package / "programs/share/claymeld/examples/gradient.meld"
        run = (f"import claymeld\nrun = claymeld.run({str(program)!r})\nprint(run.facts('dist')['D'].max())\n"
               "print(run.recording.query('dist(@2, D)'))\nrun.recording.shot('end', size=(80, 60)).save('end.png')\n")
        out = self.call("python3", "-c", run)[0]
        self.assertEqual(out.splitlines()[0], "57")
        self.assertRegex(out, r"\n0 +1\n")
        self.assertEqual((self.folder / "end.png").read_bytes()[:4], b"\x89PNG")

    def test_the_meldsim_of_the_wheel_comes_before_others(self):
        other = self.folder / "other/meldsim"
        other.parent.mkdir()
        other.write_text("#!/bin/sh\n")
        other.chmod(0o755)
        self.assertEqual(self.call("python3", "-c", ASK, PATH=str(other.parent))[0], f"{self.package / 'programs/bin/meldsim'}\n")
        self.assertEqual(self.call("python3", "-c", ASK, CLAYMELD_MELDSIM=str(other))[0], f"{other}\n")

    def test_its_commands_are_the_programs(self):
        for name in ("meldc", "meldsim"):
            self.assertRegex(self.call(name, "--version")[0], rf"^{name} \d+\.\d+\.\d+\n$")
        # As exact as any: the facts are those of the build, and exit codes come through.
        program = ROOT / "examples/meld/gradient.meld"
        self.call("meldsim", "run", program, "--quiet", "--facts-out", "wheel.facts")
        subprocess.run([pathlib.Path(TOOLS.build, "bin/meldsim"), "run", program, "--quiet", "--facts-out", self.folder / "build.facts"],
                       check=True)
        self.assertEqual((self.folder / "wheel.facts").read_text(), (self.folder / "build.facts").read_text())
        self.assertIn("nothing.meld", self.call("meldsim", "run", "nothing.meld", code=2)[1])

    def test_several_processes_need_mpirun(self):
        program = ROOT / "examples/meld/gradient.meld"
        self.call("meldsim", "run", program, "-n", "2", "--quiet", "--facts-out", "two.facts", PATH="/usr/bin:/bin")
        self.call("meldsim", "run", program, "--quiet", "--facts-out", "one.facts")
        self.assertEqual((self.folder / "two.facts").read_text(), (self.folder / "one.facts").read_text())

    def test_what_it_needs_of_the_system_is_written_down(self):
        text = zipfile.ZipFile(self.wheel).read("claymeld/programs/PACKAGES").decode()
        lines = dict(line.partition(" ")[::2] for line in text.splitlines())
        self.assertIn("libmpi.so.40", lines)
        asked = set()
        for path in (*(self.package / "programs/bin").iterdir(), *(self.package / "programs/lib/claymeld").iterdir()):
            out = subprocess.run(["readelf", "-d", path], check=True, capture_output=True, text=True).stdout
            asked |= set(re.findall(r"\(NEEDED\).*\[(lib.+)\]", out))
        self.assertEqual(set(lines), asked)
        if shutil.which("dpkg"):
            page = (ROOT / "docs/releasing.md").read_text()
            named = set(re.search(r"```sh norun\napt-get install (.*?)\n```", page, re.DOTALL)[1].replace("\\\n", " ").split())
            # Of these every Debian has some.
            always = {"libc6", "libgcc-s1", "libstdc++6"}
            self.assertEqual(named - {"openmpi-bin", "fonts-dejavu-core"}, set(lines.values()) - always)

    def test_a_library_that_is_missing_is_named_with_its_cure(self):
        meldsim = self.package / "programs/bin/meldsim"
        whole = meldsim.read_bytes()
        # It asks for a library that no system has.
        meldsim.write_bytes(whole.replace(b"libode.so.8\0", b"libodd.so.8\0"))
        self.addCleanup(meldsim.write_bytes, whole)
        err = self.call("python3", "-c", "import claymeld; claymeld.run('type p(node).\\np(A) :- id(A, 0).\\n')", code=1)[1]
        self.assertIn("ToolNotFound: ", err)
        self.assertIn("libodd.so.8: cannot open shared object file", err)
        self.assertRegex(err, r"apt-get install .*\blibode8\b")


if __name__ == "__main__":
    main("build")
