"""The viewer's page in a browser: a run that is in the page, and one that a server holds.

    page_test.py --meldc PATH --meldsim PATH [unittest options]
"""
import pathlib
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "pictures"))

import numpy as np  # noqa: E402
from selenium import webdriver  # noqa: E402
from selenium.webdriver.chrome.service import Service  # noqa: E402
from selenium.webdriver.common.action_chains import ActionChains  # noqa: E402
from selenium.webdriver.common.by import By  # noqa: E402
from selenium.webdriver.common.keys import Keys  # noqa: E402

from frame import main  # noqa: E402
from png import read_png  # noqa: E402
from viewing import CORNER, Viewing  # noqa: E402

WIDTH, HEIGHT = 6, 4
PLATE = f'lattice = "square"\n[[body]]\nshape = "box({WIDTH},{HEIGHT},1)"\n[facts]\nsource = "id == 0"\n'
# The ends of viridis.
PURPLE, YELLOW = (0x44, 0x01, 0x54), (0xFD, 0xE7, 0x25)
FLAGS = ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--window-size=1100,720", "--hide-scrollbars",
         "--force-color-profile=srgb", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")


class Pages(Viewing):
    FILES = Viewing.FILES | {"plate.meld": CORNER, "plate.toml": PLATE}

    @classmethod
    def setUpClass(cls):
        options = webdriver.ChromeOptions()
        for flag in FLAGS:
            options.add_argument(flag)
        cls.browser = webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=options)
        cls.addClassCleanup(cls.browser.quit)
        super().setUpClass()

    def open(self, link):
        self.browser.get("about:blank")
        self.browser.get(link)
        self.wait(lambda: self.run_js("return document.body.dataset.ready"))

    def share(self, *options):
        self.call("meldsim", "view", "plate.meld", "--share", "a.html", "--quiet", *options)
        self.open((pathlib.Path(self.folder) / "a.html").as_uri())

    def run_js(self, text, *arguments):
        return self.browser.execute_script(text, *arguments)

    def wait(self, holds, seconds=15):
        end = time.monotonic() + seconds
        while not holds():
            self.assertLess(time.monotonic(), end, self.text("message") or "it takes too long")
            time.sleep(0.05)

    def text(self, name):
        found = self.browser.find_elements(By.ID, name)
        return found[0].text if found else ""

    def to(self, tick):
        self.run_js("return viewer.refresh(arguments[0])", tick)
        self.wait(lambda: self.run_js("return document.body.dataset.tick") == str(tick))

    def pixels(self):
        pictures = self.run_js("return Number(viewer.stage.element.dataset.pictures || 0)")
        self.run_js("viewer.stage.draw()")
        self.wait(lambda: self.run_js("return Number(viewer.stage.element.dataset.pictures || 0)") > pictures)
        return read_png(self.browser.find_element(By.CSS_SELECTOR, "#stage").screenshot_as_png)[:, :, :3].astype(int)

    def cell(self, pixels, x, y):
        """The colour of the middle of a cell, counted from the lower left, whatever the page believes where it is."""
        filled = (pixels < 235).any(axis=2)
        # The legend in the lower left corner is none of it.
        filled[-150:, :260] = False
        rows, columns = np.nonzero(filled.sum(axis=1) > 30)[0], np.nonzero(filled.sum(axis=0) > 30)[0]
        side = (columns[-1] - columns[0] + 1) / WIDTH
        self.assertAlmostEqual((rows[-1] - rows[0] + 1) / HEIGHT, side, delta=2, msg="the plate is not six by four")
        return pixels[int(rows[-1] - (y + 0.5) * side), int(columns[0] + (x + 0.5) * side)]

    def test_a_shared_run_has_its_colours_where_they_belong(self):
        self.share("--colour", "dist(A, D)", "--facts", "dist")
        self.to(self.run_js("return viewer.info.last"))
        pixels = self.pixels()
        corner, far = self.cell(pixels, 0, 0), self.cell(pixels, WIDTH - 1, HEIGHT - 1)
        self.assertLess(np.abs(corner - PURPLE).max(), 50, corner)
        self.assertLess(np.abs(far - YELLOW).max(), 50, far)
        for x in range(WIDTH):
            for y in range(HEIGHT):
                self.assertGreater(np.ptp(self.cell(pixels, x, y)), 40, f"no catom in cell {x}, {y}")
        # Catoms with the same distance look the same; along a row they become brighter.
        self.assertLess(np.abs(self.cell(pixels, 2, 0) - self.cell(pixels, 0, 2)).max(), 12)
        row = [self.cell(pixels, x, 0).sum() for x in range(WIDTH)]
        self.assertEqual(row, sorted(row))
        self.assertIn("0", self.text("legend"))

    def test_a_click_shows_the_facts_of_the_catom_at_that_tick(self):
        self.share("--colour", "dist(A, D)", "--facts", "dist")
        for tick, fact in ((8, ["dist(@0, 0)"]), (0, [])):
            self.to(tick)
            self.click(0)
            self.assertEqual(self.text("catom"), "Catom @0")
            self.assertEqual([e.text for e in self.browser.find_elements(By.CSS_SELECTOR, "#facts .fact")], fact)

    def click(self, catom):
        x, y = self.run_js("""const s = viewer.stage, i = s.frame.ids.indexOf(arguments[0]), p = s.frame.positions;
            const at = s.view.project(p[3 * i], p[3 * i + 1], p[3 * i + 2]);
            return [at.x - s.view.width / 2, at.y - s.view.pixels / 2];""",
                           catom)
        stage = self.browser.find_element(By.ID, "stage")
        ActionChains(self.browser).move_to_element_with_offset(stage, round(x), round(y)).click().perform()
        self.wait(lambda: self.text("catom"))

    def test_a_served_run_steps_and_answers_why(self):
        self.open(self.view("plate.meld"))
        self.assertEqual(self.text("tick"), "tick 0")
        self.browser.find_element(By.ID, "run").click()
        self.wait(lambda: self.text("tick") != "tick 0")
        field = self.browser.find_element(By.ID, "look-colour")
        field.send_keys("dsit(A, D)", Keys.ENTER)
        self.wait(lambda: "dsit" in " ".join(e.text for e in self.browser.find_elements(By.CSS_SELECTOR, "#look .mistake")))
        field.clear()
        field.send_keys("dist(A, D)", Keys.ENTER)
        self.wait(lambda: self.text("legend"))
        self.click(0)
        fact = self.browser.find_element(By.ID, "fact")
        fact.send_keys("dist(@0, 0)")
        self.browser.find_element(By.ID, "why").click()
        self.wait(lambda: "source(@0)" in self.text("why-tree"))
        # What is being written by hand stays while the run moves.
        fact.clear()
        fact.send_keys("source(@23)")
        self.browser.find_element(By.ID, "give").click()
        self.wait(lambda: "give source(@23)" in self.text("panel"))
        self.command("run")
        self.assertEqual(self.browser.find_element(By.ID, "fact").get_attribute("value"), "source(@23)")
        fact.clear()
        fact.send_keys("sorce(@23)")
        self.browser.find_element(By.ID, "give").click()
        self.wait(lambda: "did you mean `source`?" in self.text("panel"))
        self.interrupt()

    def enter(self, name, text):
        field = self.browser.find_element(By.ID, name)
        field.clear()
        field.send_keys(text, Keys.ENTER)

    def command(self, line):
        self.assertIsNone(self.browser.execute_script("return viewer.command(arguments[0])", line))

    def test_what_a_box_selects_is_killed_and_the_wave_goes_around_it(self):
        self.open(self.view("plate.meld"))
        self.enter("look-colour", "dist(A, D)")
        self.enter("until", "dist(A, 5)")
        self.wait(lambda: "dist(A, 5)" in self.text("state"))
        self.enter("until", "dsit(A)")
        self.wait(lambda: "did you mean `dist`?" in self.text("until-mistake"))
        self.command("run")
        # The column x = 1 but for its last catom.
        x0, y0, x1, y1 = self.run_js("""const s = viewer.stage, at = (x, y) => s.view.project(s.bounds.low[0] + x, s.bounds.low[1] + y, 0);
            const a = at(0.6, 2.5), b = at(1.4, -0.5);
            return [a.x, a.y, b.x, b.y].map((v, i) => Math.round(v - (i % 2 ? s.view.pixels : s.view.width) / 2));""")
        stage = self.browser.find_element(By.ID, "stage")
        ActionChains(self.browser, 0).key_down(Keys.CONTROL).move_to_element_with_offset(stage, x0, y0).click_and_hold() \
            .move_by_offset(x1 - x0, 0).move_by_offset(0, y1 - y0).release().key_up(Keys.CONTROL).perform()
        self.wait(lambda: "and 2 more" in self.text("catom"))
        self.browser.find_element(By.ID, "kill").click()
        self.wait(lambda: "They die in tick" in self.text("panel"))
        self.command("run")
        self.wait(lambda: self.text("about").startswith("21 catoms"))
        # The catom at (2, 0), once 2 steps from the source, is reached over the last catom of the column.
        far = self.run_js("const s = viewer.stage, f = s.frame, b = s.bounds.low;"
                          "return [...f.ids].find((id, i) => f.positions[3 * i] === b[0] + 2 && f.positions[3 * i + 1] === b[1])")
        self.enter("find", str(far))
        self.wait(lambda: f"dist(@{far}, 8)" in self.text("panel"))
        self.enter("find", "dist(A, 8)")
        self.wait(lambda: "catom" in self.text("found"))

    def test_a_server_draws_where_the_browser_cannot(self):
        self.open(self.view("plate.meld") + "#images")
        self.command("run")
        self.enter("look-colour", "dist(A, D)")
        self.wait(lambda: self.text("legend"))
        self.wait(lambda: np.abs(self.cell(self.pixels(), 0, 0) - PURPLE).max() < 60)
        self.assertLess(np.abs(self.cell(self.pixels(), WIDTH - 1, HEIGHT - 1) - YELLOW).max(), 60)

    def test_the_program_is_read_again_and_a_long_run_ends(self):
        self.open(self.view("forever.meld"))
        program = self.read("forever.meld").decode()
        self.write("forever.meld", program + "nonsense\n")
        self.wait(lambda: "goes on under its old rules" in self.text("notice"))
        self.assertIn("forever.meld:3:", self.text("notice"))
        self.write("forever.meld", program + "type new(node).\n")
        self.wait(lambda: "was read again" in self.text("notice"))
        self.wait(lambda: "new(A)" in self.run_js("return document.getElementById('bodies').innerHTML"))
        self.browser.find_element(By.ID, "run").click()
        stop = self.browser.find_element(By.ID, "interrupt")
        self.wait(stop.is_displayed)
        self.wait(lambda: "awake" in self.text("state"))
        stop.click()
        self.wait(lambda: self.text("state") == "interrupted")
        self.assertFalse(stop.is_displayed())

    def test_a_world_is_edited_seen_and_saved(self):
        self.open(self.view("plate.meld", "--world", "plate.toml"))
        self.browser.find_element(By.ID, "edit-world").click()
        self.wait(lambda: "24" in self.text("world-said"))
        area = self.browser.find_element(By.ID, "world-toml")
        self.assertEqual(area.get_attribute("value"), PLATE)
        save = self.browser.find_element(By.ID, "world-save")

        def write(toml):
            area.clear()
            area.send_keys(toml)

        write('lattice = "hex"\n[[body]]\nshape = "bax(5,5,1)"\n')
        self.wait(lambda: "Line 3, column 10" in self.text("world-said"))
        self.assertIn("did you mean 'box'?", self.text("world-said"))
        self.assertFalse(save.is_enabled())
        write(PLATE.replace("box(6,4,1)", "box(7,5,1)"))
        self.wait(lambda: "35" in self.text("world-said"))
        self.assertEqual(self.run_js("return viewer.stage.frame.count"), 35)
        save.click()
        self.wait(lambda: "is written" in self.text("world-saved"))
        self.assertIn("box(7,5,1)", self.read("plate.toml").decode())
        self.write("plate.toml", PLATE)
        self.browser.find_element(By.ID, "edit-world").click()
        self.wait(lambda: self.run_js("return viewer.stage.frame.count") == 24)

    def test_two_runs_are_side_by_side(self):
        self.write("half.meld", CORNER.replace("D + 1", "D + 2"))
        self.write("half.toml", PLATE)
        self.open(self.view("plate.meld", "half.meld"))
        self.enter("look-colour", "dist(A, D)")
        self.command("run")
        legend = "return viewer.sides[arguments[0]].element.querySelector('.legend').innerText"
        self.wait(lambda: "8" in self.run_js(legend, 0) and "16" in self.run_js(legend, 1))
        self.browser.find_element(By.ID, "stage-beside").click()
        self.wait(lambda: self.run_js("return viewer.active === viewer.sides[1] && viewer.sides[0].stage.selected.size === 0"))
        self.to(1)
        self.assertEqual(self.run_js("return viewer.sides.map((side) => side.words.tick)"), [1, 1])


if __name__ == "__main__":
    main("meldc", "meldsim")
