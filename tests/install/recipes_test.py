"""The recipes of packaging/: each names every library that CMake looks for, and the version of Claymeld, and can be read by what reads it.

    recipes_test.py [unittest options]

built_test.py builds them where Spack, EasyBuild or rattler-build is; docs/releasing.md says what has been built.
"""
import ast
import pathlib
import re
import shutil
import subprocess
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PACKAGING = ROOT / "packaging"
VERSION = re.search(r'kVersion\[\] = "(.*?)"', (ROOT / "runtime/base/version.h").read_text())[1]
EASYCONFIG = next(PACKAGING.glob("easybuild/Claymeld-*.eb"))
# What CMake looks for, and its name in Spack, EasyBuild and conda; None: it comes with a compiler or a system, or is for tests only.
LIBRARIES = {
    "Threads": None, "PkgConfig": ("pkgconfig", "pkgconf", "pkg-config"), "GTest": None, "MPI": ("openmpi", "gompi", "openmpi"),
    "BISON": ("bison", "Bison", "bison"), "FLEX": ("flex", "flex", "flex"), "fmt": ("fmt", "fmt", "fmt"),
    "CLI11": ("cli11", "CLI11", "cli11"), "nlohmann_json": ("nlohmann-json", "nlohmann_json", "nlohmann_json"),
    "tomlplusplus": ("tomlplusplus", "tomlplusplus", "tomlplusplus"), "HDF5": ("hdf5", "HDF5", "hdf5"), "ODE": ("ode", "ODE", "ODE_SOURCE"),
    "Eigen3": ("eigen", "Eigen", "eigen"), "embree": ("embree", "Embree", "embree"), "CAIRO": ("cairo", "cairo", "cairo"),
    "CIVETWEB": ("civetweb", "civetweb", "CIVETWEB_SOURCE"), "ZLIB": ("zlib-api", "zlib", "zlib"),
    "ASSIMP": ("assimp", "assimp", "assimp"), "TINYXML": ("tinyxml2", "tinyxml2", "tinyxml2"), "METIS": ("metis", "METIS", "metis"),
    "SQLITE": ("sqlite", "SQLite", "sqlite"), "EDIT": ("libedit", "libedit", "libedit"), "LLVM": ("llvm", "LLVM", "llvmdev"),
    "CLANG": ("clang", "LLVM", "clangdev"), "LLD": ("lld", "LLVM", "lld"), "MLIR": None,
    "THREE": ("three", "three", "THREE_SOURCE"), "ESBUILD": ("esbuild", "esbuild", "esbuild"), "CCACHE": None, "CLANG_FORMAT": None,
    "DEBOOTSTRAP": None,
}
# Headers that nothing looks for, since they are where the compiler looks.
HEADERS = {"xxhash.h": ("xxhash", "xxHash", "xxhash"), "tl/expected.hpp": ("tl-expected", "expected", "tl-expected"),
           "Random123/": ("random123", "Random123", "random123")}


# What a Debian package of scripts/install is in Spack, EasyBuild and conda, beyond a word of LIBRARIES or HEADERS; None: part of another.
OF_DEBIAN = {
    "g++": ("cxx", "gompi", "cxx-compiler"), "cmake": ("cmake", "CMake", "cmake"), "ninja-build": ("ninja", "Ninja", "ninja"),
    "pkg-config": "PkgConfig", "bison": "BISON", "flex": "FLEX", "llvm-19-dev": "LLVM", "libclang-19-dev": "CLANG", "liblld-19-dev": "LLD",
    "libopenmpi-dev": "MPI", "openmpi-bin": "MPI", "libode-dev": "ODE", "libembree-dev": "embree", "libeigen3-dev": "Eigen3",
    "libcairo2-dev": "CAIRO", "fonts-dejavu-core": None, "libcivetweb-dev": "CIVETWEB", "libhdf5-openmpi-dev": "HDF5",
    "libtomlplusplus-dev": "tomlplusplus", "nlohmann-json3-dev": "nlohmann_json", "libcli11-dev": "CLI11", "libassimp-dev": "ASSIMP",
    "libtinyxml2-dev": "TINYXML", "libmetis-dev": "METIS", "libsqlite3-dev": "SQLITE", "libedit-dev": "EDIT", "esbuild": "ESBUILD",
    "libjs-three": "THREE", "zlib1g-dev": "ZLIB", "libfmt-dev": "fmt", "libexpected-dev": "tl/expected.hpp",
    "librandom123-dev": "Random123/", "libxxhash-dev": "xxhash.h",
}
# Which Debian package a stand-in of packaging/spack/debian12.yaml is, where its name in scripts/install is of another library.
MORE_OF_DEBIAN = {"zstd": "libzstd-dev", "gmake": "make", "llvm": "llvm-19-dev", "openmpi": "libopenmpi-dev", "zlib": "zlib1g-dev",
                  "pkgconf": "pkg-config"}


