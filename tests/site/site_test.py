"""The documentation as a site: all its pages without a warning, links that lead somewhere, and runs that can be turned and played.

    site_test.py --build FOLDER [unittest options]
"""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests"), str(ROOT / "docs" / "site")]

import check  # noqa: E402
import commands  # noqa: E402
import examples  # noqa: E402
import make  # noqa: E402
from frame import TOOLS, main  # noqa: E402

FLAGS = ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--hide-scrollbars", "--force-color-profile=srgb",
         "--allow-file-access-from-files", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
# Pages of every kind, which may not be wider than a narrow window.
KINDS = ("index", "tour", "gallery", "benchmarks", "reference/worlds", "lab/gradient", "manual/meldsim", "examples/heat", "changes")


def make_site(*arguments, python=("/usr/bin/python3", "-B")):
    command = [*python, ROOT / "docs/site/make.py", "--bin", pathlib.Path(TOOLS.build, "bin"), *arguments]
    return subprocess.run(command, capture_output=True, text=True)


class Checks(unittest.TestCase):
    def test_links_that_lead_nowhere_are_found(self):
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            (folder / "below").mkdir()
            (folder / "a.html").write_text('<h1 id="top"></h1><a href="below/b.html#here"></a><a href="#top"></a>'
                                           '<a href="https://x.org"></a>')
            (folder / "below/b.html").write_text('<p id="here"></p><img src="../p.png"><a href="../a.html#bottom"></a>'
                                                 '<a href="c.html"></a>')
            self.assertEqual(check.problems(folder), ["below/b.html: a link to ../p.png, which does not exist",
                                                      "below/b.html: a link to ../a.html#bottom, where no such place is",
                                                      "below/b.html: a link to c.html, which does not exist"])

    def test_manual_pages_become_pages(self):
        roff = '.TH P 1\n.SH NAME\np \\- does\n.SH SYNOPSIS\n.B p run\n.br\n.SH COMMANDS\n.SS p run X_*\nRuns.\n.PP\n.nf\n' \
               'p run \\-n 2\n.fi\n.TP\n\\fB\\-n\\fR, \\fB\\-\\-number\\fR \\fIINT\\fR\nHow [many]\n'
        self.assertEqual([line for line in commands.page("p", roff).splitlines() if line],
                         ["# p(1)", "## Commands", "### p run X\\_\\*", "Runs.", "```text", "p run -n 2", "```",
                          "`-n`, `--number INT`", ": How \\[many\\]"])

    def test_what_is_missing_is_said(self):
        # Without the folders where Debian's packages are.
        done = make_site("--out", "/nowhere", python=("/usr/bin/python3", "-B", "-S"))
        self.assertEqual((done.returncode, done.stderr.count("scripts/install site")), (2, 1), done.stderr)
        if not make.lacking():
            done = make_site("--out", "/nowhere", "--runs", "nobody")
            self.assertEqual((done.returncode, done.stderr.count("called nobody")), (2, 1), done.stderr)


