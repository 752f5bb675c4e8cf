"""Whether the viewer's page can be read: contrast of its text, and its layout, on narrow and wide screens, light and dark.

    read_test.py --meldc PATH --meldsim PATH [unittest options]

With CLAYMELD_SCREENSHOTS=FOLDER in the environment it keeps what it sees there.
"""
import os
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from selenium.webdriver.common.by import By  # noqa: E402

from contrast import LOOK  # noqa: E402
from frame import main  # noqa: E402
from pages import PLATE, Pages  # noqa: E402
from viewing import CORNER  # noqa: E402

SIZES = ((700, 900), (1440, 900), (3840, 2160))
KEPT = os.environ.get("CLAYMELD_SCREENSHOTS")


class Legible(Pages):
    def setUp(self):
        super().setUp()
        self.addCleanup(self.browser.set_window_size, 1100, 720)

    def everything(self, name, least, *words):
        """Looks at the page as it is, in all sizes, light and dark: there are so many texts and more, and these are among them."""
        for width, height in SIZES:
            self.browser.set_window_size(width, height)
            self.wait(lambda: self.run_js("return innerWidth") == width)
            for dark in (False, True):
                self.run_js("viewer.darken(arguments[0])", dark)
                seen = self.run_js(LOOK)
                self.assertEqual(seen["bad"], [], f"{name}, {width} pixels, {'dark' if dark else 'light'}")
                self.assertGreater(seen["checked"], least, name)
                for each in words:
                    self.assertTrue(any(each in text for text in seen["words"]), f"{name}: no {each} in {seen['words']}")
                self.assertLessEqual(self.run_js("return document.documentElement.scrollWidth"), width, name)
                if KEPT:
                    self.browser.save_screenshot(f"{KEPT}/{name}-{width}-{'dark' if dark else 'light'}.png")

    def test_text_that_cannot_be_read_is_noticed(self):
        self.share("--colour", "dist(A, D)")
        for style, count in (("#tick { color: #949494 !important; background: #fff }", 1), ("#tick { opacity: 0.3 }", 1),
                             (".legend { background: rgb(255 255 255 / 30%) !important }", 3)):
            self.run_js("""const s = document.createElement("style"); s.id = "worse"; s.textContent = arguments[0];
                document.head.append(s)""", style)
            self.assertGreaterEqual(len(self.run_js(LOOK)["bad"]), count, style)
            self.run_js("document.getElementById('worse').remove()")

    def test_a_run_can_be_read(self):
        # Where the server draws: software that draws for the browser takes long for millions of pixels.
        self.open(self.view("plate.meld") + "#images")
        self.command("run")
        self.enter("look-colour", "dist(A, D)")
        self.enter("look-only", "dsit(A)")
        self.enter("plot-body", "dist(A, D)")
        self.enter("plot-body", "dsit(A, D)")
        self.wait(lambda: self.text("plot-mistake") and self.text("look-only-mistake"))
        self.run_js("viewer.transport.bookmarks.toggle(viewer.words.tick)")
        self.click(0)
        self.run_js("viewer.panel.do('why', 'dist(@0, 0)')")
        self.wait(lambda: "source(@0)" in self.text("why-tree"))
        self.run_js("viewer.notice('The program was read again', 'one line', false)")
        # What belongs together stands in one row.
        for width, height in SIZES:
            self.browser.set_window_size(width, height)
            self.wait(lambda: self.run_js("return innerWidth") == width)
            middles = self.run_js("""return [...document.querySelector(".goal").childNodes].map((node) => {
                const range = document.createRange(); range.selectNode(node);
                const {top, bottom} = range.getBoundingClientRect();
                return (top + bottom) / 2;
            })""")
            self.assertEqual(len(middles), 3)
            self.assertLess(max(middles) - min(middles), 5, width)
        self.everything("run", 60, "D", "no predicate `dsit`", "⚑", "source(", "The program was read again", "cell", "42, or")

    def test_menus_keys_and_labels_can_be_read(self):
        self.open(self.view("plate.meld"))
        self.command("run")
        self.enter("look-labels", "dist(A, D)")
        self.wait(lambda: self.browser.find_elements(By.CSS_SELECTOR, "#stage .labels span"))
        self.point(0)
        menu = self.browser.find_element(By.CSS_SELECTOR, ".complete:has(#look-colour) .menu")
        for width, height in SIZES[:2]:
            self.browser.set_window_size(width, height)
            self.wait(lambda: self.run_js("return innerWidth") == width)
            for dark in (False, True):
                self.run_js("viewer.darken(arguments[0])", dark)
                menu.click()
                self.wait(lambda: self.offered())
                seen = self.run_js(LOOK)
                self.assertEqual(seen["bad"], [], f"{width}, {dark}")
                self.assertIn("neighbor(A, Other)", seen["words"])
                if KEPT:
                    self.browser.save_screenshot(f"{KEPT}/menu-{width}-{'dark' if dark else 'light'}.png")
                menu.click()
        self.run_js("document.getElementById('keys').showModal()")
        self.everything("keys", 40, "bookmark this tick", "Ctrl + drag")

    def test_two_runs_that_differ_can_be_read(self):
        self.write("half.meld", CORNER.replace("D + 1", "D + 2"))
        self.write("half.toml", PLATE)
        self.open(self.view("plate.meld", "half.meld"))
        self.command("run")
        self.enter("look-colour", "dist(A, D)")
        self.browser.find_element(By.ID, "look-difference").click()
        self.wait(lambda: "differ" in self.text("legend"))
        self.everything("two", 40, "half.meld", "D: second less first")

    def test_a_world_can_be_read(self):
        self.open(self.view("plate.meld", "--world", "plate.toml") + "#images")
        self.browser.find_element(By.ID, "edit-world").click()
        self.wait(lambda: "24" in self.text("world-said"))
        self.everything("world", 20, "memory", "lattice")
        area = self.browser.find_element(By.ID, "world-toml")
        area.clear()
        area.send_keys("nonsense")
        self.wait(lambda: "Line 1" in self.text("world-said"))
        self.everything("world-wrong", 10, "Line 1")

    def test_a_shared_run_can_be_read_also_without_graphics(self):
        for after in ("", "#images"):
            self.share("--colour", "dist(A, D)", "--facts", "dist", after=after)
            self.to(3)
            self.click(0)
            self.everything("shared" + after.strip("#"), 12, "Catom @0", "dist(")
        self.share("--colour", "dist(A, D)")
        self.run_js("viewer.stage.renderer.getContext().getExtension('WEBGL_lose_context').loseContext()")
        self.wait(lambda: self.browser.find_elements(By.CLASS_NAME, "lost"))
        self.everything("lost", 15, "lost its graphics")


if __name__ == "__main__":
    main("meldc", "meldsim")
