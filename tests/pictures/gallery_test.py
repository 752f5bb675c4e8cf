"""The gallery has a picture of each example, and its commands still make them.

    gallery_test.py --bin FOLDER [NAME...]       makes these pictures again; otherwise all
"""
import argparse
import pathlib
import re
import subprocess
import sys
import tempfile

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGE, PICTURES = ROOT / "docs" / "gallery.md", ROOT / "docs" / "pictures" / "gallery"
# Of 255, on the average of all pixels: what the compression of two files may differ by.
ALIKE = 2


def pixels(path):
    """Its red, green and blue, one after the other, with its size in front."""
    out = subprocess.run(["ffmpeg", "-nostdin", "-v", "error", "-i", path, "-f", "image2pipe", "-c:v", "ppm", "-pix_fmt", "rgb24", "-"],
                         stdout=subprocess.PIPE, check=True).stdout
    kind, size, most, body = out.split(b"\n", 3)
    assert (kind, most) == (b"P6", b"255"), "no picture"
    return size, np.frombuffer(body, np.uint8).astype(int)


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("--bin", required=True, type=pathlib.Path)
    arguments.add_argument("names", nargs="*")
    options = arguments.parse_args()
    page = PAGE.read_text()
    # A program's own world; others are for other programs too.
    examples = sorted(path.stem for path in (ROOT / "examples" / "meld").glob("*.toml") if path.with_suffix(".meld").exists())
    for what, names in (("pictures are shown", re.findall(r"^!\[.+\]\(pictures/gallery/(\w+)\.webp\)$", page, re.M)),
                        ("commands stand there", re.findall(r"^meldsim shot examples/meld/\w+\.meld -o (\w+)\.png ", page, re.M)),
                        ("programs are run", re.findall(r"^meldsim shot examples/meld/(\w+)\.meld ", page, re.M)),
                        ("files exist", [path.stem for path in PICTURES.glob("*.webp")])):
        assert sorted(names) == examples, f"{PAGE}: other {what} than there are examples: {sorted(set(names) ^ set(examples))}"
    with tempfile.TemporaryDirectory() as folder:
        names = options.names or examples
        subprocess.run([ROOT / "scripts" / "gallery", "--bin", options.bin.resolve(), "--into", folder, *names], check=True)
        for name in names:
            (size, now), (size_before, before) = (pixels(pathlib.Path(where) / f"{name}.webp") for where in (folder, PICTURES))
            assert size == size_before, f"{name}: {size} pixels instead of {size_before}"
            differ = np.abs(now - before).mean()
            assert differ <= ALIKE, f"{name}: its command makes another picture, by {differ:.1f} of 255; run scripts/gallery {name}"
            assert now.std() > 5, f"{name}: nothing is in it"
    print(f"{len(names)} of {len(examples)} pictures made again")


if __name__ == "__main__":
    sys.exit(main())