@unittest.skipIf(make.lacking(), f"the site cannot be made without {', '.join(make.lacking())}: scripts/install site")
class Site(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        from selenium import webdriver
        from selenium.webdriver.chrome.service import Service
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="meld site "))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        done = make_site("--out", cls.folder)
        if done.returncode != 0:
            raise AssertionError(done.stdout + done.stderr)
        options = webdriver.ChromeOptions()
        for flag in FLAGS:
            options.add_argument(flag)
        cls.browser = webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=options)
        cls.addClassCleanup(cls.browser.quit)

    def open(self, page, width=1440):
        self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                                     {"width": width, "height": 1000, "deviceScaleFactor": 1, "mobile": False})
        self.browser.get((self.folder / "html").as_uri() + "/" + page)

    def wait(self, holds, seconds=20):
        end = time.monotonic() + seconds
        while not holds():
            self.assertLess(time.monotonic(), end, "it takes too long")
            time.sleep(0.05)

    def test_every_example_has_its_run(self):
        for example in examples.of_gallery():
            page = (self.folder / "html" / "examples" / f"{example.program}.html").read_text()
            self.assertIn(f'<iframe class="run" src="../runs/{example.name}.html"', page)
            self.assertTrue((self.folder / "html" / "runs" / f"{example.name}.html").exists())
        gallery = (self.folder / "html" / "gallery.html").read_text()
        self.assertEqual(len(re.findall(r'<a class="reference internal(?: image-reference)?" href="examples/\w+\.html"><img', gallery)),
                         len(examples.of_gallery()))
        self.assertIn("<video", gallery)

    def test_a_reader_turns_and_scrubs_a_run_in_the_page(self):
        from selenium.webdriver.common.action_chains import ActionChains
        from selenium.webdriver.common.by import By
        from selenium.webdriver.common.keys import Keys
        self.open("examples/gradient.html")
        frame = self.browser.find_element(By.CSS_SELECTOR, "iframe.run")
        self.browser.execute_script("arguments[0].scrollIntoView()", frame)
        self.browser.switch_to.frame(frame)
        data = "return document.body.dataset."
        self.wait(lambda: self.browser.execute_script(data + "ready"))
        stage = self.browser.find_element(By.CSS_SELECTOR, "#stage")
        pictures = [stage.screenshot_as_png]
        ActionChains(self.browser).drag_and_drop_by_offset(stage, 90, 40).perform()
        self.wait(lambda: stage.screenshot_as_png != pictures[0])
        time.sleep(0.5)  # It may still turn on.
        pictures.append(stage.screenshot_as_png)
        begun = int(self.browser.execute_script(data + "tick"))
        slider = self.browser.find_element(By.CSS_SELECTOR, "#scrub")
        ActionChains(self.browser).click(slider).send_keys(Keys.ARROW_RIGHT).perform()
        self.wait(lambda: int(self.browser.execute_script(data + "tick")) > begun + 10)
        self.wait(lambda: stage.screenshot_as_png != pictures[1])

    def test_the_search_finds_words(self):
        from selenium.webdriver.common.by import By
        self.open("search.html?q=quarantine")
        found = "#search-results li a"
        self.wait(lambda: self.browser.find_elements(By.CSS_SELECTOR, found))
        links = {link.get_attribute("href").split("/html/")[1].split("?")[0].split("#")[0]
                 for link in self.browser.find_elements(By.CSS_SELECTOR, found)}
        self.assertIn("design.html", links)

    def test_the_pages_to_read_come_first_and_in_order(self):
        page = (ROOT / "docs" / "index.md").read_text()
        wanted = re.findall(r"^\d+\. \[.*?\]\((\w+)\.md\)", page, re.MULTILINE)
        self.assertGreater(len(wanted), 8)
        side = (self.folder / "html" / "index.html").read_text().split('class="sidebar-tree"')[1]
        self.assertEqual(re.findall(r'href="([\w/]+)\.html"', side)[:len(wanted)], wanted)
        for page, after in zip(wanted, wanted[1:]):
            self.assertRegex((self.folder / "html" / f"{page}.html").read_text(), f'class="next-page" href="{after}.html"')

    def test_pages_are_dark_where_the_browser_is(self):
        for scheme, dark in (("light", False), ("dark", True)):
            self.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": scheme}]})
            self.open("tour.html")
            colours = self.browser.execute_script("""return [getComputedStyle(document.body).backgroundColor,
                getComputedStyle(document.body).color, document.documentElement.classList.contains("no-js")]""")
            background, text = (sum(map(int, re.findall(r"\d+", colour)[:3])) for colour in colours[:2])
            self.assertEqual(background < 150 and text > 450, dark, colours)
            self.assertEqual(background > 600 and text < 150, not dark, colours)
            self.assertFalse(colours[2], "the theme's script does not run")

    def test_no_page_is_wider_than_its_window(self):
        for page in KINDS:
            for width in (700, 1440):
                self.open(page + ".html", width)
                wide = self.browser.execute_script("return document.documentElement.scrollWidth")
                self.assertLessEqual(wide, width, page)

    def test_guides_are_manual_pages_too(self):
        pages = sorted((self.folder / "man").iterdir())
        self.assertIn("claymeld-language.7", [page.name for page in pages])
        for page in pages:
            self.assertGreater(page.read_text().count("\n.SH "), 2, page)


if __name__ == "__main__":
    main("build")
