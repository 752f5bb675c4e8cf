"""Viewers that run while a test talks to them."""
import json
import pathlib
import signal
import subprocess
import sys
import time
import urllib.parse

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from frame import COUNT, FOREVER, Case, square  # noqa: E402
from websocket import Page  # noqa: E402

# The ends of viridis.
PURPLE, YELLOW = (0x44, 0x01, 0x54), (0xFD, 0xE7, 0x25)
CORNER = """type source(node).
type dist(node, min int).
type linear token(node, int).
dist(A, 0)     :- source(A).
dist(B, D + 1) :- neighbor(A, B), dist(A, D).
token(A, N), N > 0, neighbor(A, B), A < B -o token(B, N - 1).
"""


class Viewing(Case):
    FILES = {"corner.meld": CORNER, "corner.toml": square(6) + '[facts]\nsource = "id == 0"\n', "p.meld": COUNT, "p.toml": square(4),
             "forever.meld": FOREVER, "forever.toml": square(40)}

    def view(self, *arguments, environment=None):
        """Its link; and the process, in self.process."""
        self.process = self.begin("meldsim", "view", *arguments, "--json", "--no-open", environment=environment,
                                  stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        line = self.process.stdout.readline()
        self.assertTrue(line, "" if line else self.process.stderr.read())
        return json.loads(line)["link"]

    @staticmethod
    def port(link):
        return urllib.parse.urlsplit(link).port

    def page(self, link, **how):
        page = Page(link, **how)
        self.addCleanup(page.close)
        return page

    def interrupt(self, code=130, seconds=5):
        """Ends the viewer as Ctrl-C does; returns how long that took."""
        begun = time.monotonic()
        self.process.send_signal(signal.SIGINT)
        out, err = self.process.communicate(timeout=seconds)
        self.assertEqual(self.process.returncode, code, out + err)
        return time.monotonic() - begun

    def resident_bytes(self):
        fields = pathlib.Path(f"/proc/{self.process.pid}/status").read_text().split("VmRSS:")[1].split()
        return int(fields[0]) * 1024
