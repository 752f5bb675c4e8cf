#!/usr/bin/env python3
"""Cubes and hinges in Claymeld beside Rapier, Jolt, Bullet and MuJoCo: the same scenes and steps, one thread, in one run.

Usage: bench_engines.py BIN_DIR [--rapier PROGRAM] [--jolt PROGRAM] [--python PYTHON] [--side N] [--rounds N] [--limit SECONDS]
                        [--scenes NAME,...] [--short]

It fetches nothing; it uses the engines that it is given, and says which it was not:
  Rapier   copy tests/bench/engines/rapier, and there: RUSTFLAGS="-C target-cpu=native" cargo build --release
           which makes target/release/rapier_scene
  Jolt     copy tests/bench/engines/jolt, and there: cargo vendor
           cmake -S . -B build -DCMAKE_BUILD_TYPE=Distribution -DJOLT=$PWD/vendor/joltc-sys/JoltC/JoltPhysics
           cmake --build build, which makes build/jolt_scene
  Bullet, MuJoCo   a Python that has the packages pybullet, mujoco and numpy: --python

Scenes: `heap`, N^3 cubes that fall into four walls in disorder (N = 22); `towers`, as many cubes in towers of ten; `hinges`, as many pairs,
each held by a hinge, that turn freely. Nothing sleeps. All engines work as they do by default; their first column says with how many
iterations. Times are milliseconds of CPU a step. Depths are how far surfaces are in each other at the end, the greatest and the mean; the
creep is how fast bodies have moved on in the mean square since the listed step before; a hinge's parts are apart by a length and an angle;
the energy is the change of what there was at first. With rounds, the engines take turns, and the least times count.
"""
import argparse
import json
import math
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile

STEP_S = 1 / 240
HERE = pathlib.Path(__file__).resolve().parent


def line(*words):
    return " ".join(str(word) for word in words) + "\n"


def head(gravity):
    return line("step", STEP_S) + line("gravity", gravity) + line("friction", 0.5)


def body(place, turn=(1, 0, 0, 0), velocity=(0, 0, 0), spin=(0, 0, 0)):
    return line("body", *place, *turn, *velocity, *spin)


def heap(side):
    numbers = random.Random(1)
    text = head(9.81) + line("plane", 0, 0, 1, 0)
    for normal in ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0)):
        text += line("plane", *normal, -0.75 * side)
    for i in range(side ** 3):
        x, y, z = i % side, i // side % side, i // side ** 2
        turn = [1] + [0.1 * numbers.gauss(0, 1) for _ in range(3)]
        size = math.hypot(*turn)
        place = [1.4 * (at - (side - 1) / 2) + 0.1 * numbers.gauss(0, 1) for at in (x, y)] + [1 + 1.3 * z]
        text += body(place, [q / size for q in turn])
    return text


