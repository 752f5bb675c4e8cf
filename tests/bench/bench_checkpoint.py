#!/usr/bin/env python3
"""What a checkpoint costs: the same run without and with one at its end, the bytes on the disk, and how soon a run goes on from it.

Usage: bench_checkpoint.py BIN_DIR EXAMPLES_DIR [--bodies | --changes] [CATOMS ...]      prints medians of wall milliseconds

Each is measured on the disk and in memory, beside the time that the disk takes for as many bytes. With --bodies, catoms are a pile of
bodies that sense and act. A checkpoint of bodies has their lists of contacts, which a world makes only in its first tick; so it is also
measured how soon the first tick is done: after a resume, and after the set-up.

With --changes, a token walks through a cube, and there is a checkpoint in every tenth tick: CPU milliseconds and bytes of each, of whole
ones and of those that hold what has changed.
"""
import json
import os
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

import bench_bodies

RUNS, RUNS_OF_SMALL = 5, 1
SMALL = 100_000
CUBE = """lattice = "cubic"
[[body]]
shape = "box({side}, {side}, {side})"
[facts]
source = ["id == 0"]
"""
# The first ticks of a pile make most of its contacts.
TICKS_OF_BODIES = ("--ticks", "4")


def seconds_of_disk(folder, size):
    """How long the disk takes for as many bytes."""
    path = f"{folder}/disk"
    data = os.urandom(1 << 20) * (size // (1 << 20) + 1)
    begin = time.perf_counter()
    with open(path, "wb", buffering=0) as file:
        file.write(data[:size])
        os.fsync(file.fileno())
    taken = time.perf_counter() - begin
    os.unlink(path)
    return taken


TOKEN = """type linear token(node).
token(@0).
token(A), neighbor(A, B), B > A -o token(B).
"""
# The first checkpoint is whole, and they are so few that no other one is.
CHANGES_TICKS, CHANGES_EVERY = 210, 10


def compare_changes(bin_dir, catoms):
    side = round(catoms ** (1 / 3))
    with tempfile.TemporaryDirectory() as folder:
        for name, text in (("p.meld", TOKEN), ("w.toml", CUBE.partition("[facts]")[0].format(side=side))):
            with open(f"{folder}/{name}", "w") as out:
                out.write(text)
        kept = f"{folder}/kept"

        def cpu(ticks, *options):
            shutil.rmtree(kept, ignore_errors=True)
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            subprocess.run([f"{bin_dir}/meldsim", "run", "p.meld", "--world", "w.toml", "--ticks", str(ticks), "--quiet", *options],
                           check=True, cwd=folder)
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

        ways = {"none": (), "whole": ("--checkpoint", kept, "--checkpoint-every", f"{CHANGES_EVERY}ticks")}
        ways["changes"] = (*ways["whole"], "--checkpoint-changes")
        taken, sizes = {way: [] for way in ways}, {}
        cpu(1)
        for _ in range(RUNS):
            for way, options in ways.items():
                # Without the first one.
                taken[way].append(cpu(CHANGES_TICKS, *options) - cpu(CHANGES_EVERY, *options))
        for way in ("whole", "changes"):
            cpu(2 * CHANGES_EVERY, *ways[way])
            sizes[way] = os.path.getsize(f"{kept}/{2 * CHANGES_EVERY}.0-of-1.share")
        print(f"{side**3} catoms, a token for {CHANGES_EVERY} ticks, CPU of a checkpoint")
        for way, size in sizes.items():
            each = statistics.median(a - b for a, b in zip(taken[way], taken["none"])) / (CHANGES_TICKS / CHANGES_EVERY - 1)
            print(f"  {way:8} {each * 1000:7.2f} ms {size:9} bytes")


def whole_seconds(summary):
    return summary["setup_seconds"] + summary["run_seconds"]


def main():
    bin_dir, examples, *rest = sys.argv[1:]
    bin_dir = os.path.abspath(bin_dir)
    bodies, changes = "--bodies" in rest, "--changes" in rest
    sizes = [int(float(n)) for n in rest if not n.startswith("--")] or ([63**3] if bodies else [1000**2, 4 * 1000**2])
    if changes:
        for catoms in sizes:
            compare_changes(bin_dir, catoms)
        return
    program = bench_bodies.PROGRAM.resolve() if bodies else os.path.abspath(f"{examples}/gradient.meld")
    with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryDirectory(dir="/dev/shm") as memory:
        environment = dict(os.environ, CLAYMELD_CACHE=f"{folder}/cache")

        def run(*arguments):
            done = subprocess.run([f"{bin_dir}/meldsim", *arguments, "--json"], env=environment, stdout=subprocess.PIPE, check=True,
                                  cwd=folder)
            return json.loads(done.stdout)

        for catoms in sizes:
            side = round(catoms ** (1 / 3))
            world = f"{folder}/world.toml"
            says = {"engine": "blocks", "half": side / 2, **bench_bodies.SOFT} if bodies else {}
            open(world, "w").write((bench_bodies.WORLD if bodies else CUBE).format(side=side, **says))
            command = ("run", program, "--world", world, "--quiet", *(TICKS_OF_BODIES if bodies else ()))
            plain, setup, disk, kept, again = [], [], [], {folder: [], memory: []}, {folder: [], memory: []}
            size = state = 0
            ticking, ticked = [], []
            run("run", program, "--world", world, "--ticks", "1")
            for i in range(RUNS if catoms >= SMALL else RUNS_OF_SMALL):
                without = run(*command)
                plain.append(without["run_seconds"])
                setup.append(without["setup_seconds"])
                state = without["bytes_per_catom"]
                for place in (folder, memory):
                    kept_in = f"{place}/kept{side}-{i}"
                    whole = run(*command, "--checkpoint", kept_in, "--checkpoint-every", "1000000ticks")
                    kept[place].append(whole["run_seconds"])
                    again[place].append(run("resume", kept_in, "--quiet")["setup_seconds"])
                    size = sum(os.path.getsize(f"{kept_in}/{name}") for name in os.listdir(kept_in))
                    if place == memory:
                        # It ends with another checkpoint, which is as large as the one before.
                        later = run("resume", kept_in, "--quiet", "--ticks", str(whole["ticks"] + 1))
                        ticking.append(whole_seconds(later) - (whole["run_seconds"] - without["run_seconds"]))
                    subprocess.run(["rm", "-r", kept_in], check=True)
                ticked.append(whole_seconds(run(*command[:5], "--ticks", "1")))
                disk.append(seconds_of_disk(folder, size))
            cost = {place: statistics.median(kept[place]) - statistics.median(plain) for place in kept}
            resumed = {place: statistics.median(again[place]) for place in again}
            # Of runs one after the other, on whatever else the machine did.
            ratio = statistics.median(went_on / made for went_on, made in zip(again[memory], setup))
            sooner = statistics.median(resumed / begun for resumed, begun in zip(ticking, ticked))
            print(f"{side**3} catoms: checkpoint {cost[folder] * 1000:.0f} ms, in memory {cost[memory] * 1000:.0f} ms, the disk alone "
                  f"{statistics.median(disk) * 1000:.0f} ms; {size / side**3:.1f} bytes a catom, and {state:.1f} in the run; "
                  f"resumed in {resumed[folder] * 1000:.0f} ms, from memory {resumed[memory] * 1000:.0f} ms, "
                  f"set up in {statistics.median(setup) * 1000:.0f} ms; ratio {ratio:.2f}; "
                  f"one tick later {statistics.median(ticking) * 1000:.0f} ms after the resume and "
                  f"{statistics.median(ticked) * 1000:.0f} ms after the set-up, ratio {sooner:.2f}")


if __name__ == "__main__":
    main()
