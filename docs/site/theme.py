"""What Debian's package of Furo leaves out: its script is in two files that no browser puts together, its style asks for a file at a place
of the server, and a dark page is dark only for who says so on the page, not for whose browser says so."""
import pathlib
import re
import subprocess

NORMALIZE = pathlib.Path("/usr/share/javascript/normalize.css/normalize.css")
IMPORT = re.compile(r'^@import url\("?/javascript/normalize\.css/normalize\.css"?\);$', re.MULTILINE)
DARK = re.compile(r'body\[data-theme="?dark"?\] \{([^{}]*--color-background-primary[^{}]*)\}')


def mend(html):
    style, script = html / "_static/styles/furo.css", html / "_static/scripts/furo.js"
    text = style.read_text()
    if IMPORT.search(text):
        text = NORMALIZE.read_text() + IMPORT.sub("", text)
    if "prefers-color-scheme" not in text:
        dark = DARK.search(text)[1]
        text += f'\n@media (prefers-color-scheme: dark) {{ body:not([data-theme="light"]) {{{dark}}} }}\n'
    style.write_text(text)
    if script.read_text().startswith("import "):
        subprocess.run(["esbuild", script, "--bundle", "--format=iife", "--allow-overwrite", "--log-level=error", f"--outfile={script}"],
                       check=True)