def looked_for():
    """The first words of what CMake looks for."""
    texts = [path.read_text() for path in [ROOT / "CMakeLists.txt", *ROOT.glob("cmake/*.cmake"), *ROOT.glob("runtime/**/generate.cmake")]]
    words = re.findall(r"^\s*(?:find_package|pkg_check_modules|pkg_search_module|find_path|find_library|find_file|find_program)\((\w+)",
                       "\n".join(texts), re.MULTILINE)
    return {re.split(r"_(?:INCLUDE|LIBRARY|ELF|COMMON|LSP|MODULE)", word)[0] for word in words}


def constants(path):
    """The strings and names of a recipe in Python."""
    return {node.value for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.Constant) and isinstance(node.value, str)}


def easyconfig(path):
    """The variables of an easyconfig; names of EasyBuild's stand for themselves."""
    given = {"SYSTEM": {"name": "system", "version": "system"}, "SHLIB_EXT": "so", "SOURCELOWER_TAR_GZ": "%(namelower)s-%(version)s.tar.gz",
             "SOURCE_TAR_GZ": "%(name)s-%(version)s.tar.gz"}
    exec(compile(path.read_text(), str(path), "exec"), given)  # noqa: S102
    return given


def spack_externals():
    """What packaging/spack/debian12.yaml names: the version of each package and its prefix."""
    text = (PACKAGING / "spack/debian12.yaml").read_text()
    return {name: (version, prefix) for name, version, prefix in
            re.findall(r"- \{spec: \"?([\w-]+)@([\w.-]+).*?, prefix: (\S+)\}", text)}


def of_debian(names):
    """The names in Spack, EasyBuild and conda of a Debian package."""
    return {**LIBRARIES, **HEADERS}[names] if isinstance(names, str) else names


