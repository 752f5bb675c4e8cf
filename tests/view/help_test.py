"""What the viewer's page does for whoever works with it: fields that complete, words at the pointer, plots, bookmarks, differences.

    help_test.py --meldc PATH --meldsim PATH [unittest options]
"""
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "pictures"))

import numpy as np  # noqa: E402
from selenium.webdriver.common.action_chains import ActionChains  # noqa: E402
from selenium.webdriver.common.by import By  # noqa: E402
from selenium.webdriver.common.keys import Keys  # noqa: E402

from frame import main  # noqa: E402
from pages import HEIGHT, PLATE, WIDTH, Pages  # noqa: E402
from png import read_png  # noqa: E402
from viewing import CORNER, YELLOW  # noqa: E402

# No other program of the tests, and no example of the docs, has such predicates.
ROOMS = """type warm(node, max float Degrees).
type wet(node).
type linear guest(node, node Host).
type rank(node, int).
warm(A, 20.5) :- id(A, 0).
warm(B, D - 1.0) :- neighbor(A, B), warm(A, D), D > 17.0.
wet(A) :- id(A, 3).
rank(A, 9007199254740993 + I) :- id(A, I).
"""
FIELDS = ("look-colour", "look-only", "look-hide", "look-links", "look-arrows", "look-labels", "until", "find", "plot-body", "fact")
STROLL = """type linear step(node, int).
step(@0, 0).
step(A, N), N < 4 -o moveTo(A, N + 1, 5, 0), step(A, N + 1)@+1.
"""
HERE = 'lattice = "square"\n[[body]]\ncells = [[0, 5], [9, 9]]\n[motion]\nkind = "lattice"\n'


