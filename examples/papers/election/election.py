"""Rounds until amoebots have a leader, beside the length L of the outer boundary, for systems with a small and with a large hole: in
proportion to L alone, whatever is inside. Amoebots do not move, so a round is a pass through the 36 classes of cells: 36 ticks."""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import paper  # noqa: E402

SCRIPT = pathlib.Path(__file__).resolve()


def main():
    out = paper.options(SCRIPT).out
    rows = paper.rows(SCRIPT, out)
    paper.check((rows["leaders"] == 1).all(), "some systems have no leader, or several")
    rows["rounds"] = rows["tick"] / 36
    rows["ratio"] = rows["rounds"] / rows["length"]
    ratios = rows.groupby(["hole", "length"])["ratio"]
    print("amoebots    L  rounds, least and most  rounds / L")
    for (_, length), group in rows.groupby(["hole", "length"]):
        print(f"{group['amoebots'].iloc[0]:8}  {length:3}  {group['rounds'].min():6.0f} {group['rounds'].max():6.0f}           "
              f"{group['ratio'].mean():10.1f}")
    for (hole, length), ratio in ratios.max().items():
        paper.check(ratio < 6, f"{ratio:.1f} L rounds at L = {length}, hole {hole}")
    for hole, means in ratios.mean().groupby("hole"):
        paper.check(means.iloc[-1] < 1.6 * means.iloc[0], f"rounds grow faster than L, hole {hole}")
    with paper.Figure(SCRIPT, out, "L, length of the outer boundary", "rounds") as axes:
        lengths = sorted(set(rows["length"]))
        axes.plot(lengths, [3 * length for length in lengths], "--", color="grey", label="3 L")
        for hole, name, mark in ((0.1, "small hole", "o"), (0.8, "large hole", "x")):
            some = rows[rows["hole"] == hole]
            axes.plot(some["length"], some["rounds"], mark, label=name)


if __name__ == "__main__":
    main()
