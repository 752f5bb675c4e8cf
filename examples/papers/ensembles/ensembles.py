"""Cubes of metamodules that become a trumpet and a campus: how much of the shape is filled in each tick. In the end each metamodule is in
its place, and nobody holds the material of another."""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import paper  # noqa: E402

SCRIPT = pathlib.Path(__file__).resolve()


def main():
    out = paper.options(SCRIPT).out
    scenes = {name: paper.rows(SCRIPT, out, name) for name in ("trumpet", "campus")}
    ticks = [int(name.split("@")[1]) for name in scenes["trumpet"] if name.startswith("after@")]
    print("shape    metamodules  filled after 50  100  200 ticks")
    for name, rows in scenes.items():
        for tick in ticks:  # A run ends when nothing is left to do.
            rows[f"after@{tick}"] = rows[f"after@{tick}"].fillna(rows["filled"])
        paper.check((rows["filled"] == rows["metamodules"]).all() and (rows["held"] == 0).all(), f"a {name} is not complete")
        for _, row in rows.iterrows():
            shares = [round(100 * row[f"after@{tick}"] / row["metamodules"]) for tick in (50, 100, 200)]
            print(f"{name:8} {row['metamodules']:10.0f}  {shares[0]:13} % {shares[1]:3}% {shares[2]:3}%")
    with paper.Figure(SCRIPT, out, "ticks", "filled, % of the shape", xscale="log") as axes:
        for (name, rows), line in zip(scenes.items(), ("-", "--")):
            axes.set_prop_cycle(None)
            for _, row in rows.iterrows():
                filled = [100 * row[f"after@{tick}"] / row["metamodules"] for tick in ticks]
                axes.plot(ticks, filled, line, label=f"{name}, {row['metamodules']:,.0f}")


if __name__ == "__main__":
    main()