class Recipes(unittest.TestCase):
    def test_every_library_has_its_name(self):
        self.assertEqual(looked_for() - set(LIBRARIES), set(), "say how these are called in packaging/, and add them to the recipes there")
        self.assertEqual({word for word in LIBRARIES if LIBRARIES[word]} - looked_for(), set())
        sources = "".join(path.read_text() for path in [*ROOT.glob("runtime/base/**/*.h"), *ROOT.glob("runtime/base/**/*.cpp"),
                                                        *ROOT.glob("runtime/**/random*.h"), *ROOT.glob("runtime/**/random*.cpp")])
        for header in HEADERS:
            self.assertRegex(sources, rf"#include <{re.escape(header)}")

    def test_the_recipes_name_every_library(self):
        for word, names in {**LIBRARIES, **HEADERS}.items():
            for name, known, where in zip(names or (), self.named(), ("spack", "easybuild", "conda")):
                self.assertIn(name, known, f"{word} in packaging/{where}")

    def named(self):
        """What the recipes for Spack, EasyBuild and conda name."""
        recipe = (PACKAGING / "spack/packages/claymeld/package.py").read_text()
        spack = set(re.findall(r'depends_on\("([\w-]+)', recipe)) | set(re.findall(r'resource\(name="(\w+)"', recipe)) | set(
            re.findall(r"\+(\w+)", re.search(r'depends_on\("llvm(.*?)"', recipe)[1]))
        config = easyconfig(EASYCONFIG)
        easybuild = {entry[0] for entry in config["dependencies"] + config["builddependencies"]} | {config["toolchain"]["name"]}
        easybuild |= {re.match("[a-z]+", source["filename"])[0] for source in config["sources"] if isinstance(source, dict)}
        conda = set(re.findall(r"^ +- ([\w-]+)", (PACKAGING / "conda/environment.yml").read_text(), re.MULTILINE))
        conda |= {f"{name}_SOURCE" for name in re.search(r"for library in (.*?);", (PACKAGING / "conda/build.sh").read_text())[1].split()}
        return spack, easybuild, conda

    def test_the_recipes_name_what_scripts_install_does(self):
        script = (ROOT / "scripts/install").read_text()
        packages = re.sub("#.*", "", re.search(r"^packages=\((.*?)^\)", script, re.S | re.M)[1]).split()
        self.assertEqual(set(packages), set(OF_DEBIAN))
        for package in packages:
            for name, known, where in zip(of_debian(OF_DEBIAN[package]) or (), self.named(), ("spack", "easybuild", "conda")):
                self.assertIn(name, known, f"{package} in packaging/{where}")

    def test_the_file_of_debian_has_all_that_spack_needs_and_debian_has(self):
        externals = spack_externals()
        recipe = (PACKAGING / "spack/packages/claymeld/package.py").read_text()
        needed = set(re.findall(r'depends_on\("([\w-]+)', recipe)) - {"c", "cxx", "ode", "civetweb", "pkgconfig", "zlib-api"}
        self.assertEqual(needed | {"pkgconf", "zlib", "gmake"}, set(externals))
        # The same versions as the packages that are installed, but for cairo, where the file says why.
        externals["cairo"] = ("1.16.0", externals["cairo"][1])
        of_name = {names[0]: package for package, word in OF_DEBIAN.items() if (names := of_debian(word))} | MORE_OF_DEBIAN
        if shutil.which("dpkg-query") is None or "VERSION_ID=\"12\"" not in pathlib.Path("/etc/os-release").read_text():
            self.skipTest("this is not Debian 12")
        for name, (version, prefix) in externals.items():
            done = subprocess.run(["dpkg-query", "-W", "-f", "${Version}", of_name[name]], capture_output=True, text=True, check=False)
            if done.returncode == 0:
                self.assertTrue(done.stdout.split(":")[-1].startswith(version), f"{name}@{version}: {of_name[name]} is {done.stdout}")
                self.assertTrue(pathlib.Path(prefix).is_dir(), prefix)

    def test_easyconfigs_beside_the_first_are_those_that_it_asks_for(self):
        config = easyconfig(EASYCONFIG)
        asked = {entry[0]: entry[1] for entry in config["dependencies"] + config["builddependencies"]}
        for path in PACKAGING.glob("easybuild/*.eb"):
            other = easyconfig(path)
            toolchain = other["toolchain"]
            self.assertEqual(path.name, f"{other['name']}-{other['version']}-{toolchain['name']}-{toolchain['version']}.eb")
            if path != EASYCONFIG:
                self.assertEqual(asked[other["name"]], other["version"])
                self.assertRegex(other["checksums"][0], "^[0-9a-f]{64}$")
            for line in path.read_text().splitlines():
                self.assertLessEqual(len(line), 120, f"EasyBuild's style, {path.name}: {line}")
        # Only the archive of Claymeld gets its sum when there is one.
        self.assertEqual([sum is None for sum in config["checksums"]], [True, False, False])

    def test_sums_are_the_same_everywhere(self):
        """ODE, civetweb and three.js are of one version in all recipes, so their files are the same."""
        spack = {name: re.search(r'sha256="(\w+)"', (PACKAGING / f"spack/packages/{name}/package.py").read_text())[1]
                 for name in ("ode", "civetweb")}
        claymeld = (PACKAGING / "spack/packages/claymeld/package.py").read_text()
        spack["three"] = re.search(r'resource\(name="three".*?sha256="(\w+)"', claymeld, re.S)[1]
        config = easyconfig(EASYCONFIG)
        others = [easyconfig(path) for path in PACKAGING.glob("easybuild/*.eb")]
        easybuild = {other["name"].lower(): other["checksums"][0] for other in others if other["name"] in ("ODE", "civetweb")}
        easybuild["three"] = config["checksums"][1]
        conda = dict(re.findall(r"sha256: (\w+)\n +target_directory: third_party/(\w+)", (PACKAGING / "conda/recipe.yaml").read_text()))
        self.assertEqual(easybuild, spack)
        self.assertEqual({name: sum for sum, name in conda.items()}, spack)
        self.assertIn(config["checksums"][2], claymeld)

    def test_conda_names_the_same_twice(self):
        environment = (PACKAGING / "conda/environment.yml").read_text().split("# The Python package")[0]
        wanted = set(re.findall(r"^ +- (\S+)", environment, re.MULTILINE))
        recipe = (PACKAGING / "conda/recipe.yaml").read_text().split("requirements:")[1].split("tests:")[0]
        self.assertEqual(set(re.findall(r"^ +- ([^\s{$]+)", recipe, re.MULTILINE)), wanted - {"conda-forge", "cxx-compiler", "c-compiler"})
        # What runs need is among what builds need.
        built, run = (set(re.findall(r"^ +- (.+)", part, re.MULTILINE)) for part in recipe.split("run:"))
        self.assertLess(run, built)

    def test_every_recipe_can_be_read(self):
        for path in [*PACKAGING.glob("spack/packages/*/package.py"), *PACKAGING.glob("easybuild/*.eb")]:
            ast.parse(path.read_text(), str(path))
        for path in PACKAGING.glob("**/*.sh"):
            subprocess.run(["bash", "-n", path], check=True)
        # Every Spack package that is named and is not Spack's is here.
        here = {path.parent.name for path in PACKAGING.glob("spack/packages/*/package.py")}
        self.assertEqual(here, {"claymeld", "ode", "civetweb"})
        for name in here:
            self.assertIn(f"class {name.capitalize()}(CMakePackage)", (PACKAGING / f"spack/packages/{name}/package.py").read_text())

    def test_what_spack_downloads_has_a_sum(self):
        """Without one Spack refuses it. Only the archive of Claymeld gets its sum when there is one."""
        for path in PACKAGING.glob("spack/packages/*/package.py"):
            calls = [node for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.Call) and
                     getattr(node.func, "id", "") in ("version", "resource")]
            for call in calls:
                sums = [word.value.value for word in call.keywords if word.arg == "sha256"]
                if call.func.id == "version" and path.parent.name == "claymeld":
                    self.assertEqual(sums, [])
                else:
                    self.assertRegex(" ".join(sums), r"^[0-9a-f]{64}$", f"{path}:{call.lineno}")
            self.assertRegex(path.read_text(), r'(?m)^    url = ', path)

    def test_all_are_of_this_version(self):
        for path, pattern in (("spack/packages/claymeld/package.py", r'version\("(.*?)"'), ("conda/recipe.yaml", r'version: "(.*?)"'),
                              ("spack/packages/claymeld/package.py", r"/claymeld-(\S+)\.tar\.gz\""),
                              ("apptainer/claymeld.def", r"Version (\S+)")):
            self.assertEqual(re.search(pattern, (PACKAGING / path).read_text())[1], VERSION, path)
        self.assertEqual(easyconfig(EASYCONFIG)["version"], VERSION)

    def test_what_recipes_call_is_there(self):
        container = (PACKAGING / "oci/Containerfile").read_text()
        for script in re.findall(r"scripts/\w+", container):
            self.assertTrue((ROOT / script).exists(), script)
        for text in (container, (PACKAGING / "apptainer/claymeld.def").read_text()):
            for name in ("claymeld_*.deb", "claymeld-view_*.deb"):
                self.assertIn(name, text)
        # Options that recipes give are those of CMake.
        texts = "\n".join(path.read_text() for path in [*ROOT.glob("cmake/*.cmake"), ROOT / "CMakeLists.txt",
                                                        *ROOT.glob("runtime/**/generate.cmake")])
        for path in ("spack/packages/claymeld/package.py", "conda/build.sh", EASYCONFIG.relative_to(PACKAGING)):
            for option in re.findall(r"\b(CLAYMELD_\w+|ESBUILD|THREE_MODULE)\b", (PACKAGING / path).read_text()):
                self.assertRegex(texts, rf"\b{option}\b", f"{path}: {option}")

    @unittest.skipIf(shutil.which("cffconvert") is None, "there is no cffconvert")
    def test_the_citation_is_valid(self):
        subprocess.run(["cffconvert", "--validate", "-i", ROOT / "CITATION.cff"], check=True)


if __name__ == "__main__":
    unittest.main()
