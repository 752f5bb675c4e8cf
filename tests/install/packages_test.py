"""The Debian packages: claymeld needs nothing that only pictures and the viewer need, and claymeld-view brings just that.

    packages_test.py --build FOLDER [unittest options]
"""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from frame import TOOLS, main  # noqa: E402

# Of pictures and the viewer: rays, drawing, the server; and what these bring.
FOR_PICTURES = re.compile(r"lib(embree|cairo|civetweb|tbb|x11|pixman|fontconfig)|fonts-|ffmpeg")


def fields(package):
    out = subprocess.run(["dpkg-deb", "--field", package], capture_output=True, text=True, check=True).stdout
    return dict(line.split(": ", 1) for line in out.splitlines() if re.match(r"[A-Z][\w-]*: ", line))


def names(field):
    return [entry.split()[0] for entry in field.split(", ")]


@unittest.skipIf(shutil.which("dpkg-shlibdeps") is None, "there is no dpkg-shlibdeps (the package dpkg-dev), which names the libraries")
class Packages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="meld packages "))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        # Quick to write; nobody keeps them.
        done = subprocess.run(["cpack", "-G", "DEB", "-B", cls.folder, "--config", pathlib.Path(TOOLS.build, "CPackConfig.cmake"),
                               "-D", "CPACK_DEBIAN_COMPRESSION_TYPE=none"], cwd=cls.folder, capture_output=True, text=True)
        if done.returncode != 0:
            raise AssertionError(done.stdout + done.stderr)
        cls.claymeld, cls.view = (next(cls.folder.glob(f"{name}_*.deb")) for name in ("claymeld", "claymeld-view"))

    def files(self, package):
        out = subprocess.run(f"dpkg-deb --fsys-tarfile '{package}' | tar -t", shell=True, capture_output=True, text=True, check=True).stdout
        return {line.removeprefix(".") for line in out.splitlines() if not line.endswith("/")}

    def test_claymeld_needs_nothing_of_pictures(self):
        found = fields(self.claymeld)
        self.assertEqual(found["Package"], "claymeld")
        for library in ("openmpi-bin", "libhdf5-openmpi-103-1", "libclang-cpp19", "libopenmpi3"):
            self.assertIn(library, names(found["Depends"]))
        for field in ("Depends", "Recommends"):
            self.assertEqual([name for name in names(found[field]) if FOR_PICTURES.match(name)], [], field)
        self.assertIn("claymeld-view", names(found["Suggests"]))

    def test_the_view_is_of_the_same_version_and_small(self):
        found = fields(self.view)
        self.assertEqual(found["Version"], fields(self.claymeld)["Version"])
        self.assertIn(f"claymeld (= {found['Version']})", found["Depends"].split(", "))
        for library in ("libembree3-3", "libcairo2", "libcivetweb1", "fonts-dejavu-core"):
            self.assertIn(library, names(found["Depends"]))
        self.assertEqual({path for path in self.files(self.view) if "/doc/" not in path}, {"/usr/lib/claymeld/libmeld_view.so"})
        self.assertLess(int(found["Installed-Size"]), 200)

    def test_no_file_is_in_both(self):
        self.assertEqual(self.files(self.claymeld) & self.files(self.view), set())
        for path in ("/usr/bin/meldsim", "/usr/bin/meldc", "/usr/lib/claymeld/libmeld_backend.so", "/usr/share/man/man1/meldsim.1"):
            self.assertIn(path, {found.removesuffix(".gz") for found in self.files(self.claymeld)})


if __name__ == "__main__":
    main("build")
