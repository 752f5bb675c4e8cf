"""The Python package as it is published: its wheel, its version, its types, and what importing it costs.

    package_test.py --meldsim PATH [unittest options]
"""
import ast
import pathlib
import re
import shutil
import sys
import tomllib
import zipfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from frame import OPEN_MPI, TOOLS, Case, main  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]


class Package(Case):
    def python(self, *words, environment=None, **options):
        return self.call(sys.executable, "-B", *words, environment=environment, **options)[0]

    def test_wheel_holds_the_package_and_can_be_used(self):
        shutil.copytree(ROOT / "python", self.folder / "python", ignore=shutil.ignore_patterns("__pycache__", "*.egg-info", "build"))
        # What pip asks of a package; pip itself would want a network.
        self.python("-c", "import setuptools.build_meta as b; b.build_wheel('..')", cwd=self.folder / "python")
        version = re.search(r'kVersion\[\] = "(.*)"', (ROOT / "runtime/base/version.h").read_text())[1]
        wheel = zipfile.ZipFile(self.folder / f"claymeld-{version}-py3-none-any.whl")
        files = (ROOT / "python/claymeld").rglob("*")
        wanted = {path.relative_to(ROOT / "python").as_posix() for path in files if path.suffix == ".py" or path.name == "py.typed"}
        self.assertEqual({name for name in wheel.namelist() if name.startswith("claymeld/")}, wanted)
        metadata = wheel.read(f"claymeld-{version}.dist-info/METADATA").decode()
        for line in (f"Version: {version}", "Requires-Dist: h5py", "Requires-Dist: matplotlib .*; extra == 'plot'",
                     "Requires-Dist: networkx .*; extra == 'graph'"):
            self.assertRegex(metadata, line)
        wheel.extractall(self.folder / "site")
        out = self.python("-c", "import claymeld; print(claymeld.__version__, claymeld.__file__, claymeld.value('[1, @2]'))",
                          environment={"PYTHONPATH": self.folder / "site"})
        self.assertEqual(out, f"{version} {self.folder / 'site/claymeld/__init__.py'} [1, 2]\n")

    def test_import_waits_with_libraries_until_they_are_used(self):
        libraries = "[name for name in ('numpy', 'pandas', 'h5py', 'matplotlib', 'networkx') if name in sys.modules]"
        out = self.python("-c", f"import sys, claymeld; print({libraries}); claymeld.open; print({libraries})")
        self.assertEqual(out, "[]\n['numpy', 'pandas', 'h5py']\n")

    def test_what_is_not_installed_is_named_with_its_cure(self):
        project = tomllib.loads((ROOT / "python/pyproject.toml").read_text())["project"]
        extras = {"": project["dependencies"], **project["optional-dependencies"]}
        wanted = {re.match(r"\w+", need)[0]: extra for extra, needs in extras.items() for need in needs}
        out = self.python("-c", "from claymeld.tool.packages import EXTRAS; print(EXTRAS)")
        self.assertEqual(ast.literal_eval(out), wanted)
        self.write("w.toml", 'lattice = "square"\n[body]\nshape = "box(2, 1, 1)"\n')
        run = "import claymeld\nrun = claymeld.run('type p(node).\\np(A) :- id(A, 0).\\n', 'w.toml')\n"
        uses = {"plot()": "run.recording.plot()", "plot_metrics()": "run.recording.plot_metrics()", "graph()": "run.recording.graph()",
                "a recording": "run.recording", "facts()": "run.facts()", "claymeld.open": "claymeld.open", "claymeld.Why": "claymeld.Why",
                "claymeld.facts": "claymeld.facts", "claymeld.sweep": "claymeld.sweep"}
        takes = {"matplotlib": ["plot()", "plot_metrics()"], "networkx": ["graph()"]}
        always = ["a recording", "facts()", "claymeld.open", "claymeld.facts"]
        for package, extra in wanted.items():
            for use in takes.get(package, always):
                code = f"{run}import sys\n" if use.endswith(")") or use == "a recording" else "import claymeld, sys\n"
                done = self.run_tool(sys.executable, "-B", "-c", f"import sys\nsys.modules['{package}'] = None\n{code}{uses[use]}\n",
                                     environment={**OPEN_MPI, "CLAYMELD_MELDSIM": TOOLS.meldsim}, cwd=self.folder)
                self.assertEqual(done.returncode, 1, done.stdout)
                whole = f"claymeld[{extra}]" if extra else "claymeld"
                self.assertIn(f"MissingPackage: {use} needs {package}, which is not installed. Install it by `pip install '{whole}'`",
                              done.stderr)

    def test_everything_it_names_is_there(self):
        out = self.python("-c", "import claymeld\nfor name in claymeld.__all__: assert getattr(claymeld, name).__doc__, name\n"
                          "print(set(claymeld.__all__) <= set(dir(claymeld)), callable(claymeld.facts))\n"
                          "try: claymeld.nothing\nexcept AttributeError as error: print(error)")
        self.assertEqual(out, "True True\nmodule 'claymeld' has no attribute 'nothing'\n")

    def test_types(self):
        try:
            import mypy  # noqa: F401
        except ImportError:
            self.skipTest("mypy is not installed")
        self.write("user.py", "import claymeld\nrecording: claymeld.Recording = claymeld.run('p.meld', ticks=3).recording\n"
                   "claymeld.run('p.meld', ticks='3')\nrecording.facts(3)\n")
        done = self.run_tool(sys.executable, "-m", "mypy", "--config-file", ROOT / "python/pyproject.toml",
                             "--cache-dir", self.folder / "cache", "-p", "claymeld", "-m", "user",
                             environment={"MYPYPATH": f"{ROOT / 'python'}:{self.folder}"})
        self.assertEqual(re.findall(r"^(.*): error", done.stdout, re.MULTILINE), ["user.py:3", "user.py:4"], done.stdout)

    def test_meldsim_is_found(self):
        meldsim = self.folder / "bin dir" / "meldsim"
        meldsim.parent.mkdir()
        meldsim.write_text("#!/bin/sh\necho meldsim 9.9\n")
        meldsim.chmod(0o755)
        ask = "import claymeld; print(claymeld.find_meldsim())"
        self.assertEqual(self.python("-c", ask, environment={"CLAYMELD_MELDSIM": meldsim}), f"{meldsim}\n")
        self.assertEqual(self.python("-c", ask, environment={"PATH": meldsim.parent}), f"{meldsim}\n")
        # Beside the package, as it is installed.
        shutil.copytree(ROOT / "python", self.folder / "share/claymeld/python", ignore=shutil.ignore_patterns("__pycache__"))
        (self.folder / "bin").mkdir()
        shutil.copy(meldsim, self.folder / "bin/meldsim")
        installed = {"PYTHONPATH": self.folder / "share/claymeld/python", "PATH": "/nowhere", "CLAYMELD_MELDSIM": None}
        self.assertEqual(self.python("-c", ask, environment=installed), f"{self.folder / 'bin/meldsim'}\n")
        (self.folder / "bin/meldsim").unlink()
        err = self.call(sys.executable, "-B", "-c", ask, environment=installed, code=1)[1]
        self.assertIn("ToolNotFound: there is no program meldsim: not in PATH", err)
        self.assertIn("set CLAYMELD_MELDSIM", err)
        err = self.call(sys.executable, "-B", "-c", ask, environment={**installed, "CLAYMELD_MELDSIM": "/no/m"}, code=1)[1]
        self.assertIn("CLAYMELD_MELDSIM '/no/m' is no program", err)


if __name__ == "__main__":
    main("meldsim")
