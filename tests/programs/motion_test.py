"""Runs an example whose catoms are bodies and measures what they did: motion_test.py MELDSIM EXAMPLES NAME.

The digests of all ticks and the facts at the end must be the same bytes for all numbers of processes and threads; in every
recorded step the neighbours that the program saw must be those whose spheres touch; and moving.py says for each example what
must have come of it.
"""

import pathlib
import sys
import tempfile

import moving
from recorded import Recorded
from runner import SAME, Outcome, Runner

TELLING = "\ntype touches-catom(node, node).\ntouches-catom(A, B) :- neighbor(A, B).\n"
SIZES = [(1, 1), (1, 4), (2, 1), (2, 2), (4, 1)]
# A catom that comes to another process is evaluated once more.
SAME_ON_THE_WAY = tuple(key for key in SAME if key not in ("evaluations", "derivations"))


def check_neighbours(rows, places, larger=()):
    """Spheres touch when nearer than 0.5 % of a diameter, and part at 2 %; but for some that are larger than a diameter, or of
    another shape."""
    if any((b, a) not in set(rows) for a, b in rows):
        raise AssertionError("a neighbour does not see the other")
    larger = set(larger)
    seen = {frozenset(row) for row in rows if not set(row) & larger}
    near, apart = ({pair for pair in moving.pairs_within(places, far) if not pair & larger} for far in (1.005, 1.0201))
    if not near <= seen <= apart:
        raise AssertionError(f"neighbours that do not touch: {[tuple(p) for p in seen - apart][:5]}; "
                             f"that touch and are none: {[tuple(p) for p in near - seen][:5]}")


def main():
    meldsim, examples, name = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3]
    with tempfile.TemporaryDirectory() as folder:
        runner = Runner(meldsim, examples / f"{name}.meld", folder, TELLING)
        world = examples / f"{name}.toml"
        options = getattr(moving, name).options if hasattr(getattr(moving, name), "options") else ()
        sizes = getattr(getattr(moving, name), "sizes", SIZES)
        outcome = runner.run_sizes(world, options, sizes, SAME_ON_THE_WAY)
        recording = pathlib.Path(folder) / "out.vtkhdf"

        def in_world(path, processes):
            text, _, summary = runner.run(runner.telling, path, processes, 1, (*options, "--record", recording))
            recorded = Recorded(recording)
            recorded.outcomes = summary["outcomes"]
            found = Outcome(text, summary)
            check_neighbours(found.facts["touches-catom"], recorded.positions[-1], getattr(getattr(moving, name), "larger", ()))
            return found, recorded

        def in_other_world(change):
            """The same program where the world's text has been changed."""
            path = pathlib.Path(folder) / "other.toml"
            path.write_text(change(world.read_text()))
            return in_world(path, 1)

        try:
            _, recorded = in_world(world, 2 if sizes == SIZES else 1)
            getattr(moving, name)(outcome, recorded, in_other_world)
        except AssertionError as error:
            sys.exit(f"{name}: {error}")
        print(f"{name}: {outcome.summary['catoms']} catoms, {outcome.summary['ticks']} ticks")


if __name__ == "__main__":
    main()
