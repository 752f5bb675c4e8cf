"""Rounds of Luby's algorithm against the number of nodes, beside the bound that follows from the lemma of the papers: a round removes at
least half of the links in expectation. So after k rounds E / 2^k are left, and the expected number of rounds is at most log2 E + 3."""

import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import paper  # noqa: E402

SCRIPT, DEGREE = pathlib.Path(__file__).resolve(), 6


def main():
    out = paper.options(SCRIPT).out
    rows = paper.rows(SCRIPT, out)
    rounds, messages = rows.groupby("n")["rounds"], rows.groupby("n")["messages"]
    links = {n: n * DEGREE / 2 for n in rounds.groups}
    print("   n  rounds, mean and most  bound  messages for each link")
    for n, mean in rounds.mean().items():
        bound = math.log2(links[n]) + 3
        print(f"{n:4}  {mean:4.1f} {rounds.max()[n]:2}                {bound:5.1f}  {messages.mean()[n] / links[n]:.2f}")
        paper.check(mean <= bound, f"{mean} rounds of {n} nodes, more than {bound}")
    # Three messages over a link in each direction and round.
    paper.check((rows["messages"] <= 6 * rows["n"] * DEGREE / 2 * rows["rounds"]).all(), "more messages than 6 E in each round")
    with paper.Figure(SCRIPT, out, "nodes", "rounds", xscale="log") as axes:
        axes.plot(list(links), [math.log2(e) + 3 for e in links.values()], "--", label="bound: log2 E + 3, in expectation")
        axes.plot(rows["n"], rows["rounds"], ".", color="tab:orange", alpha=0.3)
        axes.plot(rounds.mean().index, rounds.mean(), "o-", color="tab:orange", label="mean of ten seeds")
        axes.set_ylim(bottom=0)


if __name__ == "__main__":
    main()
