"""The perimeter of a system of amoebots against the bias lambda, beside what the paper proves: it compresses for lambda > 2 + sqrt 2, and
does not for lambda < 2.17."""

import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import paper  # noqa: E402

SCRIPT = pathlib.Path(__file__).resolve()
EXPANDS, COMPRESSES = 2.17, 2 + math.sqrt(2)


def main():
    out = paper.options(SCRIPT).out
    rows = paper.rows(SCRIPT, out)
    n = int(rows["amoebots"].max())
    # Connected and without holes: 3 n - e - 3 around the outside (Section 2), where e pairs touch. The least is that of a hexagon.
    rows["perimeter"] = 3 * n - rows["touching"] / 2 - 3
    least, most = math.ceil(math.sqrt(12 * n - 3)) - 3, 2 * n - 2
    means = rows.groupby("lambda")["perimeter"].mean()
    print(f"{n} amoebots: perimeters from {least} to {most}")
    for bias, mean in means.items():
        print(f"lambda {bias}: {mean:.1f}, {mean / least:.2f} of the least, {mean / most:.2f} of the greatest")
    compressed, spread = rows[rows["lambda"] > COMPRESSES]["perimeter"], rows[rows["lambda"] < EXPANDS]["perimeter"]
    paper.check(compressed.max() < spread.min(), "a small bias compresses as much as a great one")
    paper.check(compressed.max() < 0.5 * most, "a great bias does not compress")
    with paper.Figure(SCRIPT, out, "bias lambda", "perimeter") as axes:
        axes.axvspan(0.8, EXPANDS, color="tab:blue", alpha=0.12, label="paper: does not compress")
        axes.axvspan(COMPRESSES, 6.2, color="tab:orange", alpha=0.15, label="paper: compresses")
        axes.axhline(most, ls=":", color="grey", label="that of a line")
        axes.axhline(least, ls="--", color="grey", label="that of a hexagon")
        axes.plot(rows["lambda"], rows["perimeter"], "o", color="black", label="three seeds")


if __name__ == "__main__":
    main()
