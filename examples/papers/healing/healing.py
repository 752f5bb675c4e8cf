"""How gradients heal after their source has moved: the plain one rises as slowly as its shortest links let it, the problem with which the
papers on crf and bis begin; theirs do not depend on the shortest link, and `field` withdraws what has lost its support."""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import paper  # noqa: E402

SCRIPT, MOVES = pathlib.Path(__file__).resolve(), 60


def main():
    out = paper.options(SCRIPT).out
    rows = paper.rows(SCRIPT, out)
    ticks = [int(name.split("@")[1]) for name in rows.columns if name.startswith("plain@")]
    errors = {name: [rows[f"{name}@{tick}"].mean() for tick in ticks] for name in ("plain", "crf", "bis", "field")}
    print("ticks after  " + "  ".join(f"{name:>6}" for name in errors))
    for tick, *values in zip(ticks, *errors.values()):
        print(f"{tick - MOVES:11}  " + "  ".join(f"{value:6.2f}" for value in values))

    def healed(name):
        """After how many ticks distances are right to a hundredth of what was wrong at first."""
        return min([tick - MOVES for tick, error in zip(ticks, errors[name]) if tick > MOVES and error < 0.01 * errors[name][0]],
                   default=ticks[-1] - MOVES + 1)

    # Distances rise by 1 a tick with crf, and news come by at least 0.7 a tick with bis: so they are right after as many ticks as it is far
    # over that, and the links on the way.
    far = rows["farthest"].max()
    print(f"healed after: {({name: healed(name) for name in errors})}; the farthest device is {far:.1f} from the source")
    paper.check(healed("crf") <= 2 * far and healed("bis") <= 2 * far / 0.7, "crf and bis take longer than in proportion to the distance")
    paper.check(healed("field") <= healed("crf") < healed("plain"), "the plain gradient heals as fast as the others")
    with paper.Figure(SCRIPT, out, "ticks after the source has moved", "mean error") as axes:
        for name, line in zip(errors, ("s-", "o-", "^-", "d-")):
            axes.plot([tick - MOVES for tick in ticks], errors[name], line, ms=4, label=name)


if __name__ == "__main__":
    main()