def towers(side):
    """Of ten cubes, apart from each other."""
    count = round(side ** 3 / 10)
    across = math.ceil(math.sqrt(count))
    text = head(9.81) + line("plane", 0, 0, 1, 0)
    for i in range(count):
        for z in range(10):
            text += body((1.7 * (i % across - across / 2), 1.7 * (i // across - across / 2), 0.5 + z))
    return text


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def hinges(side):
    """Two cubes each, hinged where their faces touch, that turn together and against each other; their centre stays where it is."""
    numbers = random.Random(2)
    count = side ** 3
    across = math.ceil(count ** (1 / 3))
    text, held = head(0), ""
    for i in range(count):
        centre = [4 * (at - across / 2) for at in (i % across, i // across % across, i // across ** 2)]
        together, against = [numbers.gauss(0, 1) for _ in range(3)], numbers.uniform(-2, 2)
        velocities = []
        for sign in (-1, 1):
            spin = [together[0] + sign * against / 2, together[1], together[2]]
            velocities.append((spin, cross(spin, [0, sign * 0.5, 0])))
        mean = [(velocities[0][1][k] + velocities[1][1][k]) / 2 for k in range(3)]
        for sign, (spin, velocity) in zip((-1, 1), velocities):
            place = [centre[0], centre[1] + sign * 0.5, centre[2]]
            text += body(place, velocity=[velocity[k] - mean[k] for k in range(3)], spin=spin)
        held += line("hinge", 2 * i, 2 * i + 1, *centre, 1, 0, 0)
    return text + held


# By name: the scene, and for which steps there are rows.
SCENES = {"heap": (heap, (480, 720, 960)), "towers": (towers, (120, 240, 480)), "hinges": (hinges, (120, 240, 480))}


def has_package(python, package):
    return subprocess.run([python, "-c", f"import {package}, numpy"], capture_output=True).returncode == 0


def engines(options, bench):
    """By name: the command, or why there is none."""
    found = {"Claymeld": ([bench, "run"], ""), "Claymeld, 1 substep": ([bench, "run", "--substeps", "1"], "")}
    for name, program in (("Rapier", options.rapier), ("Jolt", options.jolt)):
        there = program is not None and program.exists()
        found[name] = ([program.resolve()] if there else None, f"there is no {program}" if program else "it was not given")
    if found["Rapier"][0]:
        found["Rapier, 2 iterations"] = (found["Rapier"][0] + ["--iterations", "2"], "")
    for name, package in (("Bullet", "pybullet"), ("MuJoCo", "mujoco")):
        has = options.python and shutil.which(options.python) is not None and has_package(options.python, package)
        why = f"{options.python} has no package {package}" if options.python else "no Python was given"
        found[name] = ([options.python, "-B", HERE / "engines" / f"{name.lower()}_scene.py"] if has else None, why)
    return found


def measure(bench, command, scene, ticks, limit, folder):
    out = folder / "out.txt"
    out.unlink(missing_ok=True)
    try:
        done = subprocess.run([*command, scene, out, *map(str, ticks)], capture_output=True, text=True, timeout=limit)
        if done.returncode != 0:
            sys.exit(f"bench_engines.py: {command[0]} ended with {done.returncode}: {(done.stdout + done.stderr).strip()}")
    except subprocess.TimeoutExpired:
        pass
    if not out.exists():
        return []
    said = subprocess.run([bench, "measure", scene, out], capture_output=True, text=True).stdout
    for written, read in ((": nan", ": NaN"), (": -nan", ": NaN"), (": inf", ": Infinity")):
        said = said.replace(written, read)
    return [json.loads(row) for row in said.splitlines()]


def say(scene, number, rows):
    times = "".join(f"{row['ms']:>9.2f}" for row in rows)
    last = rows[-1]
    text = f"{scene:7} {last['name'][:44]:44} {number:>7}{times:27}"
    if scene == "hinges":
        text += f"  {last['parted']:.1e} m, {last['tilted']:.1e} rad; energy {last['energy']:+.1e}"
    else:
        text += (f"  {1e3 * last['deepest']:.2f} mm, mean {1e3 * last['depth']:.2f} mm at {last['touching']};"
                 f" creep {1e3 * last['creep']:.2f} mm/s, {1e3 * last['farthest']:.1f} mm at most")
    print(text, flush=True)


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("bin", type=pathlib.Path)
    parser.add_argument("--rapier", type=pathlib.Path)
    parser.add_argument("--jolt", type=pathlib.Path)
    parser.add_argument("--python")
    parser.add_argument("--side", type=int, default=22)
    parser.add_argument("--rounds", type=int, default=1)
    parser.add_argument("--limit", type=float, default=600)
    parser.add_argument("--scenes", default=",".join(SCENES))
    parser.add_argument("--short", action="store_true")
    options = parser.parse_args()
    bench = (options.bin / "bench_engines").resolve()
    found = engines(options, bench)
    for name, (command, why) in found.items():
        if command is None:
            print(f"without {name}: {why}; `bench_engines.py --help` says how to get it")
    side = 4 if options.short else options.side
    print(f"{'scene':7} {'engine':44} {'bodies':>7}{'ms a step, by part of the run':29}  depth or parting, and drift, at the end")
    for name in options.scenes.split(","):
        make, ticks = SCENES[name]
        if options.short:
            ticks = tuple(tick // 2 for tick in ticks)
        with tempfile.TemporaryDirectory() as temporary:
            folder = pathlib.Path(temporary)
            text = make(side)
            (folder / "scene.txt").write_text(text)
            best = {}
            for _ in range(options.rounds):
                for engine, (command, _) in found.items():
                    if command is None:
                        continue
                    rows = measure(bench, command, folder / "scene.txt", ticks, options.limit, folder)
                    for row, before in zip(rows, best.get(engine, rows)):
                        row["ms"] = min(row["ms"], before["ms"])
                    best[engine] = rows
                    if rows:
                        say(name, text.count("\nbody"), rows)
                    else:
                        print(f"{name:7} {engine:44} more than {options.limit:.0f} s for {ticks[0]} steps", flush=True)
            whole = {engine: rows[-1]["ms"] for engine, rows in best.items() if len(rows) == len(ticks)}
            others = {engine: ms for engine, ms in whole.items() if not engine.startswith("Claymeld")}
            if others:
                fastest = min(others, key=others.get)
                ratio = whole["Claymeld"] / max(others[fastest], 1e-6)
                print(f"{name:7} the fastest other is {fastest}; Claymeld takes {ratio:.2f} times as long", flush=True)
            check(name, best["Claymeld"])


def check(name, rows):
    """Ours must be what a scene is: at rest, or held together."""
    last = rows[-1]
    fine = last["parted"] < 1e-3 and abs(last["energy"]) < 1e-2 if name == "hinges" else last["deepest"] < 0.05
    if not fine:
        sys.exit(f"bench_engines.py: {name} has come apart: {last}")


if __name__ == "__main__":
    main()
