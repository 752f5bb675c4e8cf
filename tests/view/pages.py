"""The viewer's page in a browser, as tests of it see it: opened, clicked, written into, and looked at."""
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

from png import read_png  # noqa: E402
from stairs import FILES as STAIRS  # noqa: E402
from viewing import CORNER, Viewing  # noqa: E402

WIDTH, HEIGHT = 6, 4
PLATE = f'lattice = "square"\n[[body]]\nshape = "box({WIDTH},{HEIGHT},1)"\n[facts]\nsource = "id == 0"\n'
FLAGS = ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--window-size=1100,720", "--hide-scrollbars",
         "--force-color-profile=srgb", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")


class Pages(Viewing):
    FILES = Viewing.FILES | STAIRS | {"plate.meld": CORNER, "plate.toml": PLATE}

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

    def share(self, *options, program="plate.meld", after=""):
        self.call("meldsim", "view", program, "--share", "a.html", "--quiet", *options)
        self.open((pathlib.Path(self.folder) / "a.html").as_uri() + after)

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

    def click(self, catom):
        x, y = self.run_js("""const s = viewer.stage, i = s.frame.ids.indexOf(arguments[0]), p = s.frame.positions;
            const at = s.view.project(p[3 * i], p[3 * i + 1], p[3 * i + 2]);
            return [at.x - s.view.width / 2, at.y - s.view.pixels / 2];""",
                           catom)
        stage = self.browser.find_element(By.ID, "stage")
        ActionChains(self.browser).move_to_element_with_offset(stage, round(x), round(y)).click().perform()
        self.wait(lambda: self.text("catom"))

    def enter(self, name, text):
        field = self.browser.find_element(By.ID, name)
        field.clear()
        field.send_keys(text, Keys.ENTER)

    def command(self, line):
        self.assertIsNone(self.browser.execute_script("return viewer.command(arguments[0])", line))

    def offered(self):
        """What the field that is written into can go on with."""
        return self.run_js("return [...document.querySelectorAll('.completions:not([hidden]) li')].map((e) => e.innerText)")

    def point(self, catom):
        """Puts the pointer over a catom; returns what is said of it."""
        x, y = self.run_js("""const s = viewer.stage, i = s.frame.ids.indexOf(arguments[0]), p = s.frame.positions;
            const at = s.view.project(p[3 * i], p[3 * i + 1], p[3 * i + 2]);
            return [at.x - s.view.width / 2, at.y - s.view.pixels / 2];""", catom)
        stage = self.browser.find_element(By.CSS_SELECTOR, "#stage")
        ActionChains(self.browser, 0).move_to_element_with_offset(stage, round(x), round(y)).perform()
        tip = self.browser.find_element(By.CSS_SELECTOR, "#stage .tip")
        self.wait(lambda: tip.is_displayed() and tip.get_attribute("data-of") == str(catom))
        return tip.text
