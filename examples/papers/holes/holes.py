"""How much of a disc of metamodules is in the bar that it is to become, against time, for discs of three sizes. The paper reaches 97.3 %
with 60,000 metamodules, in a time that depends on the target alone; here holes wander as they will, so larger ensembles take longer."""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import paper  # noqa: E402

SCRIPT, PAPER = pathlib.Path(__file__).resolve(), 0.973


def main():
    out = paper.options(SCRIPT).out
    rows = paper.rows(SCRIPT, out)
    ticks = [int(name.split("@")[1]) for name in rows.columns if name.startswith("left@")]
    inside = {size: [1 - (some[f"left@{tick}"] / size).mean() for tick in ticks] for size, some in rows.groupby("metamodules")}
    sizes = sorted(inside)

    def reached(size):
        """In which of the ticks that were looked at as much is in place as in the paper."""
        return next((tick for tick, share in zip(ticks, inside[size]) if share >= PAPER), None)

    for size in sizes:
        print(f"{size:5} metamodules: 97.3 % in place after {reached(size)} ticks, {inside[size][-1]:.2%} after {ticks[-1]}")
    paper.check(all(reached(size) for size in sizes), "fewer than 97.3 % of the metamodules come into the target")
    paper.check(reached(sizes[0]) <= reached(sizes[1]) < reached(sizes[2]), "the time does not grow with the ensemble")
    with paper.Figure(SCRIPT, out, "ticks", "metamodules in the target", xscale="log", ylim=(0.4, 1.02)) as axes:
        axes.axhline(PAPER, ls="--", color="grey", label="paper, 60,000 metamodules: 97.3 %")
        for size, line in zip(sizes, ("o-", "s-", "^-")):
            axes.plot(ticks, inside[size], line, ms=4, label=f"{size:,} metamodules")


if __name__ == "__main__":
    main()