class Helped(Pages):
    FILES = Pages.FILES | {"rooms.meld": ROOMS, "rooms.toml": PLATE.split("[facts]")[0], "stroll.meld": STROLL, "stroll.toml": HERE}

    def press(self, *keys):
        ActionChains(self.browser, 0).send_keys(*keys).perform()

    def value(self, name):
        return self.browser.find_element(By.ID, name).get_attribute("value")

    def menu(self, name):
        self.browser.find_element(By.CSS_SELECTOR, f".complete:has(#{name}) .menu").click()
        return self.offered()

    def test_fields_go_on_with_the_predicates_of_this_program(self):
        self.open(self.view("rooms.meld"))
        self.command("step 3")
        self.click(0)
        mine = ["guest(A, Host)", "rank(A, B)", "warm(A, Degrees)", "wet(A)"]
        for name in FIELDS:
            offered = self.menu(name)
            self.assertEqual(offered[:4], mine, name)
            self.assertIn("neighbor(A, Other)", offered[4:], name)
            # By the keys, and closed again without anything.
            self.press(Keys.ESCAPE)
            self.assertEqual(self.offered(), [])
            field = self.browser.find_element(By.ID, name)
            self.assertEqual(self.value(name), "")
            shown = field.get_attribute("placeholder")
            self.assertTrue(any(shown.endswith(re.sub(r"\(A\b", "(@0" if name == "fact" else "(A", body))
                                for body in [*mine, "neighbor(A, Other)"]), f"{name}: {shown}")
        # As it is written.
        field = self.browser.find_element(By.ID, "look-colour")
        field.click()
        self.press("w")
        self.assertEqual(self.offered(), ["warm(A, Degrees)", "wet(A)"])
        self.press("a")
        self.assertEqual(self.offered(), ["warm(A, Degrees)"])
        self.press(Keys.TAB)
        self.assertEqual(self.value("look-colour"), "warm(A, Degrees)")
        self.wait(lambda: "Degrees" in self.text("legend"))
        self.press(", ran")
        self.assertEqual(self.offered(), ["rank(A, B)"])
        self.press(Keys.ARROW_DOWN, Keys.ENTER)
        self.assertEqual(self.value("look-colour"), "warm(A, Degrees), rank(A, B)")
        # Variables and catoms are no names of predicates, and what is there already is no reason to ask.
        for letters in (", W", ", w(", " @1"):
            field.clear()
            self.press(letters)
            self.assertEqual(self.offered(), [], letters)
        # By the pointer; it is shown at once.
        field.clear()
        self.menu("look-only")
        self.browser.find_element(By.CSS_SELECTOR, ".completions:not([hidden]) li:nth-child(4)").click()
        self.wait(lambda: self.run_js("return viewer.words.shown") == 1)
        self.assertEqual(self.value("look-only"), "wet(A)")
        # A fact is about the catom that is selected.
        self.menu("fact")
        self.browser.find_element(By.CSS_SELECTOR, ".completions:not([hidden]) li:nth-child(3)").click()
        self.assertEqual(self.value("fact"), "warm(@0, Degrees)")
        # What is wrong is explained with this program too.
        for field, example in (("colour", "rank(A, B)"), ("links", "guest(A, Host)")):
            self.enter(f"look-{field}", "1 = 1")
            self.wait(lambda: f"Write it as in {example}" in self.text(f"look-{field}-mistake"))
        self.browser.find_element(By.ID, "go-until").click()
        self.wait(lambda: "As in wet(A)" in self.text("until-mistake"))
        self.enter("find", "1 = 1")
        self.wait(lambda: "Write it as in wet(A)" in self.text("found"))
        page = self.run_js("return document.body.innerText + [...document.querySelectorAll('input')].map((e) => e.placeholder)")
        for other in ("dist", "leader", "parent", "--only", "--links"):
            self.assertNotIn(other, page)

    def test_the_pointer_says_which_catom_and_what_colour(self):
        self.open(self.view("rooms.meld"))
        self.command("run")
        for colour, says in (("warm(A, Degrees)", {0: "@0 Degrees = 20.5", 1: "@1 Degrees = 19.5", 23: "@23 no Degrees"}),
                             ("wet(A)", {3: "@3 wet(A)", 0: "@0 no wet(A)"}),
                             # More digits than a number of a page has.
                             ("rank(A, N)", {0: "@0 N = 9007199254740993", 3: "@3 N = 9,007,199,254,740,996"}),
                             ("", {0: "@0"})):
            self.enter("look-colour", colour)
            self.wait(lambda: bool(self.text("legend")) == bool(colour))
            for catom, words in says.items():
                self.assertEqual(self.point(catom), words)
        stage = self.browser.find_element(By.ID, "stage")
        ActionChains(self.browser, 0).move_to_element_with_offset(stage, 4 - stage.size["width"] // 2, 0).perform()
        self.wait(lambda: not self.browser.find_element(By.CSS_SELECTOR, "#stage .tip").is_displayed())
        # A page without a server says the same.
        for colour, words in (("warm(A, Degrees)", "@1 Degrees = 19.5"), ("wet(A)", "@1 no wet(A)")):
            self.share("--colour", colour, program="rooms.meld")
            self.to(self.run_js("return viewer.info.last"))
            self.assertEqual(self.point(1), words)

    def lines(self):
        """Of each line of the plot its number at this tick."""
        return dict(self.run_js("""return [...document.querySelectorAll('#lines .chip')].map((e) =>
            [(e.querySelector('code') || e.childNodes[1]).textContent, e.querySelector('.now').textContent])"""))

    def test_bodies_are_plotted_over_time(self):
        self.open(self.view("plate.meld"))
        self.command("run")
        self.wait(lambda: self.lines() == {"evaluated": "0"})
        bodies = {"dist(A, D)": [0, 1, 3, 6, 10], "max D : { dist(A, D) }": [None, 0, 1, 2, 3], "dist(@23, D)": [None] * 5,
                  "source(@0)": [1] * 5}
        for body in bodies:
            self.enter("plot-body", body)
        self.run_js("const s = document.getElementById('series'); s.value = 'changes'; s.dispatchEvent(new Event('change'))")
        known = "return viewer.transport.plot.lines.every(({done}) => done) ? viewer.transport.plot.lines : null"
        self.wait(lambda: self.run_js(known))
        # After the first five ticks, at the end, and then where the run is.
        found = {line["name"]: line["values"] for line in self.run_js(known)}
        self.assertEqual({body: found[body][:5] for body in bodies}, bodies)
        self.assertEqual(self.lines(), {"evaluated": "0", "dist(A, D)": "24", "max D : { dist(A, D) }": "8", "dist(@23, D)": "6",
                                        "source(@0)": "1", "changes": "0"})
        self.to(3)
        self.wait(lambda: self.lines()["dist(A, D)"] == "6")
        self.assertEqual((self.lines()["max D : { dist(A, D) }"], self.lines()["dist(@23, D)"]), ("2", "–"))
        # Each has a colour of its own; those that no other one lies over are seen.
        drawn = """const {canvas, lines} = viewer.transport.plot, data = canvas.getContext('2d').getImageData(0, 0, canvas.width,
            canvas.height).data;
            const has = (css) => {
                const rgb = [1, 3, 5].map((at) => parseInt(css.slice(at, at + 2), 16));
                const is = (i) => data[i + 3] > 200 && rgb.every((c, j) => Math.abs(c - data[i + j]) < 12);
                for (let i = 0; i < data.length; i += 4) if (is(i)) return true;
                return false;
            };
            const ink = (colour) => getComputedStyle(canvas).getPropertyValue(`--plot${colour}`).trim();
            return lines.map(({name, colour}) => [name, colour, has(ink(colour))])"""
        seen = self.run_js(drawn)
        self.assertEqual(len({colour for _, colour, _ in seen}), 6)
        self.assertLessEqual({"dist(A, D)", "max D : { dist(A, D) }", "changes"}, {name for name, _, is_there in seen if is_there})
        # What is done by hand is in it, in the same run.
        self.command("to 8")
        self.command("give source(@23)")
        self.command("run")
        answer = self.run_js("return viewer.source.command('query N = max D : { dist(A, D) }')")["answer"]
        self.assertLess(answer["rows"][0][0], 8)
        self.wait(lambda: self.lines()["max D : { dist(A, D) }"] == str(answer["rows"][0][0]))
        # No line for what is wrong, or no number; the others stay.
        for body, says in (("dsit(A, D)", "did you mean `dist`?"), ("dist(_, D)", "Aggregate them")):
            self.enter("plot-body", body)
            self.wait(lambda: says in self.text("plot-mistake"))
            self.assertEqual(self.value("plot-body"), body)
            self.assertEqual(len(self.lines()), 6)
        self.browser.find_element(By.CSS_SELECTOR, "#lines [aria-label='Plot evaluated no more']").click()
        self.assertNotIn("evaluated", self.lines())

    def test_ticks_have_bookmarks(self):
        def marks():
            return [e.text for e in self.browser.find_elements(By.CSS_SELECTOR, "#bookmarks .chip button:first-child")]

        link = self.view("plate.meld")
        self.open(link)
        for tick in (5, 2, 7):
            self.to(tick)
            self.press("m") if tick == 2 else self.browser.find_element(By.ID, "bookmark").click()
        self.assertEqual(marks(), ["⚑ 2", "⚑ 5", "⚑ 7"])
        self.run_js("document.activeElement.blur()")
        for key, tick in (("[", 5), ("[", 2), ("[", 2), ("]", 5)):
            self.press(key)
            self.wait(lambda: self.text("tick") == f"tick {tick}")
        self.browser.find_element(By.CSS_SELECTOR, "#bookmarks .chip:nth-child(3) button").click()
        self.wait(lambda: self.text("tick") == "tick 7")
        # When the page is loaded again they are there; those of a run of another viewer are not.
        self.browser.refresh()
        self.wait(lambda: self.run_js("return document.body.dataset.ready"))
        self.assertEqual(marks(), ["⚑ 2", "⚑ 5", "⚑ 7"])
        self.browser.find_element(By.CSS_SELECTOR, "[aria-label='Forget the bookmark of tick 5']").click()
        self.assertEqual(marks(), ["⚑ 2", "⚑ 7"])
        self.open(self.view("plate.meld"))
        self.assertEqual(marks(), [])
        # Without a server too.
        self.share("--colour", "dist(A, D)")
        self.to(4)
        self.press("m")
        self.assertEqual(marks(), ["⚑ 4"])

    def test_a_selection_stays_with_its_catoms(self):
        self.open(self.view("stroll.meld"))
        self.click(0)
        self.wait(lambda: "(0, 5, 0)" in self.text("panel"))
        where = "const s = viewer.stage, f = s.frame; return s.marked.map((i) => [f.ids[i], f.positions[3 * i]])"
        start, seen = self.run_js(where)[0][1], set()
        for tick in (1, 2, 5, 4, 3, 0):
            self.to(tick)
            x = self.run_js("return viewer.source.command('query cell(@0, X, _, _)').then(({answer}) => answer.rows[0][0])")
            self.wait(lambda: f"({x}, 5, 0)" in self.text("panel"))
            self.assertEqual((self.run_js(where), self.text("catom")), ([[0, start + x]], "Catom @0"))
            seen.add(x)
        self.assertGreater(len(seen), 3)
        # Who is hidden, or is no more, is selected still.
        self.enter("look-hide", "id(A, 0)")
        self.wait(lambda: self.run_js("return viewer.stage.frame.count") == 1)
        self.assertEqual((self.run_js(where), self.text("catom")), ([], "Catom @0"))
        self.enter("look-hide", "")
        self.wait(lambda: self.run_js(where) == [[0, start]])
        self.browser.find_element(By.ID, "kill").click()
        self.wait(lambda: "It happens in tick" in self.text("panel"))
        self.command("step")
        self.wait(lambda: self.run_js("return viewer.stage.frame.count") == 1)
        self.assertEqual(self.run_js(where), [])
        self.to(0)
        self.assertEqual((self.run_js(where), self.text("catom")), ([[0, start]], "Catom @0"))

    def test_two_runs_are_compared(self):
        self.write("half.meld", CORNER.replace("D + 1", "D + 2"))
        self.write("half.toml", PLATE.replace(f"box({WIDTH},{HEIGHT},1)", f"box({WIDTH},{HEIGHT + 1},1)"))
        self.open(self.view("plate.meld", "half.meld"))
        self.enter("look-colour", "dist(A, D)")
        self.command("run")
        self.browser.find_element(By.ID, "look-difference").click()
        legend = "return viewer.sides.map((side) => side.element.querySelector('.legend').innerText)"
        self.wait(lambda: "differ" in self.run_js(legend)[0])
        first, second = self.run_js(legend)
        self.assertEqual(first, second)
        # Numbers of catoms are by their places, so the row more changes them; the first row has the same in both.
        both = self.run_js("""return viewer.sides.map(({stage: {frame}}) => [...frame.ids].map((id, i) =>
            [id, frame.valueOf(i), [...frame.colours.subarray(4 * i, 4 * i + 3)]]))""")
        values = [{id: value for id, value, _ in side} for side in both]
        common = sorted(values[0].keys() & values[1].keys())
        apart = {id: values[1][id] - values[0][id] for id in common}
        most = max(map(abs, apart.values()))
        self.assertIn(f"{sum(d != 0 for d in apart.values())} of {len(common)} differ", first)
        self.assertIn(f"-{most:.0f}", first)
        self.assertIn("only in one run", first)
        for side in both:
            for id, _, colour in side:
                if id not in apart:
                    self.assertEqual(colour, [0x7E, 0x22, 0xCE], id)
                elif apart[id] == 0:
                    self.assertEqual(colour, [0xDD, 0xDD, 0xDD], id)
                elif apart[id] == most:
                    self.assertEqual(colour, [0xB4, 0x04, 0x26], id)
                else:
                    self.assertEqual(colour[0] > colour[2], apart[id] > 0, (id, apart[id], colour))
        far = max(apart, key=apart.get)
        self.assertIn(f"@{far} D = {values[0][far]:.0f}, +{most:.0f} in the second run", self.point(far))
        # Words are the same or not; without a body the catoms' own colours are compared.
        self.enter("look-colour", "source(A)")
        self.wait(lambda: f"0 of {len(common)} differ" in self.run_js(legend)[0])
        self.enter("look-colour", "")
        self.wait(lambda: "colour:" in self.run_js(legend)[0])
        self.browser.find_element(By.ID, "look-difference").click()
        self.wait(lambda: self.run_js(legend) == ["", ""])

    def test_two_runs_are_compared_also_where_the_server_draws(self):
        """Which knows nothing of the other run: the page draws while differences are shown, and the server before and after."""
        self.write("half.meld", CORNER.replace("D + 1", "D + 2"))
        self.write("half.toml", PLATE)
        self.open(self.view("plate.meld", "half.meld") + "#images")
        self.enter("look-colour", "dist(A, D)")
        self.command("run")
        images = "return viewer.sides.map(({stage}) => stage.element.classList.contains('images'))"
        self.wait(lambda: self.run_js(images) == [True, True])
        for _ in range(2):
            self.browser.find_element(By.ID, "look-difference").click()
            self.wait(lambda: self.run_js(images) == [False, False])
            self.wait(lambda: "differ" in self.text("legend"))
            for element in ("stage", "stage-beside"):
                # Of the corner, which is as far in both runs, and of the catom that is farthest apart.
                self.wait(lambda: self.painted(element, (0xDD, 0xDD, 0xDD)) > 100 and self.painted(element, (0xB4, 0x04, 0x26)) > 100)
            self.browser.find_element(By.ID, "look-difference").click()
            self.wait(lambda: self.run_js(images) == [True, True])
            self.wait(lambda: self.painted("stage", YELLOW) > 100)

    def painted(self, element, colour):
        """How many pixels have this colour, or nearly."""
        picture = read_png(self.browser.find_element(By.ID, element).screenshot_as_png)[:, :, :3].astype(int)
        return int((np.abs(picture - np.array(colour)).max(axis=2) < 12).sum())


if __name__ == "__main__":
    main("meldc", "meldsim")
