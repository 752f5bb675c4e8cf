"""The pages of the examples: what docs/gallery.md says of each, its run, its program and its world."""
import os
import pathlib
import re
import shlex
import subprocess
import typing

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDER = ROOT / "examples" / "meld"
# An entry of the gallery: a heading, a paragraph, a picture, and the command that makes it.
ENTRY = re.compile(r"^### (?P<title>.+)\n\n(?P<text>.+?)(?: The program: \[.*)?\n\n!\[.*\]\(pictures/gallery/(?P<name>\w+)\.webp\)\n\n"
                   r"```sh norun\n(?P<command>meldsim shot examples/meld/(?P<program>\w+)\.meld .*)\n```$", re.MULTILINE)
# What `meldsim view --share` shows as `meldsim shot` does; the rest is of the camera.
SHARED = {"--colour", "--only", "--hide", "--links", "--arrows", "--labels", "--map", "--form", "--world", "--set", "--arg", "--ticks",
          "--seed", "--exposed"}
ALONE = {"--exposed"}
# Of a page, and its frames where it is known how long the run is. A longer run has a frame every so many ticks.
MEGABYTES, FRAMES = 4, 400


class Example(typing.NamedTuple):
    name: str
    program: str
    title: str
    text: str
    command: str

    def last_tick(self):
        """Of the picture, for a run that has no end by itself."""
        ticks = re.search(r" --tick ([\d,]+)(?: |$)", self.command)
        return max(int(tick) for tick in ticks[1].split(",")) if ticks else None

    def options(self):
        """Those of `meldsim view --share` that show what the picture of the gallery shows."""
        words, kept = shlex.split(self.command)[3:], []
        while words:
            word = words.pop(0)
            name, equals, _ = word.partition("=")
            with_value = not equals and name not in ALONE and words and not words[0].startswith("--")
            value = [words.pop(0)] if with_value else []
            if name in SHARED:
                kept += [word, *value]
        return kept if self.last_tick() is None else [*kept, "--ticks", str(self.last_tick())]

    def share(self, bin_folder, into):
        """Writes INTO/NAME.html, with as many frames as its size allows."""
        every = max(1, (self.last_tick() or 0) // FRAMES)
        while True:
            done = subprocess.run([bin_folder / "meldsim", "view", f"examples/meld/{self.program}.meld", "--share",
                                   into / f"{self.name}.html", "--quiet", "--every", str(every), "--limit", str(MEGABYTES),
                                   *self.options()], cwd=ROOT, env=dict(os.environ, LC_ALL="C.UTF-8"), capture_output=True, text=True)
            if done.returncode == 0:
                return
            # Exit code 4 is a limit. Beyond this, frames are not what makes the page so large.
            if done.returncode != 4 or every > 4096:
                raise SystemExit(f"scripts/site: the run of {self.program}.meld cannot be shared:\n{done.stderr}")
            every *= 4


def of_gallery():
    return [Example(entry["name"], entry["program"], entry["title"], entry["text"], entry["command"])
            for entry in ENTRY.finditer((ROOT / "docs" / "gallery.md").read_text())]


def listing(path, language):
    return f"```{{literalinclude}} {path}\n:language: {language}\n```\n"


def page(program, example, has_run):
    # Sphinx reads a path that begins with a slash from the folder of its sources.
    out = f"# {example.title if example else program.name}\n\n"
    if example:
        out += f"{example.text}\n\n"
    if example and not has_run:
        out += f"![{example.title}](/pictures/gallery/{example.name}.webp)\n\n"
    elif example:
        out += (f'<iframe class="run" src="../runs/{example.name}.html" title="{example.title}: a run" loading="lazy"></iframe>\n\n'
                "Drag to turn, use the wheel to zoom, and move the slider below the picture to any tick; a click shows a catom. "
                f'<a href="../runs/{example.name}.html">The run on a page of its own</a>.\n\n')
    out += f"## {program.name}\n\n" + listing(f"/repository/{program.relative_to(ROOT)}", "meld")
    world = program.with_suffix(".toml")
    if world.exists():
        out += f"\n## {world.name}\n\n" + listing(f"/repository/{world.relative_to(ROOT)}", "toml")
    return out


def pages(runs):
    """Each page with its text; those of the examples that are in RUNS show their run, the others their picture."""
    known = {example.program: example for example in of_gallery()}
    runs = {example.program for example in known.values() if example.name in runs}
    programs = sorted(FOLDER.glob("*.meld"))
    found = {f"examples/{program.stem}": page(program, known.get(program.stem), program.stem in runs) for program in programs}
    order = [*(example.program for example in known.values()), *(path.stem for path in programs if path.stem not in known)]
    entries = "\n".join(order)
    found["examples/index"] = ("# The examples\n\nThis page lists all examples, in the order of [the gallery](../gallery.md). "
                               "The page of each has its run, to turn and to play, its program and its world.\n\n"
                               f"```{{toctree}}\n:maxdepth: 1\n\n{entries}\n```\n")
    return found
