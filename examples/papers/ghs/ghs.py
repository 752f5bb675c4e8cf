"""Messages of the minimum spanning tree of Gallager, Humblet and Spira against the number of nodes, beside the bound of the paper,
5 N log2 N + 2 E, and levels of fragments beside log2 N."""

import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import paper  # noqa: E402

SCRIPT, DEGREE = pathlib.Path(__file__).resolve(), 4


def bound(n):
    return 5 * n * math.log2(n) + 2 * n * DEGREE / 2


def main():
    out = paper.options(SCRIPT).out
    rows = paper.rows(SCRIPT, out)
    means = rows.groupby("n")["messages"].mean()
    print("   n  messages  bound  levels, log2 n")
    for n, mean in means.items():
        print(f"{n:4}  {mean:8.0f} {bound(n):6.0f}  {rows[rows['n'] == n]['level'].max()}, {math.log2(n):.0f}")
    paper.check((rows["messages"] <= rows["n"].map(bound)).all(), "more messages than 5 N log2 N + 2 E")
    paper.check((rows["level"] <= rows["n"].map(math.log2)).all(), "more levels than log2 N")
    with paper.Figure(SCRIPT, out, "nodes", "messages", xscale="log", yscale="log") as axes:
        axes.plot(means.index, [bound(n) for n in means.index], "--", label="bound: 5 N log2 N + 2 E")
        axes.plot(means.index, means, "o-", label="mean of five seeds")
        axes.plot(means.index, [2 * n * DEGREE / 2 for n in means.index], ":", color="grey", label="2 E")


if __name__ == "__main__":
    main()
