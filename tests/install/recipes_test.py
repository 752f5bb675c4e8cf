"""The recipes of packaging/: each names every library that CMake looks for, and the version of Claymeld, and can be read by what reads it.

    recipes_test.py [unittest options]

What no machine of ours can do is to build them; docs/releasing.md says so.
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
# What CMake looks for, and its name in Spack, EasyBuild and conda; None: it comes with a compiler or a system, or is for tests only.
LIBRARIES = {
    "Threads": None, "PkgConfig": ("pkgconfig", "pkgconf", "pkg-config"), "GTest": None, "MPI": ("openmpi", "gompi", "openmpi"),
    "BISON": ("bison", "Bison", "bison"), "FLEX": ("flex", "flex", "flex"), "fmt": ("fmt", "fmt", "fmt"),
    "CLI11": ("cli11", "CLI11", "cli11"), "nlohmann_json": ("nlohmann-json", "nlohmann_json", "nlohmann_json"),
    "tomlplusplus": ("tomlplusplus", "tomlplusplus", "tomlplusplus"), "HDF5": ("hdf5", "HDF5", "hdf5"), "ODE": ("ode", "ode", "ODE_SOURCE"),
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
           "Random123/": ("random123", "random123", "random123")}


def looked_for():
    """The first words of what CMake looks for."""
    texts = [path.read_text() for path in [ROOT / "CMakeLists.txt", *ROOT.glob("cmake/*.cmake"), *ROOT.glob("runtime/**/generate.cmake")]]
    words = re.findall(r"^\s*(?:find_package|pkg_check_modules|pkg_search_module|find_path|find_library|find_file|find_program)\((\w+)",
                       "\n".join(texts), re.MULTILINE)
    return {re.split(r"_(?:INCLUDE|LIBRARY|ELF|COMMON|LSP|MODULE)", word)[0] for word in words}


def constants(path):
    """The strings and names of a recipe in Python."""
    return {node.value for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.Constant) and isinstance(node.value, str)}


class Recipes(unittest.TestCase):
    def test_every_library_has_its_name(self):
        self.assertEqual(looked_for() - set(LIBRARIES), set(), "say how these are called in packaging/, and add them to the recipes there")
        self.assertEqual({word for word in LIBRARIES if LIBRARIES[word]} - looked_for(), set())
        sources = "".join(path.read_text() for path in [*ROOT.glob("runtime/base/**/*.h"), *ROOT.glob("runtime/base/**/*.cpp"),
                                                        *ROOT.glob("runtime/**/random*.h"), *ROOT.glob("runtime/**/random*.cpp")])
        for header in HEADERS:
            self.assertRegex(sources, rf"#include <{re.escape(header)}")

    def test_the_recipes_name_every_library(self):
        recipe = (PACKAGING / "spack/packages/claymeld/package.py").read_text()
        spack = set(re.findall(r'depends_on\("([\w-]+)', recipe)) | set(re.findall(r'resource\(name="(\w+)"', recipe)) | set(
            re.findall(r"\+(\w+)", re.search(r'depends_on\("llvm(.*?)"', recipe)[1]))
        easybuild = constants(next(PACKAGING.glob("easybuild/*.eb")))
        easybuild |= {name for text in easybuild for name in re.findall(r"^(three|linux)-", text)} | {"gompi"}
        easybuild |= {"esbuild"} if any("@esbuild/" in text for text in easybuild) else set()
        conda = set(re.findall(r"^ +- ([\w-]+)", (PACKAGING / "conda/environment.yml").read_text(), re.MULTILINE))
        conda |= set(re.findall(r"[A-Z]+_SOURCE", (PACKAGING / "conda/build.sh").read_text()))
        for word, names in {**LIBRARIES, **HEADERS}.items():
            for name, known, where in zip(names or (), (spack, easybuild, conda), ("spack", "easybuild", "conda")):
                self.assertIn(name, known, f"{word} in packaging/{where}")

    def test_conda_names_the_same_twice(self):
        environment = (PACKAGING / "conda/environment.yml").read_text().split("# The Python package")[0]
        wanted = set(re.findall(r"^ +- (\S+)", environment, re.MULTILINE))
        recipe = (PACKAGING / "conda/meta.yaml").read_text().split("requirements:")[1].split("test:")[0]
        self.assertEqual(set(re.findall(r"^ +- ([^\s{]+)", recipe, re.MULTILINE)), wanted - {"conda-forge", "cxx-compiler"})

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
        for path, pattern in (("spack/packages/claymeld/package.py", r'version\("(.*?)"'), ("conda/meta.yaml", r'version: "(.*?)"'),
                              ("spack/packages/claymeld/package.py", r"/claymeld-(\S+)\.tar\.gz\""),
                              ("apptainer/claymeld.def", r"Version (\S+)")):
            self.assertEqual(re.search(pattern, (PACKAGING / path).read_text())[1], VERSION, path)
        self.assertTrue(next(PACKAGING.glob("easybuild/*.eb")).name.startswith(f"Claymeld-{VERSION}-"))

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
        for path in ("spack/packages/claymeld/package.py", "conda/build.sh", "easybuild/Claymeld-0.1.0-gompi-2024a.eb"):
            for option in re.findall(r"\b(CLAYMELD_\w+|ESBUILD|THREE_MODULE)\b", (PACKAGING / path).read_text()):
                self.assertRegex(texts, rf"\b{option}\b", f"{path}: {option}")

    @unittest.skipIf(shutil.which("cffconvert") is None, "there is no cffconvert")
    def test_the_citation_is_valid(self):
        subprocess.run(["cffconvert", "--validate", "-i", ROOT / "CITATION.cff"], check=True)


if __name__ == "__main__":
    unittest.main()
