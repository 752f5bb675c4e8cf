"""What the scripts of this folder share: the rows of the study beside them, the picture, and checks that end the script where one fails."""

import argparse
import pathlib
import subprocess
import sys

import pandas

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "python"))

import claymeld  # noqa: E402


def options(script):
    """Where the picture and the results go: by default into this folder, of which nothing else is changed."""
    arguments = argparse.ArgumentParser(description=f"Makes {script.stem}.png from the runs of {script.parent.name}/study.toml.")
    arguments.add_argument("--out", type=pathlib.Path, default=pathlib.Path("."), help="folder of the picture and of the results")
    chosen = arguments.parse_args()
    chosen.out.mkdir(parents=True, exist_ok=True)
    return chosen


def rows(script, out, study="study"):
    """One for each run; those that are there already are not made again."""
    results = out / (f"{script.stem}.results" if study == "study" else f"{study}.results")
    subprocess.run([claymeld.find_meldsim(), "sweep", script.with_name(f"{study}.toml"), "-o", results, "--quiet"], check=True)
    return pandas.read_csv(results / "rows.csv")


def check(holds, otherwise):
    if not holds:
        sys.exit(f"not as in the paper: {otherwise}")


class Figure:
    """One pair of axes, saved as a small PNG when the block ends."""

    def __init__(self, script, out, x, y, **scales):
        import matplotlib
        matplotlib.use("Agg")
        from matplotlib import pyplot
        self.path = out / f"{script.stem}.png"
        self.figure, self.axes = pyplot.subplots(figsize=(5.6, 3.6), dpi=100)
        self.axes.set(xlabel=x, ylabel=y, **scales)

    def __enter__(self):
        return self.axes

    def __exit__(self, *failure):
        if failure == (None, None, None):
            self.axes.legend(frameon=False, fontsize=8)
            self.axes.grid(alpha=0.25)
            self.figure.tight_layout()
            self.figure.savefig(self.path, metadata={"Software": None})
            print(f"picture: {self.path}")
