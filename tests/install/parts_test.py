"""Builds without optional parts: what they need is not looked for, and the commands that they have say so.

    parts_test.py --build FOLDER [unittest options]

Only the layers that are others without the parts are compiled, quickly, and linked with those of the build, which are the same.
"""
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from frame import COUNT, TOOLS, Case, main, square  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
OTHERS = ("runtime_show_library", "runtime_show_render", "runtime_show_view", "runtime_show_view_page", "runtime_world_model")
# As it would fail on a machine that has none of them.
NO_LIBRARIES = """#!/bin/sh
for word in "$@"; do
  case $word in *cairo*|*assimp*|*tinyxml*|*embree*|*civetweb*) exit 1;; esac
done
exec pkg-config "$@"
"""
TRIANGLE = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n"
CONFIGURATION = '<world gridSize="2,2,1"><blockList blockSize="1,1,1"><block position="0,0,0"/></blockList></world>'


class Parts(Case):
    FILES = {"p.meld": COUNT, "p.toml": square(3), "mesh.stl": TRIANGLE, "modules.xml": CONFIGURATION,
             "mesh.toml": 'lattice = "cubic"\n[[body]]\nshape = "mesh(\'mesh.stl\', size = 4)"\n',
             "study.toml": 'program = "p.meld"\nseeds = 2\n'}

    @classmethod
    def setUpClass(cls):
        cls.build = pathlib.Path(tempfile.mkdtemp(prefix="meld parts "))
        cls.addClassCleanup(shutil.rmtree, cls.build)
        finder = cls.build / "pkg-config"
        finder.write_text(NO_LIBRARIES)
        finder.chmod(0o755)
        cls.configured = cls.configure("-DCLAYMELD_PROGRAMS_ONLY=ON", "-DCMAKE_DISABLE_FIND_PACKAGE_embree=ON",
                                       f"-DPKG_CONFIG_EXECUTABLE={finder}", folder=cls.build / "build")
        cls.link()

    @classmethod
    def configure(cls, *options, folder):
        fast = ["CMAKE_BUILD_TYPE=Debug", "CMAKE_CXX_FLAGS_DEBUG=-O0", "CLAYMELD_UNITY=ON", "CLAYMELD_PRECOMPILE=OFF"]
        return subprocess.run(["cmake", "-S", ROOT, "-B", folder, "-G", "Ninja", *(f"-D{each}" for each in fast),
                               "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON", "-DCLAYMELD_VIEWER=OFF", "-DCLAYMELD_MODELS=OFF", *options],
                              capture_output=True, text=True)

    @classmethod
    def compile(cls):
        """The objects of each layer that is another one."""
        objects = {layer: [] for layer in OTHERS}
        for entry in json.loads((cls.build / "build" / "compile_commands.json").read_text()):
            made = re.search(r" -o (CMakeFiles/(\w+)\.dir/\S+)", entry["command"])
            if made[2] not in objects:
                continue
            done = subprocess.run(entry["command"], shell=True, cwd=entry["directory"], capture_output=True, text=True)
            if done.returncode != 0:
                raise AssertionError(done.stdout + done.stderr)
            objects[made[2]].append(pathlib.Path(entry["directory"], made[1]))
        return objects

    @classmethod
    def link(cls):
        """meldsim, beside what it finds there."""
        if cls.configured.returncode != 0:
            raise AssertionError(cls.configured.stdout + cls.configured.stderr)
        objects = cls.compile()
        commands = subprocess.run(["ninja", "-C", TOOLS.build, "-t", "commands", "meldsim"], capture_output=True, text=True, check=True)
        command = commands.stdout.strip().splitlines()[-1]
        for layer in OTHERS:
            command, found = re.subn(rf"(?<=\s)lib{layer}\.a\b", " ".join(f"'{path}'" for path in objects[layer]), command, count=1)
            assert found, f"{layer} is not among what meldsim is linked with: {command}"
            command = re.sub(rf"(?<=\s)lib{layer}\.a\b", "", command)
        command = re.sub(r"\S+/lib(assimp|tinyxml2)\.so\S*", "", command)
        prefix = cls.build / "installed"
        (prefix / "bin").mkdir(parents=True)
        cls.meldsim = prefix / "bin" / "meldsim"
        command = re.sub(r" -o \S+", f" -o '{cls.meldsim}'", command)
        done = subprocess.run(command, shell=True, cwd=TOOLS.build, capture_output=True, text=True)
        if done.returncode != 0:
            raise AssertionError(done.stdout + done.stderr)
        (prefix / "bin" / "meldc").symlink_to(pathlib.Path(TOOLS.build, "bin", "meldc").resolve())

    def call(self, tool, *arguments, **options):
        return super().call(self.meldsim if tool == "meldsim" else tool, *arguments, **options)

    def test_nothing_of_them_is_looked_for(self):
        cache = (self.build / "build" / "CMakeCache.txt").read_text()
        self.assertNotRegex(cache, r"(?m)^(CIVETWEB|CAIRO|ASSIMP|TINYXML|ESBUILD|THREE|embree)")
        needed = subprocess.run(["readelf", "-d", self.meldsim], capture_output=True, text=True, check=True).stdout
        self.assertIn("NEEDED", needed)
        self.assertNotRegex(needed, "embree|cairo|civetweb|assimp|tinyxml")

    def test_runs_are_the_same(self):
        self.call("meldsim", "run", "p.meld", "--digest", "without", "--quiet")
        self.run_tool(pathlib.Path(TOOLS.build, "bin", "meldsim"), "run", "p.meld", "--digest", "with", "--quiet")
        self.assertEqual(self.read("without"), self.read("with"))
        out, _ = self.call("meldsim", "sweep", "study.toml", "--table")
        self.assertIn("runs", out)
        self.call("meldsim", "export", "p.meld", "-o", "p.ply", "--quiet")

    def test_what_is_left_out_says_so(self):
        says = "this meldsim was built without pictures and the viewer. Use one that was built with -DCLAYMELD_VIEWER=ON"
        for command in (["shot", "p.meld", "-o", "p.png"], ["movie", "p.meld", "-o", "p.mp4"], ["view", "p.meld", "--for", "1"],
                        ["view", "p.meld", "--share", "p.html"], ["sweep", "study.toml", "--plot", "ticks~messages"],
                        ["sweep", "study.toml", "--show", "1"]):
            with self.subTest(command=command):
                self.refused("meldsim", *command, code=2, says=says)
        # What it says of the world comes first.
        self.assertIn(says, self.call("meldsim", "world", "p.toml", "--shot", "p.png", code=2)[1])
        self.assertEqual({name for name in self.files() if name.startswith("p.")}, {"p.meld", "p.toml"})
        self.refused("meldsim", "run", "p.meld", "--world", "mesh.toml", code=2,
                     says="mesh.stl is a mesh, and this meldsim was built to read voxels (.vox) only. "
                          "Use a meldsim that was built with -DCLAYMELD_MODELS=ON")
        self.refused("meldsim", "world", "--import", "modules.xml", "--lattice", "square", "-o", "modules.toml", code=2,
                     says="was built without XML, in which configurations of VisibleSim are")

    def test_tests_need_all_parts(self):
        done = self.configure(folder=self.build / "tests")
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("give CLAYMELD_PROGRAMS_ONLY=ON too", " ".join(done.stderr.split()))


if __name__ == "__main__":
    main("build")
