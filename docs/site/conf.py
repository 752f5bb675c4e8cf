"""Sphinx's settings for the site; make.py lays out its sources and runs it."""
import os
import pathlib
import re
import sys

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(HERE), str(ROOT / "editors" / "pygments")]

from docutils import nodes  # noqa: E402
from meld_lexer import MeldLexer  # noqa: E402
from sphinx import addnodes  # noqa: E402
from sphinx.transforms import SphinxTransform  # noqa: E402

import examples  # noqa: E402
import sources  # noqa: E402

project = "Claymeld"
author = "The Claymeld project"
copyright = "The Claymeld project"  # noqa: A001
release = version = re.search(r'kVersion\w*\W+"?(\d+\.\d+\.\d+)', (ROOT / "runtime/base/version.h").read_text())[1]
extensions = ["myst_parser"]
source_suffix = {".md": "markdown"}
exclude_patterns = ["repository"]
# Headings have the places that they have in the repository's pages.
myst_heading_anchors = 6
myst_enable_extensions = ["deflist"]
language = "en"
# Text as it stands in the pages: -- begins an option.
smartquotes = False

html_theme = "furo"
html_title = f"Claymeld {release}"
html_static_path = [str(HERE / "style")]
html_css_files = ["site.css"]
html_extra_path = [os.environ["CLAYMELD_SITE_EXTRA"]]
html_copy_source = False
html_show_sphinx = False
html_theme_options = {"navigation_with_keys": True}
pygments_style, pygments_dark_style = "tango", "monokai"

# The guides as manual pages; those of the programs come from the programs.
man_pages = [(page, f"claymeld-{page.rsplit('/')[-1]}", title, author, section) for page, title, section in (
    ("tour", "ten minutes with Claymeld", 7), ("language", "the language Meld", 7), ("library", "building blocks written in Meld", 7),
    ("functions", "functions that every Meld program can call", 7), ("motion", "how catoms move", 7),
    ("debugging", "how to find out why a run does what it does", 7), ("networks", "messages, clocks and failures", 7),
    ("worlds", "world files of meldsim", 5), ("recordings", "recordings of runs", 5), ("data", "tables of facts", 5))]

LINK = re.compile(r"\[([^\]]+)\]\(([^)\s]+)\)")


def entry_lists(text):
    """The lists of docs/index.md with what stands above each, as titles and links."""
    caption, lists = "", []
    for line in text.splitlines():
        if line.startswith("**"):
            caption = re.match(r"\*\*(.*?)\*\*", line)[1]
            lists.append((caption, []))
        elif lists and re.match(r"(?:\d+\.|-) ", line):
            found = LINK.findall(line)
            lists[-1][1].extend(found[:1] if line[0].isdigit() else found)
    return lists


def toctrees(page, text):
    """The side bar, from the lists of docs/index.md: the pages to read in their order, then every other page once."""
    seen, out = set(), ""
    for caption, links in entry_lists(text):
        lines = []
        for title, link in links:
            path = sources.target(page, link.split("#")[0])
            name = sources.page_of(path) if path else None
            if name and name not in seen and not name.startswith("files/"):
                seen.add(name)
                number = f"{len(lines) + 1}. " if caption.startswith("Ten") else ""
                shown = title[0].upper() + title[1:]
                # "The reference" is called by what it is the reference of.
                lines.append(f"{number}{shown} <{name}>" if not name.startswith("reference/") else name)
        if lines:
            out += f"\n```{{toctree}}\n:hidden:\n:caption: {caption}\n\n" + "\n".join(lines) + "\n```\n"
    out += "\n```{toctree}\n:hidden:\n:caption: All options\n\nmanual/index\n```\n"
    return out


def add_contents(app, docname, text):
    if docname == "index":
        text[0] += toctrees(ROOT / "docs" / "index.md", text[0])
    elif docname.startswith("files/"):
        # They are in no list; other pages link to them.
        text[0] = "---\norphan: true\n---\n" + text[0]
    elif docname == "lab/index":
        names = [link.removesuffix(".md") for _, link in LINK.findall(text[0]) if link.endswith(".md") and "/" not in link]
        text[0] += "\n```{toctree}\n:hidden:\n\n" + "\n".join(names) + "\n```\n"


class LinksToFiles(SphinxTransform):
    """Links to files of the repository lead to the pages that show them, and a picture of the gallery to its run."""

    default_priority = 1

    def apply(self):
        page = self.env.doc2path(self.env.docname)
        for node in list(self.document.findall(lambda node: isinstance(node, (addnodes.pending_xref, addnodes.download_reference)))):
            if node.get("reftype") != "myst" or "://" in node["reftarget"]:
                continue
            path, _, place = node["reftarget"].partition("#")
            if path.endswith(".mp4"):
                self.show_film(node)
            found = sources.target(page, path) if path and not path.startswith("/") else None
            name = sources.page_of(found) if found else None
            if name is None or (name == self.env.path2doc(page)):
                continue
            if place:
                node["reftarget"] = os.path.relpath(f"{name}.md", os.path.dirname(self.env.docname) or ".") + f"#{place}"
            else:
                node.replace_self(addnodes.pending_xref("", *node.children, refdoc=self.env.docname, reftype="doc", refdomain="std",
                                                        reftarget=f"/{name}", refexplicit=True, refwarn=True))
        if self.env.docname == "gallery":
            self.link_pictures()

    def show_film(self, link):
        """Below the paragraph that links to it."""
        paragraph = link
        while not isinstance(paragraph, nodes.paragraph):
            paragraph = paragraph.parent
        name = pathlib.PurePosixPath(link["reftarget"]).name
        path = "../" * self.env.docname.count("/") + f"films/{name}"
        film = nodes.raw("", f'<video controls loop muted preload="metadata" src="{path}"></video>', format="html")
        paragraph.parent.insert(paragraph.parent.index(paragraph) + 1, film)

    def link_pictures(self):
        known = {example.name: example.program for example in examples.of_gallery()}
        for image in list(self.document.findall(nodes.image)):
            name = pathlib.PurePosixPath(image["uri"]).stem
            if name in known:
                link = nodes.reference("", "", image.deepcopy(), refuri=f"examples/{known[name]}.html", internal=True)
                image.replace_self(link)


def setup(app):
    app.add_lexer("meld", MeldLexer)
    app.connect("source-read", add_contents)
    app.add_transform(LinksToFiles)
    return {"parallel_read_safe": True}
