"""Makes a wheel of the Python package that holds meldc, meldsim, their libraries, the library in Meld and the examples.

    make.py --build FOLDER --out FOLDER

It is OUT/claymeld-VERSION-py3-none-linux_x86_64.whl, or with another platform, that of the machine. What the programs need of the
system is not in it: PACKAGES in the package lists these libraries, each with the Debian package that has it.
"""
import argparse
import importlib.util
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
# Of an installation, what belongs into the package. The programs find their files from where they lie.
TAKEN = ("bin", "lib/claymeld", "share/claymeld/library", "share/claymeld/examples")
# A wheel for any Python 3 of this platform.
SETUP = '''
import sysconfig

import setuptools

try:
    from setuptools.command.bdist_wheel import bdist_wheel
except ImportError:
    from wheel.bdist_wheel import bdist_wheel


class Programs(setuptools.Distribution):
    def has_ext_modules(self):
        return True


class OfThisPlatform(bdist_wheel):
    def get_tag(self):
        return "py3", "none", sysconfig.get_platform().replace("-", "_").replace(".", "_")


setuptools.setup(distclass=Programs, cmdclass={"bdist_wheel": OfThisPlatform})
'''


def run(*command, **options):
    """The standard output of a command that must end well."""
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False, **options)
    if done.returncode != 0:
        raise SystemExit(f"packaging/wheel/make.py: {' '.join(map(str, command))} failed:\n{done.stdout}{done.stderr}")
    return done.stdout


def missing_modules():
    """What this Python lacks to make a wheel: setuptools, or the wheel that setuptools has in itself from 70.1 on."""
    if importlib.util.find_spec("setuptools") is None:
        return ["setuptools", "wheel"]
    has_wheel = importlib.util.find_spec("setuptools.command.bdist_wheel") or importlib.util.find_spec("wheel")
    return [] if has_wheel else ["wheel"]


def libraries_of(programs):
    """The shared libraries that these programs and libraries ask for, but the loader, each with its Debian package where dpkg knows it."""
    found = {}
    for path in programs:
        asked = set(re.findall(r"\(NEEDED\).*\[(lib.+)\]", run("readelf", "-d", path)))
        places = dict(re.findall(r"^\s*(\S+) => (/\S+)", run("ldd", path), re.MULTILINE))
        found.update({name: places.get(name, "") for name in asked})
    return {name: package_of(place) for name, place in sorted(found.items())}


def package_of(place):
    if place == "" or shutil.which("dpkg") is None:
        return ""
    # dpkg knows files by the place that they had before /lib became a link to /usr/lib, or after.
    for path in (place, place.removeprefix("/usr"), f"/usr{place}"):
        done = subprocess.run(["dpkg", "-S", path], capture_output=True, text=True, check=False)
        if done.returncode == 0:
            return done.stdout.split(":")[0]
    return ""


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("--build", type=pathlib.Path, required=True)
    arguments.add_argument("--out", type=pathlib.Path, required=True)
    options = arguments.parse_args()
    if not (options.build / "cmake_install.cmake").exists():
        print(f"packaging/wheel/make.py: {options.build} is not a build. Build Claymeld with scripts/build", file=sys.stderr)
        return 2
    missing = missing_modules()
    if missing:
        packages = " ".join(f"python3-{name}" for name in missing)
        print(f"packaging/wheel/make.py: {sys.executable} has no {' and no '.join(missing)}. Install {packages}, or say "
              f"{sys.executable} -m pip install {' '.join(missing)}", file=sys.stderr)
        return 2
    options.out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        prefix, package = pathlib.Path(folder, "prefix"), pathlib.Path(folder, "python")
        run("cmake", "--install", options.build, "--prefix", prefix, "--strip")
        shutil.copytree(ROOT / "python", package, ignore=shutil.ignore_patterns("__pycache__", "*.egg-info", "build"))
        programs = package / "claymeld" / "programs"
        for path in TAKEN:
            shutil.copytree(prefix / path, programs / path)
        commands = sorted(path.name for path in (programs / "bin").iterdir())
        needed = libraries_of([*(programs / "bin").iterdir(), *(programs / "lib/claymeld").iterdir()])
        (programs / "PACKAGES").write_text("".join(f"{name} {where}\n" for name, where in needed.items()))
        # Commands of these names, for shells, and the files of the programs.
        lines = "".join(f'"{name}" = "claymeld.tool.programs:start"\n' for name in commands)
        with (package / "pyproject.toml").open("a") as project:
            project.write(f"\n[project.scripts]\n{lines}")
        (package / "setup.py").write_text(SETUP)
        shutil.copy(ROOT / "LICENSE", package)
        build = "import setuptools.build_meta as build; print(build.build_wheel('..'))"
        name = run(sys.executable, "-c", build, cwd=package).splitlines()[-1]
        shutil.move(pathlib.Path(folder, name), options.out / name)
    print(options.out / name)
    return 0


if __name__ == "__main__":
    sys.exit(main())
