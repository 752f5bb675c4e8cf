"""Makes the documentation as a site: the pages of docs/ as they are, a page for each example with its run in it, the programs and
files that pages link to, and the commands with all options.

    make.py --bin FOLDER --out FOLDER [--runs NAME,...|none] [--reuse]

OUT/html is the site, OUT/man the manual pages of the guides. A warning is an error, and so is a link that leads nowhere.
--runs makes only the runs of these examples; --reuse keeps those that are there. Needs Sphinx, MyST and Furo: scripts/install site.
"""
import argparse
import concurrent.futures
import importlib.util
import os
import pathlib
import shutil
import subprocess
import sys

import check
import commands
import examples
import sources
import theme

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
NEEDED = {"sphinx": "python3-sphinx", "myst_parser": "python3-myst-parser", "furo": "furo"}


def lacking():
    """The Debian packages that are missing."""
    return [package for module, package in NEEDED.items() if importlib.util.find_spec(module) is None]


def lay_out(source, bin_folder, runs):
    """A folder for Sphinx with links to the pages, and what is made of the rest of the repository beside them."""
    shutil.rmtree(source, ignore_errors=True)
    source.mkdir(parents=True)
    for path in (ROOT / "docs").iterdir():
        if path != HERE:
            (source / path.name).symlink_to(path)
    # What pages show of files is read from where these are.
    (source / "repository").symlink_to(ROOT)
    for repository, page in sources.PAGES.items():
        (source / page).with_suffix(".md").symlink_to(ROOT / repository)
    for page, text in {**sources.pages(source), **examples.pages(runs), **commands.pages(bin_folder)}.items():
        path = source / f"{page}.md"
        path.parent.mkdir(parents=True, exist_ok=True)
        if isinstance(text, pathlib.Path):
            path.symlink_to(text)
        else:
            path.write_text(text)


def make_runs(into, bin_folder, names, reuse):
    """A page of the viewer for each example, with a run in it."""
    into.mkdir(parents=True, exist_ok=True)
    wanted = [example for example in examples.of_gallery() if names is None or example.name in names]
    for path in into.iterdir():
        if path.stem not in {example.name for example in wanted}:
            path.unlink()
    left = [example for example in wanted if not (reuse and (into / f"{example.name}.html").exists())]
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        jobs = {pool.submit(example.share, bin_folder, into): example for example in left}
        for done, job in enumerate(concurrent.futures.as_completed(jobs), 1):
            job.result()
            if sys.stderr.isatty():
                print(f"\r{done} of {len(left)} runs", end="\n" if done == len(left) else "", file=sys.stderr)


def sphinx(builder, source, out, doctrees):
    command = ["/usr/bin/python3", "-m", "sphinx", "-W", "--keep-going", "-q", "-b", builder, "-c", HERE, "-d", doctrees, source, out]
    subprocess.run(command, check=True, env=dict(os.environ, PYTHONDONTWRITEBYTECODE="1"))


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("--bin", type=pathlib.Path, required=True)
    arguments.add_argument("--out", type=pathlib.Path, required=True)
    arguments.add_argument("--runs")
    arguments.add_argument("--reuse", action="store_true")
    options = arguments.parse_args()
    if missing := lacking():
        print(f"scripts/site: the site cannot be made ({', '.join(missing)} is missing). Run scripts/install site.", file=sys.stderr)
        return 2
    out, bin_folder = options.out.resolve(), options.bin.resolve()
    if not (bin_folder / "meldsim").exists():
        print(f"scripts/site: there is no meldsim in {options.bin}. Build it with scripts/build, or say where it is with --bin.",
              file=sys.stderr)
        return 2
    names = None if options.runs is None else set(options.runs.split(",")) - {"none"}
    if unknown := (names or set()) - {example.name for example in examples.of_gallery()}:
        print(f"scripts/site: no example of the gallery is called {', '.join(sorted(unknown))}.", file=sys.stderr)
        return 2
    # What goes into the site beside Sphinx's pages.
    extra = out / "extra"
    os.environ["CLAYMELD_SITE_EXTRA"] = str(extra)
    make_runs(extra / "runs", bin_folder, names, options.reuse)
    (extra / "films").mkdir(exist_ok=True)
    for film in (ROOT / "docs" / "pictures").glob("*.mp4"):
        shutil.copy(film, extra / "films")
    lay_out(out / "source", bin_folder, {path.stem for path in (extra / "runs").iterdir()})
    # Sphinx would keep pages as they were, whatever has changed in how they are made.
    for folder in ("html", "man", "trees"):
        shutil.rmtree(out / folder, ignore_errors=True)
    try:
        sphinx("html", out / "source", out / "html", out / "trees" / "html")
        sphinx("man", out / "source", out / "man", out / "trees" / "man")
    except subprocess.CalledProcessError:
        print("scripts/site: Sphinx has warnings (above); each is an error.", file=sys.stderr)
        return 1
    theme.mend(out / "html")
    if problems := check.problems(out / "html"):
        print("".join(f"{problem}\n" for problem in problems) + f"scripts/site: {len(problems)} links lead nowhere.", file=sys.stderr)
        return 1
    print(f"{out / 'html' / 'index.html'}: {len(list((out / 'html').rglob('*.html')))} pages")
    return 0


if __name__ == "__main__":
    sys.exit(main())
