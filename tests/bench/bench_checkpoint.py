#!/usr/bin/env python3
"""What a checkpoint costs: the same run without and with one at its end, the bytes on the disk, and how soon a run goes on from it.

Usage: bench_checkpoint.py BIN_DIR EXAMPLES_DIR [CATOMS ...]      prints medians of wall milliseconds
"""
import json
import os
import statistics
import subprocess
import sys
import tempfile

RUNS = 5


def main():
    bin_dir, examples = sys.argv[1:3]
    sizes = [int(float(n)) for n in sys.argv[3:]] or [1000**2, 4 * 1000**2]
    with tempfile.TemporaryDirectory() as folder:
        environment = dict(os.environ, CLAYMELD_CACHE=f"{folder}/cache")

        def run(*arguments):
            done = subprocess.run([f"{bin_dir}/meldsim", *arguments, "--json"], env=environment, stdout=subprocess.PIPE, check=True,
                                  cwd=folder)
            return json.loads(done.stdout)

        program = os.path.abspath(f"{examples}/gradient.meld")
        for catoms in sizes:
            side = round(catoms ** (1 / 3))
            world = f"{folder}/world.toml"
            open(world, "w").write(f'lattice = "cubic"\n[[body]]\nshape = "box({side}, {side}, {side})"\n[facts]\nsource = ["id == 0"]\n')
            plain, kept, setup, again, size = [], [], [], [], 0
            run("run", program, "--world", world, "--ticks", "1")
            for i in range(RUNS):
                kept_in = f"{folder}/kept{side}-{i}"
                without = run("run", program, "--world", world)
                whole = run("run", program, "--world", world, "--checkpoint", kept_in, "--checkpoint-every", "1000000ticks")
                resumed = run("resume", kept_in, "--quiet")
                plain.append(without["run_seconds"])
                kept.append(whole["run_seconds"])
                setup.append(without["setup_seconds"])
                again.append(resumed["setup_seconds"])
                size = sum(os.path.getsize(f"{kept_in}/{name}") for name in os.listdir(kept_in))
                subprocess.run(["rm", "-r", kept_in], check=True)
            cost = statistics.median(b - a for a, b in zip(plain, kept))
            print(f"{side**3} catoms: checkpoint {cost * 1000:.0f} ms, {size / side**3:.1f} bytes a catom; "
                  f"resumed in {statistics.median(again) * 1000:.0f} ms, set up in {statistics.median(setup) * 1000:.0f} ms")


if __name__ == "__main__":
    main()
