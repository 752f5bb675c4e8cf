#!/usr/bin/env python3
"""From an edited program to its first tick, cold (nothing compiled) and warm (from the cache), in worlds of several sizes.

Usage: bench_latency.py BIN_DIR EXAMPLES_DIR [CATOMS ...]      prints medians of wall milliseconds
       bench_latency.py BIN_DIR --large KIND [PREDICATES ...]  compiles programs of large_program.py: cold, after a change of one rule,
                                                               and from the cache
"""
import json
import os
import re
import resource
import statistics
import subprocess
import sys
import tempfile
import time

import large_program


def run(command, cache):
    begin = time.perf_counter()
    done = subprocess.run(command, env=dict(os.environ, CLAYMELD_CACHE=cache), stdout=subprocess.PIPE,
                          stderr=subprocess.DEVNULL, check=True)
    return (time.perf_counter() - begin) * 1000, done.stdout


def large(bin_dir, kind, sizes):
    for predicates in sizes:
        text = large_program.KINDS[kind](predicates)
        # A number in a rule in the middle becomes another one.
        middle = text.index(":-", len(text) // 2) if ":-" in text else text.index("-o", len(text) // 2)
        changed = text[:middle] + re.sub(r"([<>]=?) (\d+)", r"\1 1\2", text[middle:], count=1)
        with tempfile.TemporaryDirectory() as folder:
            said = []
            for what, program in (("cold", text), ("one rule changed", changed), ("from the cache", changed)):
                open(f"{folder}/p.meld", "w").write(program)
                before = resource.getrusage(resource.RUSAGE_CHILDREN)
                wall, _ = run([f"{bin_dir}/meldc", "compile", f"{folder}/p.meld"], f"{folder}/cache")
                after = resource.getrusage(resource.RUSAGE_CHILDREN)
                said.append(f"{what} {wall:.0f} ms ({(after.ru_utime - before.ru_utime) * 1000:.0f} ms of CPU)")
            print(f"{kind}, {predicates} predicates: {', '.join(said)}", flush=True)


def main():
    if sys.argv[2:3] == ["--large"]:
        return large(sys.argv[1], sys.argv[3], [int(n) for n in sys.argv[4:]] or [100, 200, 400])
    bin_dir, examples = sys.argv[1:3]
    sizes = [int(float(n)) for n in sys.argv[3:]] or [1000, 1000**2, 10**7]
    with tempfile.TemporaryDirectory() as folder:
        for program in ("gradient", "shape_change"):
            text = open(f"{examples}/{program}.meld").read()
            cold, warm = [], []
            for i in range(7):
                edited = f"{folder}/{program}.meld"
                open(edited, "w").write(text + f"\n// edit {i}\ntype edit{i}(node).\nedit{i}(A) :- id(A, {i}).\n")
                for times in (cold, warm):
                    times.append(run([f"{bin_dir}/meldc", "compile", edited], f"{folder}/cache")[0])
            print(f"meldc compile {program}: cold {statistics.median(cold):.0f} ms, warm {statistics.median(warm):.1f} ms")
        program = f"{examples}/gradient.meld"
        for catoms in sizes:
            side = round(catoms ** (1 / 3))
            world = f"{folder}/world.toml"
            open(world, "w").write(f'lattice = "cubic"\n[[body]]\nshape = "box({side}, {side}, {side})"\n[facts]\nsource = ["id == 0"]\n')
            walls, setups = [], []
            for i in range(5 if catoms <= 10**6 else 3):
                wall, out = run([f"{bin_dir}/meldsim", "run", program, "--world", world, "--ticks", "1", "--json"], f"{folder}/cache")
                if i > 0:
                    walls.append(wall)
                    setups.append(json.loads(out)["setup_seconds"] * 1000)
            print(f"{side**3} catoms: command to first tick and end {statistics.median(walls):.0f} ms warm, "
                  f"world ready in {statistics.median(setups):.0f} ms")


if __name__ == "__main__":
    main()
