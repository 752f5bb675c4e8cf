"""The papers of examples/papers: each script runs its study, finds what the paper says, and draws it; where the study or its program is
broken in one place, it says so.

Usage: papers_test.py MELDSIM NAME
"""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
# Files of the paper's folder, and what is replaced in them.
BREAKS = {
    # Numbers that are not drawn, and rise along a line.
    "luby": [("../../meld/luby.meld", "X = randint(1000000000)", "X = node2int(A)"), ("study.toml", "regular({n}, 6)", "line({n})")],
    "ghs": [("study.toml", "regular({n}, 4)", "complete({n})"), ("study.toml", "[32, 64, 128, 256, 512]", "[32, 64]")],
    "compression": [("study.toml", "ticks = 300000", "ticks = 3000")],
    "healing": [("gradients.meld", "const bis-speed = 0.7.", "const bis-speed = 0.7.\nconst crf-speed = 0.05.")],
    # Whoever is alone leads, around holes too.
    "election": [("../../meld/boundary_election.meld", "border(A, _, 6)", "border(A, _, _)")],
    # The cost of a way is given up too early, so units find no way to the last empty cells.
    "ensembles": [("../../meld/shape_change.meld", "const reach = 12.0.", "const reach = 1.0.")],
    # Those inside never move, so holes stay where they came to be.
    "holes": [("../../meld/hole_motion.meld", "target(A, P) -o", "target(A, P), outside(A) -o")],
    # They go around each other as closely as half a diameter.
    "kilobots": [("assembly.meld", "const apart = 1.0.", "const apart = 0.5.")],
    # Nobody adjusts to his neighbours.
    "localization": [("../../meld/localization.meld", "const sweeps = 10.", "const sweeps = 0."),
                     ("../../meld/localization.meld", "const last-sweeps = 30.", "const last-sweeps = 0.")],
    "pagerank": [("convergence.meld", "damping = 0.85", "damping = 0.9")],
}


def run(meldsim, papers, name, out):
    environment = {**os.environ, "CLAYMELD_MELDSIM": str(pathlib.Path(meldsim).resolve()), "PYTHONPATH": str(ROOT / "python"),
                   "MPLCONFIGDIR": str(out)}
    command = [sys.executable, "-B", papers / name / f"{name}.py", "--out", out]
    return subprocess.run(command, env=environment, capture_output=True, text=True, timeout=280)


def pixels(path):
    from matplotlib import image
    return image.imread(path)


def main():
    meldsim, name = sys.argv[1:]
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(scratch)
        done = run(meldsim, ROOT / "examples" / "papers", name, folder / "out")
        print(done.stdout)
        assert done.returncode == 0, done.stderr
        made, shown = pixels(folder / "out" / f"{name}.png"), pixels(ROOT / "docs" / "pictures" / "papers" / f"{name}.png")
        assert made.std() > 0.02, "nothing is in the picture"
        # Another version of the library may draw other fonts.
        assert made.shape == shown.shape and abs(made - shown).mean() < 0.05, "docs/pictures/papers has another picture: make it anew"
        shutil.copytree(ROOT / "examples", folder / "examples")
        for file, right, wrong in BREAKS[name]:
            path = folder / "examples" / "papers" / name / file
            text = path.read_text()
            assert right in text, f"{file} has no '{right}' that could be broken"
            path.write_text(text.replace(right, wrong))
        done = run(meldsim, folder / "examples" / "papers", name, folder / "broken")
        assert done.returncode == 1 and "not as in the paper" in done.stderr, f"broken, and nobody notices: {done.stdout}{done.stderr}"
        print(done.stderr.strip().splitlines()[-1])


if __name__ == "__main__":
    main()
