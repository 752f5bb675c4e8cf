"""A hundred and fifty robots that assemble a heart: how many have found their place after how many ticks, with and without errors in what
they sense. All must end in the shape, none on another, and know where they are. Twice as many take twice as long."""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import paper  # noqa: E402

SCRIPT = pathlib.Path(__file__).resolve()
SEEDS = 4
# What a Kilobot is and does, and how far a robot goes in a tick, in diameters.
DIAMETER_MM, SPEED_MM_S, PACE = 33, 10, 0.2


def compare_sizes(out):
    print("robots  ticks  ticks a robot  seconds a robot, of a Kilobot")
    found = []
    for _, row in paper.rows(SCRIPT, out, "growth").iterrows():
        paper.check(row["placed"] == row["robots"], f"{row['robots'] - row['placed']} of {row['robots']} robots have found no place")
        found.append(row["ticks"] / (row["robots"] - SEEDS))
        print(f"{row['robots']:6}  {row['ticks']:5}  {found[-1]:13.1f}  {found[-1] * PACE * DIAMETER_MM / SPEED_MM_S:28.1f}")
    paper.check(max(found) < 1.15 * min(found), f"the robots take {found} ticks each")


def main():
    out = paper.options(SCRIPT).out
    rows = paper.rows(SCRIPT, out)
    ticks = [int(name.split("@")[1]) for name in rows if name.startswith("after@")]
    print("noise  in place  outside  closest two  error of a place  layers")
    for _, row in rows.iterrows():
        noise = "bearing" in row["links.noise"]
        print(f"{'yes' if noise else 'no':5}  {row['placed']:3} of {row['robots']}  {row['outside']:7}  {row['closest']:11.2f}  "
              f"{row['error']:16.3f}  {row['hops']:6}")
        paper.check(row["placed"] == row["robots"], f"{row['robots'] - row['placed']} robots have found no place")
        paper.check(row["closest"] > 0.75, f"two robots are {row['closest']:.2f} diameters apart")
        paper.check(row["outside"] <= (row["robots"] / 20 if noise else 0), f"{row['outside']} robots are outside the shape")
        paper.check(row["error"] < (0.5 if noise else 1e-6), f"a robot is {row['error']:.2f} diameters from where it believes to be")
    compare_sizes(out)
    with paper.Figure(SCRIPT, out, "ticks", "robots in their place") as axes:
        for _, row in rows.iterrows():
            # A run ends when nothing is left to do.
            placed = [row["placed"] if row[f"after@{tick}"] != row[f"after@{tick}"] else row[f"after@{tick}"] for tick in ticks]
            axes.plot(ticks, placed, "o-", label="with noise" if "bearing" in row["links.noise"] else "without noise")


if __name__ == "__main__":
    main()
