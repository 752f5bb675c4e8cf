#!/usr/bin/env python3
"""The gradient in networks that take time beside the ideal one; and what a message costs by itself: a fact of each catom of a cube that
changes in every tick, known to all neighbours a number of ticks later. The ideal run has the same evaluations, so they are not in it.
In the first program readers share what they know of a neighbour; the second has linear facts, so each of its links has a mailbox.

Usage: bench_networks.py BIN_DIR EXAMPLES_DIR [--side N] [--runs N] [--ticks N]   prints medians of CPU seconds, and bytes
"""
import argparse
import json
import statistics
import subprocess
import tempfile

NETWORKS = {
    "ideal": "",
    "latency, 1 tick": '[network]\nkind = "latency"',
    "latency, 1 to 4 ticks": '[network]\nkind = "latency"\nleast = 1\nmost = 4',
    "lossy, 0.1": '[network]\nkind = "lossy"\nloss = 0.1',
    "random clock, 0.5": '[clock]\nkind = "random"\nrate = 0.5\nmost = 8',
}
BEAT = """type beat(node, int T).
type heard(node, max int T).
beat(A, T) :- tick(A, T).
heard(B, T) :- neighbor(A, B), beat(A, T).
"""
# A rule that never fires.
POST = BEAT + """type linear post(node).
post(A), neighbor(A, B) -o post(B).
"""


class Runs:
    def __init__(self, bin_dir, folder, side):
        self.bin_dir, self.folder, self.side = bin_dir, folder, side

    def one(self, program, rest, *options):
        world = f"{self.folder}/world.toml"
        with open(world, "w") as out:
            out.write(f'lattice = "cubic"\n[[body]]\nshape = "box({self.side}, {self.side}, {self.side})"\n{rest}\n')
        command = [f"{self.bin_dir}/meldsim", "run", program, "--world", world, "--json", *options]
        return json.loads(subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=True).stdout)

    def medians(self, program, worlds, runs, *options):
        """By name, the median of CPU seconds and the last summary; the worlds in turn, so that all see the same machine."""
        seconds, last = {name: [] for name in worlds}, {}
        for _ in range(runs):
            for name, rest in worlds.items():
                last[name] = self.one(program, rest, *options)
                seconds[name].append(last[name]["cpu_seconds"])
        return {name: (statistics.median(seconds[name]), last[name]) for name in worlds}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin_dir")
    parser.add_argument("examples")
    parser.add_argument("--side", type=int, default=100)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--ticks", type=int, default=60, help="of the messages by themselves")
    a = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        runs = Runs(a.bin_dir, folder, a.side)
        worlds = {name: f'[facts]\nsource = "id == 0"\n{rest}' for name, rest in NETWORKS.items()}
        found = runs.medians(f"{a.examples}/gradient.meld", worlds, a.runs)
        ideal = found["ideal"][0]
        print(f"gradient, {a.side ** 3} catoms")
        for name, (cpu, last) in found.items():
            print(f"  {name:22} {cpu:7.3f} s  {cpu / ideal:5.1f} x  {last['bytes_per_catom']:6.1f} bytes a catom")

        runs.side = max(2, a.side // 2)
        links = 6 * runs.side ** 2 * (runs.side - 1)
        few, many = 4, 12
        latency = {ticks: f'[network]\nkind = "latency"\nleast = {ticks}\nmost = {ticks}' for ticks in (few, many)}
        print(f"a message, {runs.side ** 3} catoms, {links} links, {few} ticks")
        for name, text in (("shared by readers", BEAT), ("in mailboxes", POST)):
            program = f"{folder}/beat.meld"
            with open(program, "w") as out:
                out.write(text)
            found = runs.medians(program, {0: "", **latency}, a.runs, "--ticks", str(a.ticks))
            sent = links * (a.ticks - 1)
            under_way = links * (many - few)
            nanoseconds = (found[few][0] - found[0][0]) / sent * 1e9
            size = (found[many][1]["peak_bytes"] - found[few][1]["peak_bytes"]) / under_way
            print(f"  {name:22} {nanoseconds:7.0f} ns  {size:6.1f} bytes under way ({few} to {many} ticks)")


main()
