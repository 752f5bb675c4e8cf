"""Runs in the cells of a notebook: what a kernel of Jupyter answers is a page that a browser shows, to turn and to play.

    notebook_test.py --meldsim PATH [unittest options]
"""
import functools
import gc
import html
import http.server
import importlib.util
import pathlib
import re
import socket
import sys
import threading
import time
import unittest
import urllib.parse

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests"), str(ROOT / "python")]

from frame import FRONT, TOOLS, Case, main, square  # noqa: E402

import claymeld  # noqa: E402

NEEDED = {"nbclient": "python3-nbclient", "nbformat": "python3-nbformat", "ipykernel": "python3-ipykernel"}
MISSING = [package for module, package in NEEDED.items() if importlib.util.find_spec(module) is None]
FLAGS = ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--window-size=1100,900", "--use-angle=swiftshader",
         "--enable-unsafe-swiftshader")
CELLS = ["import claymeld\nrun = claymeld.run('p.meld', 'p.toml', predicates=['dist'])\nrun",
         "run.view(colour='dist(A, D)', facts='all', every=2, height=640)",
         "with claymeld.open('kept.vtkhdf') as recording:\n    shown = recording.view(height=300)\nshown",
         "claymeld.view('p.meld', 'p.toml', height=444)"]


class Cells(Case):
    FILES = {"p.meld": FRONT, "p.toml": square(6)}

    def run_here(self, **wanted):
        return claymeld.run(self.folder / "p.meld", self.folder / "p.toml", meldsim=TOOLS.meldsim, **wanted)

    def page_in(self, output):
        """What is in the frame of a cell."""
        return html.unescape(re.fullmatch(r'<iframe srcdoc="([^"]*)" sandbox="allow-scripts allow-forms"[^>]*></iframe>', output)[1])

    def answers(self):
        """What each cell shows as HTML, from a kernel of its own."""
        import nbclient
        import nbformat
        self.run_here(record=self.folder / "kept.vtkhdf")
        notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(text) for text in CELLS])
        path = f"import sys, os; sys.path.insert(0, {str(ROOT / 'python')!r}); os.environ['CLAYMELD_MELDSIM'] = {TOOLS.meldsim!r}\n"
        notebook.cells[0].source = path + notebook.cells[0].source
        nbclient.NotebookClient(notebook, timeout=60, kernel_name="python3", resources={"metadata": {"path": str(self.folder)}}).execute()
        return [cell.outputs[-1].data["text/html"] for cell in notebook.cells]

    @unittest.skipIf(MISSING, f"there are no notebooks without {', '.join(MISSING)}: scripts/install test")
    def test_cells_of_a_notebook_show_pages(self):
        *shown, live = self.answers()
        self.assertIn("height: 444px", live)
        # Its server has ended with the kernel.
        self.until(lambda: not self.listens(re.search('src="([^"]*)"', live)[1]))
        for output in shown:
            self.assertTrue(self.page_in(output).startswith("<!doctype html>"), output[:200])
        for output, height in zip(shown, (520, 640, 300)):
            self.assertIn(f"height: {height}px", output)
        self.write("cell.html", f"<!doctype html><html><body>{shown[1]}</body></html>")
        browser = self.browser()
        browser.get((self.folder / "cell.html").as_uri())
        self.enter_frame(browser)
        self.until(lambda: browser.execute_script("return document.body.dataset.ready"))
        browser.execute_script("viewer.refresh(viewer.info.last)")
        self.until(lambda: browser.execute_script("return document.body.dataset.tick === String(viewer.info.last)"))
        self.assertIn("dist(A, D)", browser.execute_script("return document.body.innerText"))
        # A form in a frame.
        browser.execute_script("document.getElementById('find').value = 'dist(@0, 0)'; document.getElementById('search').requestSubmit()")
        self.until(lambda: browser.execute_script("return document.getElementById('found').textContent") == "1 catom")

    def until(self, holds):
        end = time.monotonic() + 20
        while not holds():
            self.assertLess(time.monotonic(), end)
            time.sleep(0.05)

    def browser(self):
        from selenium import webdriver
        from selenium.webdriver.chrome.service import Service
        options = webdriver.ChromeOptions()
        for flag in FLAGS:
            options.add_argument(flag)
        browser = webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=options)
        self.addCleanup(browser.quit)
        return browser

    @staticmethod
    def enter_frame(browser):
        browser.switch_to.frame(browser.find_element("css selector", "iframe"))

    @staticmethod
    def listens(link):
        with socket.socket() as connection:
            return connection.connect_ex(("127.0.0.1", urllib.parse.urlsplit(link).port)) == 0

    def served(self):
        """A server of this machine, as a notebook has one, for files of this test's folder."""
        class Handler(http.server.SimpleHTTPRequestHandler):
            log_message = staticmethod(lambda *_: None)

        server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Handler, directory=str(self.folder)))
        threading.Thread(target=server.serve_forever, daemon=True).start()
        self.addCleanup(server.server_close)
        self.addCleanup(server.shutdown)
        return f"http://localhost:{server.server_port}"

    def test_a_live_page_is_in_a_cell(self):
        live = claymeld.view(self.folder / "p.meld", self.folder / "p.toml", colour="dist(A, D)", map="magma", meldsim=TOOLS.meldsim)
        self.addCleanup(live.close)
        self.write("cell.html", f"<!doctype html><html><body>{live._repr_html_()}</body></html>")
        browser, here = self.browser(), self.served()
        browser.get(f"{here}/cell.html")
        self.enter_frame(browser)
        self.until(lambda: browser.execute_script("return document.body.dataset.ready"))
        self.assertEqual(browser.execute_script("return ['look-colour', 'look-map'].map((id) => document.getElementById(id).value)"),
                         ["dist(A, D)", "magma"])
        # It runs, and can be asked and changed.
        self.assertTrue(browser.execute_script("return viewer.info.live"))
        browser.execute_script("return viewer.command('run')")
        self.until(lambda: browser.execute_script("return document.getElementById('legend').innerText").startswith("D"))
        said = browser.execute_script("return viewer.source.command('kill @35')")
        self.assertTrue(said["ok"], said)
        # One that may not be framed stays away, and so does it from pages of elsewhere.
        child = self.begin("meldsim", "view", "p.meld", "--json", "--no-open", stdout=-1, text=True)
        link = re.search('"link":"([^"]*)"', child.stdout.readline())[1]
        self.write("not.html", f'<!doctype html><html><body><iframe src="{link}"></iframe></body></html>')
        self.write("elsewhere.html", self.read("cell.html").decode())
        for page in (f"{here}/not.html", (self.folder / "elsewhere.html").as_uri()):
            browser.get(page)
            self.enter_frame(browser)
            self.until(lambda: browser.execute_script("return document.readyState") == "complete")
            self.assertFalse(browser.execute_script("return 'viewer' in window"), page)
        child.kill()
        child.communicate()

    def test_a_live_page_of_a_run_ends_with_its_object(self):
        run = self.run_here(predicates=["dist"])
        with run.view(live=True, tick=3, height=333) as live:
            self.assertIn("height: 333px", live._repr_html_())
            self.assertIn(live.link, repr(live))
            self.assertTrue(self.listens(live.link))
        self.assertFalse(self.listens(live.link))
        live.close()
        self.assertIn("has ended", repr(live))
        # The recording lasts as long as its page, and the server as long as somebody has it.
        live = run.view(live=True)
        path, link = pathlib.Path(run.recording.path), live.link
        del run
        gc.collect()
        self.assertTrue(path.exists() and self.listens(link))
        del live
        gc.collect()
        self.until(lambda: not self.listens(link))

    def test_what_cannot_be_viewed_live_says_so(self):
        view = functools.partial(claymeld.view, self.folder / "p.meld", self.folder / "p.toml", meldsim=TOOLS.meldsim)
        self.assertRaisesRegex(claymeld.WorldError, "ends with tick", view, tick=10 ** 6)
        self.assertRaisesRegex(claymeld.WorldError, "fast", view, fast=True)
        self.assertRaises(claymeld.ProgramError, claymeld.view, "type p(node.\n", meldsim=TOOLS.meldsim)
        self.assertRaises(claymeld.ToolNotFound, claymeld.view, "p.meld", meldsim="/nowhere/meldsim")

    def test_a_run_is_viewed_without_a_notebook(self):
        run = self.run_here(predicates=["dist"])
        page = run.view(colour="dist(A, D)", every=2)
        text = self.page_in(page._repr_html_())
        page.save(self.folder / "saved.html")
        self.assertEqual((self.folder / "saved.html").read_text(), text)
        # It lasts as long as the page, whatever becomes of the run.
        path = pathlib.Path(page.path)
        del run
        self.assertTrue(path.exists())
        del page
        self.assertFalse(path.exists())

    def test_what_cannot_be_viewed_says_so(self):
        self.assertRaisesRegex(ValueError, "no recording of this run", self.run_here(record=False).view)
        run = self.run_here()
        self.assertRaisesRegex(claymeld.MeldsimError, "distance", run.view, colour="distance(A, D)")
        # Numbers that no page can make small.
        self.write("noise.meld", "type p(node, int).\np(A, (T * T * 7919 + I * I * 104729) % 1009) :- tick(A, T), id(A, I).\n")
        self.write("noise.toml", square(60))
        noise = claymeld.run(self.folder / "noise.meld", self.folder / "noise.toml", ticks=200, every=200, meldsim=TOOLS.meldsim)
        self.assertRaisesRegex(claymeld.LimitReached, "1 MB", noise.view, colour="p(A, N)", limit=1)

    def test_a_run_that_goes_on_is_seen_as_far_as_it_is(self):
        self.write("long.meld", "type p(node, int).\np(A, N) :- tick(A, N).\n")
        child = self.begin("meldsim", "run", "long.meld", "--world", "p.toml", "--quiet", "--record", "long.vtkhdf",
                           "--ticks", "1000000000")
        ends = []
        for _ in range(2):
            end = time.monotonic() + 20
            while True:
                try:
                    with claymeld.open(self.folder / "long.vtkhdf", meldsim=TOOLS.meldsim) as recording:
                        last = int(recording.ticks[-1])
                        if last > (ends[-1] if ends else 3):
                            page = recording.view(every=max(1, last // 5))
                            break
                except (FileNotFoundError, claymeld.RecordingError, IndexError):
                    pass
                self.assertLess(time.monotonic(), end)
                time.sleep(0.1)
            ends.append(last)
            self.assertTrue(self.page_in(page._repr_html_()).startswith("<!doctype html>"))
        self.assertIsNone(child.poll())
        child.kill()


if __name__ == "__main__":
    main("meldsim")
