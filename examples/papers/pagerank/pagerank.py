"""How ranks converge, round by round, beside the bound: the sum of all errors shrinks at least by the damping 0.85 in each round, and in a
star by no more, since its second eigenvalue is as great as that of any graph may be."""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import paper  # noqa: E402

SCRIPT, DAMPING = pathlib.Path(__file__).resolve(), 0.85


def main():
    out = paper.options(SCRIPT).out
    rows = paper.rows(SCRIPT, out)
    with paper.Figure(SCRIPT, out, "rounds", "sum of errors, over that at the start", yscale="log") as axes:
        for name, graph in rows.groupby("graph", sort=False):
            graph = graph.sort_values("shown")
            shares = graph["error"] / graph["error"].iloc[0]
            bounds = DAMPING ** graph["shown"]
            print(name, *(f"{share:.2g}" for share in shares))
            # The ranks after the last round stand for the limit, from which they are 0.85^100 away.
            paper.check((shares <= bounds * (1 + 1e-4)).all(), f"{name} converges more slowly than by 0.85 a round")
            if name.startswith("star"):
                paper.check((shares >= bounds * (1 - 1e-4)).all(), "a star converges faster than the bound")
            axes.plot(graph["shown"], shares, "o-", ms=4, label=name)
        axes.plot(graph["shown"], bounds, "k--", label="bound: 0.85 to the rounds")


if __name__ == "__main__":
    main()
