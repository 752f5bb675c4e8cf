"""The error of localization against the noise in what catoms see, for three sizes: the root mean square of how wrong the distances from all
catoms to one of them are. A catom that sees a neighbour wrong by some angle would place it wrong by as much, in diameters; what all find
together is better, and hardly worse in larger ensembles."""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import paper  # noqa: E402

SCRIPT = pathlib.Path(__file__).resolve()


def main():
    out = paper.options(SCRIPT).out
    rows = paper.rows(SCRIPT, out)
    paper.check((rows["placed"] == rows["catoms"]).all(), "not all catoms know where they are")
    errors = rows.groupby(["catoms", "noise"])["square"].mean() ** 0.5
    noises, sizes = sorted(set(rows["noise"])), sorted(set(rows["catoms"]))
    print("catoms  " + "  ".join(f"{noise:6} rad" for noise in noises))
    for size in sizes:
        print(f"{size:6}  " + "  ".join(f"{errors[size, noise]:10.5f}" for noise in noises))
    for (size, noise), error in errors.items():
        paper.check(error < (noise or 1e-4), f"{size} catoms are wrong by {error} with a noise of {noise}")
    for noise in noises[1:]:
        paper.check(errors[sizes[-1], noise] < 2 * errors[sizes[0], noise], f"errors grow with the ensemble at a noise of {noise}")
    with paper.Figure(SCRIPT, out, "noise, radians", "error, diameters") as axes:
        axes.plot(noises, noises, "--", color="grey", label="of a neighbour, seen by one catom")
        for size in sizes:
            axes.plot(noises, [errors[size, noise] for noise in noises], "o-", label=f"{size} catoms")


if __name__ == "__main__":
    main()
