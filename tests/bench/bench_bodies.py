#!/usr/bin/env python3
"""The whole system on piles of bodies: meldsim with a program that senses and acts, by size, engine, processes and threads.

Usage: bench_bodies.py BIN_DIR [--short] [SIDE ...]      a pile has SIDE^3 catoms; 10 22 37 47 63 100 by default

With --short only as many ticks are measured as show that everything runs.

A tick's time is the difference between a long and a short run, divided by the ticks between them: CPU of all processes, and wall.
Engines are left out where they cannot run or a tick would take longer than a minute.
"""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

PROGRAM = pathlib.Path(__file__).parent / "bodies" / "crowd.meld"
WORLD = """[[body]]
shape = "move(box({side}, {side}, {side}), 0, 0, {half})"

[motion]
kind = "bodies"
engine = "{engine}"
solver = "{solver}"
substeps = {substeps}
spacing = {spacing}
ground = -0.5
sleep_ticks = 0

[[motion.feature]]
directions = 12
strength = 10
range = 0.1

[facts]
source = ["id == 0"]
"""
COLD = {"solver": "pgs20", "substeps": 1, "spacing": 0.999}
SOFT = {"solver": "soft", "substeps": 2, "spacing": 1}
# Name, what the world says, processes, threads, the largest side, the fewest ticks to measure.
CASES = [
    ("stock ODE, 20 sweeps", {"engine": "ode", **COLD}, 1, 1, 47, 2),
    ("seed design, 20 sweeps", {"engine": "hash", **COLD}, 1, 1, 63, 2),
    ("blocks, 20 cold sweeps", {"engine": "blocks", **COLD}, 1, 1, 159, 4),
    ("blocks, 20 cold sweeps", {"engine": "blocks", **COLD}, 1, 2, 100, 4),
    ("blocks, 20 cold sweeps", {"engine": "blocks", **COLD}, 2, 1, 100, 4),
    ("blocks, soft", {"engine": "blocks", **SOFT}, 1, 1, 272, 2),
    ("blocks, soft", {"engine": "blocks", **SOFT}, 1, 2, 100, 4),
    ("blocks, soft", {"engine": "blocks", **SOFT}, 2, 1, 100, 4),
]
# As many bodies are moved in a measurement at least, so that small piles take longer than a run's start varies.
LEAST_MOVES = 1_000_000
BEFORE = 2


class Run:
    """One run: cpu_s of all processes, wall_s, the largest process in bytes, the summary."""

    def __init__(self, command, environment, log):
        begin = time.perf_counter()
        with open(log, "w+") as out:
            process = subprocess.Popen(command, env=environment, stdout=out)
            _, status, used = os.wait4(process.pid, 0)
            self.wall_s = time.perf_counter() - begin
            out.seek(0)
            text = out.read()
        if status != 0:
            sys.exit(f"{' '.join(map(str, command))} ended with {os.waitstatus_to_exitcode(status)}")
        self.cpu_s = used.ru_utime + used.ru_stime
        self.peak_bytes = 1024 * used.ru_maxrss
        self.summary = json.loads(text)


def measure(meldsim, folder, side, case, least_moves):
    name, says, processes, threads, _, fewest = case
    world = folder / "world.toml"
    world.write_text(WORLD.format(side=side, half=side / 2, **says))
    environment = dict(os.environ, CLAYMELD_CACHE=str(folder / "cache"))

    def run(ticks):
        command = [meldsim, "run", PROGRAM, "--world", world, "--ticks", str(ticks), "--quiet", "--json", "-n", str(processes),
                   "--threads", str(threads)]
        return Run(command, environment, folder / "log")

    # Stock ODE and the seed design take so long that fewer will do.
    ticks = max(fewest, (least_moves if says["engine"] == "blocks" else least_moves // 20) // side**3)
    short, long = run(BEFORE), run(BEFORE + ticks)
    catoms = long.summary["catoms"]
    print(f"  {name:<24} {processes} x {threads} | {1e3 * (long.cpu_s - short.cpu_s) / ticks:9.2f} cpu"
          f" {1e3 * (long.wall_s - short.wall_s) / ticks:9.2f} wall a tick"
          f" | begin and {BEFORE} ticks {short.cpu_s:7.2f} s cpu | {long.summary['bytes_per_catom']:5.0f} B a catom held,"
          f" {long.peak_bytes / (catoms / processes):5.0f} at the peak", flush=True)


def main():
    meldsim = f"{sys.argv[1]}/meldsim"
    short = "--short" in sys.argv
    sides = [int(side) for side in sys.argv[2:] if side != "--short"] or [10, 22, 37, 47, 63, 100]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        # The program is compiled once, before anything is measured.
        subprocess.run([f"{sys.argv[1]}/meldc", "compile", PROGRAM], env=dict(os.environ, CLAYMELD_CACHE=str(folder / "cache")),
                       stdout=subprocess.DEVNULL, check=True)
        for side in sides:
            print(f"\n{side**3} catoms, ms")
            for case in CASES:
                if side <= case[4]:
                    measure(meldsim, folder, side, case, 0 if short else LEAST_MOVES)


if __name__ == "__main__":
    main()
