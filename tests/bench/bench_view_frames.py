#!/usr/bin/env python3
"""What frames take the server of `meldsim view`: cubes of catoms on the cubic lattice, in the state that a tick has left.

Usage: bench_view_frames.py BIN_DIR EXAMPLES_DIR [--frames N] [CATOMS ...]

Prints CPU seconds of the server, user and system: of the first frame of a gradient that is coloured by its distance; of one after which
nothing has happened; medians of frames with a tick between two, of the gradient and of a program in which one catom in a hundred changes;
of a frame of another look; and of a frame as it is made from the whole run, which is also compared with the one that is kept. Then the
memory that the server holds.
"""
import argparse
import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "view"))

from websocket import Page  # noqa: E402

# One walker in a hundred catoms goes a cell further in each tick, and counts at each catom.
WALKERS = """type linear walker(node).
type linear visits(node, int).
visits(A, 0).
walker(A), visits(A, N), neighbor(A, B, 0) -o walker(B), visits(A, N + 1).
"""
GRADIENT = {"colour": "dist(A, D)"}
COUNTED = {"colour": "visits(A, N)"}
TICK_s = 1 / os.sysconf("SC_CLK_TCK")


def world_of(catoms, facts):
    side = round(catoms ** (1 / 3))
    return f'lattice = "cubic"\n[[body]]\nshape = "box({side}, {side}, {side})"\n[facts]\n{facts}\n', side ** 3


class Server:
    def __init__(self, folder, meldsim, program, world):
        path = pathlib.Path(folder) / "world.toml"
        path.write_text(world)
        self.process = subprocess.Popen([meldsim, "view", program, "--world", path, "--json", "--no-open", "--history", "1B"],
                                        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self.page = Page(json.loads(self.process.stdout.readline())["link"], seconds=600)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.page.close()
        self.process.terminate()
        self.process.wait()

    def cpu_s(self):
        fields = pathlib.Path(f"/proc/{self.process.pid}/stat").read_text().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) * TICK_s

    def held_bytes(self):
        return int(pathlib.Path(f"/proc/{self.process.pid}/status").read_text().split("VmRSS:")[1].split()[0]) * 1024

    def ask(self, what, **fields):
        said, block = self.page.ask(what, **fields)
        if not said["ok"]:
            sys.exit(f"{what}: {said['error']['message']}")
        del said["id"]
        return said, block

    def frame(self, look):
        """As the page asks for it; with the seconds that it took."""
        before = self.cpu_s()
        said = self.ask("frame", look=look, values=True)
        return self.cpu_s() - before, said

    def step(self):
        self.ask("command", line="step")

    def frames_after_ticks(self, look, frames):
        taken = []
        for _ in range(frames):
            self.step()
            taken.append(self.frame(look)[0])
        return statistics.median(taken)


def measure(server, look, frames):
    """Prints figures of one program; the look is one whose values are those of each catom alone."""
    first, _ = server.frame(look)
    again, _ = server.frame(look)
    after_ticks = server.frames_after_ticks(look, frames)
    _, kept = server.frame(look)
    # Whoever reads ticks is asked for all catoms each time.
    whole, fresh = server.frame({"colour": look["colour"] + ", tick(A, _)"})
    if kept != fresh:
        sys.exit("a frame that was kept is not the one that is made from the whole run")
    other, _ = server.frame({**look, "map": "magma"})
    print(f"  first {first:.2f} s, again {again:.2f} s, after a tick {after_ticks:.2f} s, another look {other:.2f} s, "
          f"from the whole run {whole:.2f} s; {kept[0]['sent']:,} sent, {server.held_bytes() / 2**20:,.0f} MiB held", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("bin")
    parser.add_argument("examples")
    parser.add_argument("catoms", nargs="*", type=float, default=[1e6, 1e7])
    parser.add_argument("--frames", type=int, default=9)
    options = parser.parse_intermixed_args()
    meldsim = f"{options.bin}/meldsim"
    with tempfile.TemporaryDirectory() as folder:
        walkers = pathlib.Path(folder) / "walkers.meld"
        walkers.write_text(WALKERS)
        for asked in options.catoms:
            for name, program, facts, look in (("gradient", f"{options.examples}/gradient.meld", 'source = "id == 0"', GRADIENT),
                                               ("one in a hundred", walkers, 'walker = "id % 100 == 0"', COUNTED)):
                world, catoms = world_of(asked, facts)
                print(f"{catoms:,} catoms, {name}:", flush=True)
                with Server(folder, meldsim, program, world) as server:
                    # The wave has left its corner, and walkers have begun.
                    server.ask("command", line="step 20")
                    measure(server, look, options.frames)


if __name__ == "__main__":
    main()
