"""The recipes of packaging/ in the hands of Spack, EasyBuild and rattler-build: what they read, find and, if asked, build.

    built_test.py --build FOLDER [unittest options]

Each is left out where its program is missing. With CLAYMELD_BUILD_RECIPES=1 Spack and EasyBuild also build Claymeld, which takes as long as
`scripts/build`: it needs Debian 12 with what scripts/install brings, and, in the folder that CLAYMELD_RECIPE_SOURCES names or from their
hosts, the sources of what Debian lacks.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from frame import OPEN_MPI, TOOLS, main  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
PACKAGING = ROOT / "packaging"
EASYCONFIG = next(PACKAGING.glob("easybuild/Claymeld-*.eb"))
BUILDS = os.environ.get("CLAYMELD_BUILD_RECIPES") == "1"
SOURCES = os.environ.get("CLAYMELD_RECIPE_SOURCES")
# Built beside Claymeld: what Debian has no library of, and what Spack brings into every build.
OF_SPACK = {"claymeld", "ode", "civetweb", "compiler-wrapper", "gcc-runtime"}
LMOD = pathlib.Path(os.environ.get("LMOD_PKG", "/usr/share/lmod/lmod"), "init/bash")
# What loads what in the toolchain of EasyBuild.
TOOLCHAIN = {"GCC/13.3.0": ["GCCcore/13.3.0"], "OpenMPI/5.0.3-GCC-13.3.0": ["GCC/13.3.0"],
             "gompi/2024a": ["GCC/13.3.0", "OpenMPI/5.0.3-GCC-13.3.0"]}
try:
    import rattler_build
except ImportError:
    rattler_build = None


class InEmptyHome(unittest.TestCase):
    """Runs programs with an empty home, so that nothing which the machine's user has set up counts."""

    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="meld_recipes_"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        (cls.folder / "home").mkdir()
        cls.environment = {**OPEN_MPI, "HOME": str(cls.folder / "home"), "PATH": os.environ["PATH"], "LC_ALL": "C.UTF-8",
                           "CLAYMELD_CACHE": str(cls.folder / "cache")}

    @classmethod
    def call(cls, *words):
        done = subprocess.run(list(map(str, words)), env=cls.environment, cwd=cls.folder, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise AssertionError(f"{words} ended with {done.returncode}\n{done.stdout[-8000:]}{done.stderr[-8000:]}")
        return done.stdout

    def same_facts(self, run):
        """A program has the facts of this build, on two processes; `run` makes a command of a command of meldsim."""
        program = ROOT / "examples/meld/gradient.meld"
        self.call(*run(f"meldsim run {program} --quiet -n 2 --facts-out {self.folder}/built.facts"))
        self.call(pathlib.Path(TOOLS.build).resolve() / "bin/meldsim", "run", program, "--quiet", "--facts-out", self.folder / "here.facts")
        self.assertEqual((self.folder / "built.facts").read_text(), (self.folder / "here.facts").read_text())


@unittest.skipIf(shutil.which("spack") is None, "there is no spack")
class Spack(InEmptyHome):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.environment |= {"SPACK_USER_CONFIG_PATH": str(cls.folder / "config"), "SPACK_USER_CACHE_PATH": str(cls.folder / "spack"),
                            "SPACK_SKIP_MODULES": "1"}
        cls.environment |= {name: os.environ[name] for name in ("SPACK_PYTHON",) if name in os.environ}
        # The repositories of packages are those that this Spack knows, wherever its user has told so.
        known = subprocess.run(["spack", "config", "get", "repos"], capture_output=True, text=True, check=True).stdout
        cls.repositories = cls.folder / "repos.yaml"
        cls.repositories.write_text(re.sub(r"^ +(claymeld:|- ).*packaging/spack\n", "", known, flags=re.MULTILINE))
        cls.call("spack", "config", "add", "-f", cls.repositories)
        cls.call("spack", "config", "add", f"config:install_tree:root:{cls.folder / 'tree'}")
        cls.call("spack", "compiler", "find")
        cls.call("spack", "repo", "add", PACKAGING / "spack")
        cls.call("spack", "config", "add", "-f", PACKAGING / "spack/debian12.yaml")
        if SOURCES:
            cls.call("spack", "mirror", "add", "--type", "source", "sources", f"file://{SOURCES}")

    def test_the_recipes_pass_its_audit(self):
        self.assertIn("PKG-DIRECTIVES: passed", self.call("spack", "audit", "packages", "claymeld", "ode", "civetweb"))

    def test_on_debian_it_builds_claymeld_and_what_debian_lacks(self):
        for spec, parts, built in (("claymeld@main", "+models+view", OF_SPACK),
                                   ("claymeld@0.1.0~view", "+models~view", OF_SPACK - {"civetweb"})):
            out = self.call("spack", "spec", "-I", spec)
            missing = {re.match(r"[\w-]+", line.split("-", 1)[1].strip().lstrip("^"))[0] for line in out.splitlines()
                       if re.match(r"( - |\[\+\])", line)}
            self.assertEqual(missing, built, out)
            self.assertRegex(out, rf"claymeld@\S+\S*{re.escape(parts)}.* build_type=RelWithDebInfo .*generator=ninja")

    @unittest.skipUnless(BUILDS, "it takes long (CLAYMELD_BUILD_RECIPES=1)")
    def test_it_builds_and_runs(self):
        self.call("spack", "install", *(["--no-checksum"] if SOURCES else []), "--test=root", "claymeld@main")
        self.same_facts(lambda command: ["bash", "-c", f'eval "$(spack load --sh claymeld)" && {command}'])


@unittest.skipIf(shutil.which("eb") is None or not LMOD.exists(), "there is no eb (pip install easybuild), or no Lmod")
class EasyBuild(InEmptyHome):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.environment |= {"EASYBUILD_PREFIX": str(cls.folder / "easybuild"), "EASYBUILD_ALLOW_USE_AS_ROOT_AND_ACCEPT_CONSEQUENCES": "1",
                            "EASYBUILD_SOURCEPATH": ":".join(filter(None, (str(cls.folder / "sources"), SOURCES)))}
        # Debian's compiler and MPI in the place of the toolchain, and its libraries in the place of what has their names.
        for name in ("GCCcore/13.3.0", "GCC/13.3.0", "OpenMPI/5.0.3-GCC-13.3.0", "gompi/2024a", "binutils/2.42-GCCcore-13.3.0"):
            module = cls.folder / f"modules/{name}.lua"
            module.parent.mkdir(parents=True, exist_ok=True)
            word, version = name.upper().split("/")
            loads = TOOLCHAIN.get(name, ())
            module.write_text("".join(f'depends_on("{other}")\n' for other in loads) +
                              f'setenv("EBROOT{word}", "/usr")\nsetenv("EBVERSION{word}", "{version.split("-")[0]}")\n')
        cls.here = cls.folder / "here.cfg"
        asked = re.findall(r"^    \('(\w+)', '", EASYCONFIG.read_text(), re.MULTILINE)
        cls.here.write_text(f"[override]\nfilter-deps = {','.join(name for name in asked if name not in ('ODE', 'civetweb'))}\n")

    def eb(self, words):
        return self.call("bash", "-c", f". {LMOD} && module use {self.folder}/modules && {words}")

    def test_its_style_is_easybuilds(self):
        try:
            out = self.eb(f"eb --check-style {' '.join(map(str, PACKAGING.glob('easybuild/*.eb')))}")
        except AssertionError as error:
            if "pycodestyle or pep8" in str(error):
                self.skipTest("there is no pycodestyle beside eb")
            raise
        self.assertIn("All style checks PASSed", out)

    def test_it_finds_all_that_is_asked_for(self):
        out = self.call("bash", "-c", f". {LMOD} && eb --dry-run --robot={PACKAGING}/easybuild: {EASYCONFIG}")
        self.assertIn(f"(module: Claymeld/{EASYCONFIG.stem.removeprefix('Claymeld-')})", out)
        for path in PACKAGING.glob("easybuild/*.eb"):
            self.assertIn(str(path), out)

    @unittest.skipUnless(BUILDS, "it takes long (CLAYMELD_BUILD_RECIPES=1)")
    def test_it_builds_and_runs(self):
        version = re.search(r"version = '(.*)'", EASYCONFIG.read_text())[1]
        folder = self.folder / "sources/c/Claymeld"
        folder.mkdir(parents=True)
        self.call("git", "-C", ROOT, "archive", f"--prefix=claymeld-{version}/", "-o", folder / f"claymeld-{version}.tar.gz", "HEAD")
        self.eb(f"eb --configfiles={self.here} --robot={PACKAGING}/easybuild: {'--ignore-checksums' if SOURCES else ''} {EASYCONFIG}")
        modules = f"{self.folder}/modules {self.folder}/easybuild/modules/all"
        self.same_facts(lambda command: ["bash", "-c", f". {LMOD} && module use {modules} && module load Claymeld && {command}"])


@unittest.skipIf(rattler_build is None, "there is no rattler-build (pip install py-rattler-build)")
class Conda(unittest.TestCase):
    def test_the_recipe_is_rendered(self):
        recipe = rattler_build.Stage0Recipe.from_file(PACKAGING / "conda/recipe.yaml")
        compilers = rattler_build.VariantConfig({"c_compiler": ["gcc"], "cxx_compiler": ["gxx"]})
        rendered = recipe.render(compilers)
        self.assertEqual(len(rendered), 1)
        found = rendered[0].recipe.to_dict()
        self.assertEqual(found["package"]["name"], "claymeld")
        self.assertIn("gxx_linux-64", map(str, found["requirements"]["build"]))
        self.assertEqual(len(found["source"]), 4)


if __name__ == "__main__":
    main("build")
