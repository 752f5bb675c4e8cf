#!/usr/bin/env python3
"""What it costs to look on at a run: recordings, digests and watches, beside the same run alone.

Usage: bench_observed.py BIN_DIR EXAMPLES_DIR [--side N] [--runs N]

Two runs on a cube of 100³ catoms: a token that walks for 90 ticks, in which two facts change in a tick, and the gradient, in which all
catoms change once. A figure is the CPU time of the whole process, start and set-up too, the least of five; a ratio is that over the run
alone. The run alone and those beside it take turns, so that whatever else the machine does meets all of them.
"""
import argparse
import pathlib
import resource
import subprocess
import tempfile

TOKEN = """type linear token(node).
token(@0).
token(A), neighbor(A, B), B > A -o token(B).
"""
WORLD = """lattice = "cubic"
[[body]]
shape = "box({side}, {side}, {side})"
[record]
every = 1
predicates = ["{predicate}"]
{facts}"""
TICKS = 90
# The name of a row, the run that it is beside, and its options; `out` is a file that each run makes anew.
ROWS = (
    ("token, recorded in every tick", "token", ("--record", "out")),
    ("token, --digest", "token", ("--digest", "out")),
    ("token, --never 'token(A), token(B), A <> B'", "token", ("--never", "token(A), token(B), A <> B")),
    ("gradient, recorded in every tick", "gradient", ("--record", "out")),
    ("gradient, --digest", "gradient", ("--digest", "out")),
)


def cpu_seconds(command, folder):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, check=True, cwd=folder, stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin_dir", type=pathlib.Path)
    parser.add_argument("examples", type=pathlib.Path)
    parser.add_argument("--side", type=int, default=100)
    parser.add_argument("--runs", type=int, default=5)
    given = parser.parse_args()
    bin_dir, examples = given.bin_dir.resolve(), given.examples.resolve()
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        (folder / "token.meld").write_text(TOKEN)
        commands = {}
        for name, source, predicate, facts, ticks in (
            ("token", folder / "token.meld", "token", "", ["--ticks", str(TICKS)]),
            ("gradient", examples / "gradient.meld", "dist", '[facts]\nsource = ["id == 0"]\n', []),
        ):
            (folder / f"{name}.toml").write_text(WORLD.format(side=given.side, predicate=predicate, facts=facts))
            module = folder / f"{name}.so"
            subprocess.run([bin_dir / "meldc", "compile", source, "-o", module, "--quiet"], check=True, stderr=subprocess.DEVNULL)
            commands[name] = [bin_dir / "meldsim", "run", module, "--world", folder / f"{name}.toml", "--quiet", *ticks]
        print(f"{'run':46}{'alone, s':>10}{'with it, s':>12}{'ratio':>8}{'MB':>8}")
        for name, run, options in ROWS:
            out, alone, observed = folder / "out", [], []
            for _ in range(given.runs):
                out.unlink(missing_ok=True)
                alone.append(cpu_seconds(commands[run], folder))
                observed.append(cpu_seconds([*commands[run], *options], folder))
            size = f"{out.stat().st_size / 1e6:8.1f}" if out.exists() else ""
            print(f"{name:46}{min(alone):10.3f}{min(observed):12.3f}{min(observed) / max(min(alone), 1e-3):8.1f}{size}", flush=True)


if __name__ == "__main__":
    main()
