"""The viewer's page in a browser: a run that is in the page, and one that a server holds.

    page_test.py --meldc PATH --meldsim PATH [unittest options]
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
from judge import judge  # noqa: E402
from pages import HEIGHT, PLATE, WIDTH, Pages  # noqa: E402
from stairs import COLOURS, PLACES  # noqa: E402
from viewing import CORNER, PURPLE, YELLOW  # noqa: E402


class Seen(Pages):
    """What everybody does with a page."""

    def test_a_shared_run_of_many_catoms_goes_back(self):
        """The page keeps some of its states, and makes the others again."""
        self.write("walk.meld", "type linear token(node).\ntoken(@0).\ntoken(A), neighbor(A, B), B > A -o token(B).\n")
        self.write("walk.toml", 'lattice = "cubic"\n[[body]]\nshape = "box(60, 60, 40)"\n')
        self.share("--colour", "token(A)", "--ticks", "60", program="walk.meld")
        self.assertLess((pathlib.Path(self.folder) / "a.html").stat().st_size, 2_000_000)
        last = self.run_js("return viewer.info.last")
        self.assertGreater(last, 45)
        for tick in (last, last - 1, 5, 6, 40, 0, last):
            self.to(tick)
            self.call("meldsim", "run", "walk.meld", "--ticks", tick, "--quiet", "--facts-out", "f") if tick > 0 else self.write("f", "")
            wanted = [int(number) for number in re.findall(r"token\(@(\d+)\)", self.read("f").decode())]
            orange = self.run_js("const s = viewer.source.shown; return [...s.ids].filter((_, i) => s.colours[4 * i] === 0xe6)")
            self.assertEqual(orange, wanted, tick)

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

    def test_the_first_picture_waits_for_nothing_else(self):
        added = self.browser.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": """
            window.done = [];
            const send = WebSocket.prototype.send;
            WebSocket.prototype.send = function (text) {
                if (!window.done.length) this.addEventListener("message", () => window.done.push("answer"));
                window.done.push(JSON.parse(text).do);
                return send.call(this, text);
            };
            for (const name of ["drawArrays", "drawElements"]) {
                const draw = WebGL2RenderingContext.prototype[name];
                WebGL2RenderingContext.prototype[name] = function (...all) {
                    window.done.push("draw");
                    return draw.apply(this, all);
                };
            }"""})
        self.addCleanup(self.browser.execute_cdp_cmd, "Page.removeScriptToEvaluateOnNewDocument", added)
        self.open(self.view("plate.meld"))
        self.wait(lambda: self.run_js("return viewer.stage.element.dataset.first"))
        done = self.run_js("return window.done")
        # All is asked for before anything is answered, and nothing is drawn before there are catoms: two texts and bytes, or more.
        self.assertEqual(sorted(done[:3]), ["frame", "hello", "hello"])
        self.assertEqual(done[3], "answer")
        self.assertIn("draw", done)
        self.assertGreaterEqual(done[:done.index("draw")].count("answer"), 3)
        self.assertEqual(done[:done.index("draw")].count("frame"), 1)
        self.assertEqual(self.run_js("return viewer.stage.frame.count"), WIDTH * HEIGHT)

    def test_a_click_shows_the_facts_of_the_catom_at_that_tick(self):
        self.share("--colour", "dist(A, D)", "--facts", "dist")
        for tick, fact in ((8, ["dist(@0, 0)"]), (0, [])):
            self.to(tick)
            self.click(0)
            self.assertEqual(self.text("catom"), "Catom @0")
            self.assertEqual([e.text for e in self.browser.find_elements(By.CSS_SELECTOR, "#facts .fact")], fact)

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
        self.wait(lambda: "It happens in tick" in self.text("panel"))
        self.command("run")
        self.wait(lambda: self.text("about").startswith("21 catoms"))
        # The catom at (2, 0), once 2 steps from the source, is reached over the last catom of the column.
        far = self.run_js("const s = viewer.stage, f = s.frame, b = s.bounds.low;"
                          "return [...f.ids].find((id, i) => f.positions[3 * i] === b[0] + 2 && f.positions[3 * i + 1] === b[1])")
        self.enter("find", str(far))
        self.wait(lambda: f"dist(@{far}, 8)" in self.text("panel"))
        self.enter("find", "dist(A, 8)")
        self.wait(lambda: "catom" in self.text("found"))


class Drawn(Pages):
    """Its pictures, by whatever draws them."""

    def stairs(self, *options):
        """The picture of catoms that look different from all sides, seen with parallel rays and without a legend."""
        self.share("--colour", "value(A, N)", *options, program="stairs.meld")
        self.to(self.run_js("return viewer.info.last"))
        self.run_js("viewer.stage.view.angle = 0; document.getElementById('legend').hidden = true; viewer.stage.fit()")
        return self.pixels()

    def test_balls_are_as_they_should_be_and_mistakes_would_be_noticed(self):
        pixels = self.stairs()
        self.assertEqual(judge(pixels, PLACES, COLOURS), [])
        self.assertNotEqual(judge(pixels[:, ::-1], PLACES, COLOURS), [], "mirrored")
        for order in ((1, 0, 2), (0, 2, 1), (2, 1, 0)):
            self.assertNotEqual(judge(pixels, PLACES[:, order], COLOURS), [], order)
        self.assertGreater(len(judge(self.stairs("--map", "cividis"), PLACES, COLOURS)), 5)
        x, y, z = (int(c) for c in PLACES[11])
        self.assertNotEqual(judge(self.stairs("--hide", f"cell(A, {x}, {y}, {z})"), PLACES, COLOURS), [], "one is missing")

    def test_a_shared_run_is_seen_without_webgl(self):
        self.share("--colour", "dist(A, D)", after="#images")
        self.to(self.run_js("return viewer.info.last"))
        pixels = self.pixels()
        self.assertLess(np.abs(self.cell(pixels, 0, 0) - PURPLE).max(), 40)
        self.assertLess(np.abs(self.cell(pixels, WIDTH - 1, HEIGHT - 1) - YELLOW).max(), 40)
        self.click(0)
        self.assertEqual(self.text("catom"), "Catom @0")

    def test_forms_are_drawn(self):
        for form in ("sphere", "cube", "rounded", "disc", "hexagon"):
            self.share("--colour", "dist(A, D)", "--form", form)
            self.to(self.run_js("return viewer.info.last"))
            self.assertLess(np.abs(self.cell(self.pixels(), 0, 0) - PURPLE).max(), 50, form)

    def test_shapes_are_drawn_as_they_are_turned(self):
        """A tall box seen from the front, and the same lying on its side, which a ball would not tell apart: served, shared, and without
        graphics."""
        self.write("box.meld", "setColor(A, 220, 30, 20) :- position(A, _, _, _).\n")
        for turned, tall in (([0, 0, 0], True), ([0, 90, 0], False)):
            self.write("box.toml", f"""[[body]]
positions = [[0, 0, 2], [0, 20, 0.5]]
[motion]
kind = "bodies"
ground = 0
shape = "box"
edges = [1, 1, 4]
rounding = 0.1
[[motion.catoms]]
where = "id == 0"
turned = {turned}
[[motion.catoms]]
where = "id == 1"
shape = "sphere"
""")
            for how in ("served", "served #images", "shared", "shared #images"):
                with self.subTest(how=how, tall=tall):
                    after = how.partition(" ")[2]
                    if how.startswith("served"):
                        self.open(self.view("box.meld") + after)
                        self.command("to 2")
                        self.enter("look-only", "position(A, _, Y, _), Y < 9.0")
                        self.wait(lambda: self.run_js("return viewer.stage.frame.count") == 1)
                    else:
                        self.share("--only", "position(A, _, Y, _), Y < 9.0", "--ticks", "2", program="box.meld", after=after)
                        self.to(2)
                    self.run_js("const {stage} = viewer; Object.assign(stage.view, {azimuth: -90, elevation: 0, angle: 0, height: 4});"
                                "stage.view.update(); stage.draw()")
                    # A server's picture may be an earlier one.
                    self.wait(lambda: abs(self.slenderness() / (4 if tall else 0.25) - 1) < 0.1)

    def test_obstacles_and_the_floor_are_seen_without_webgl(self):
        self.write("ball.meld", "setColor(A, 30, 30, 220) :- position(A, _, _, _).\n")
        self.write("ball.toml", '[[body]]\npositions = [[-2, 0, 0.5], [2, 0, 0.5]]\n[motion]\nkind = "bodies"\nground = 0\n'
                   '[[motion.obstacle]]\nkind = "sphere"\ncentre = [0, 0, 2]\ndiameter = 3\n')
        self.share("--ticks", "1", program="ball.meld", after="#images")
        self.to(1)
        pixels = self.pixels()
        above, below = self.run_js("""const {view} = viewer.stage;
            return [3, 1].map((z) => view.project(0, -0.7, z)).map(({x, y}) => [x, y])""")
        light, dark = (pixels[round(y), round(x)].sum() for x, y in (above, below))
        self.assertGreater(light, dark + 60)
        # Part of the floor is behind the eye.
        self.assertLess(pixels[-5, [5, 200, -5]].max(), 235)

    def test_lamps_are_seen_where_they_stand(self):
        """One beside a catom, one below the other, and one that is dark: served, shared, and without graphics."""
        self.write("lit.meld", "setColor(A, 30, 30, 220) :- position(A, _, _, _).\n")
        lamp = "[[motion.lamp]]\nposition = [{}, 0, {}]\n"
        self.write("lit.toml", '[[body]]\npositions = [[-3, 0, 0], [3, 0, 0]]\n[motion]\nkind = "bodies"\ngravity = [0, 0, 0]\n' +
                   lamp.format(0, 1) + lamp.format(0, -1) + lamp.format(1.5, 0) + "share = 0\n" + '[[motion.lamp]]\nwhere = "id == 0"\n')
        for how in ("served", "served #images", "shared #images"):
            with self.subTest(how=how):
                after = how.partition(" ")[2]
                if how.startswith("served"):
                    self.open(self.view("lit.meld") + after)
                    self.command("to 1")
                else:
                    self.share("--ticks", "1", program="lit.meld", after=after)
                    self.to(1)
                self.run_js("const {stage} = viewer; Object.assign(stage.view, {azimuth: -90, elevation: 0, angle: 0, height: 4});"
                            "stage.view.update(); stage.draw()")
                wanted = self.run_js("return [[0, 0, 1], [0, 0, -1]].map((at) => viewer.stage.view.project(...at)).map(({x, y}) => [x, y])")
                self.wait(lambda: self.yellow())
                middles = self.yellow()
                self.assertEqual(len(middles), 2, middles)
                for (x, y), (u, v) in zip(wanted, middles):
                    self.assertLess(abs(x - u) + abs(y - v), 6, (wanted, middles))

    def yellow(self):
        """The middles of what is as yellow as lamps are, in the upper and in the lower half of the picture."""
        pixels = self.pixels()
        yellow = (abs(pixels - [255, 198, 26]) < 12).all(axis=2)
        half = len(yellow) // 2
        found = []
        for first, part in ((0, yellow[:half]), (half, yellow[half:])):
            rows, columns = np.nonzero(part)
            if len(rows) > 50:
                found.append((columns.mean(), first + rows.mean()))
        return found

    def slenderness(self):
        """The rows that the catoms fill, which are red, for each column."""
        pixels = self.pixels()
        red = pixels[:, :, 0] - pixels[:, :, 2] > 60
        return int((red.sum(axis=1) > 20).sum()) / max(1, int((red.sum(axis=0) > 20).sum()))

    def test_a_server_draws_where_the_browser_cannot(self):
        self.open(self.view("plate.meld") + "#images")
        self.command("run")
        self.enter("look-colour", "dist(A, D)")
        self.wait(lambda: self.text("legend"))
        self.wait(lambda: np.abs(self.cell(self.pixels(), 0, 0) - PURPLE).max() < 60)
        self.assertLess(np.abs(self.cell(self.pixels(), WIDTH - 1, HEIGHT - 1) - YELLOW).max(), 60)

    def lose(self, restored):
        self.run_js("""window.lent = window.lent || viewer.stage.renderer.getContext().getExtension("WEBGL_lose_context");
            window.lent[arguments[0]]();""", "restoreContext" if restored else "loseContext")
        self.wait(lambda: self.run_js("return viewer.stage.drawsItself") == restored)
        said = " ".join(e.text for e in self.browser.find_elements(By.CLASS_NAME, "lost"))
        self.assertEqual("lost its graphics" in said, not restored, said)
        # What it says lies over the picture.
        self.run_js("for (const said of document.getElementsByClassName('lost')) said.style.visibility = 'hidden'")

    def test_graphics_are_lost_and_come_back(self):
        for served in (True, False):
            if served:
                self.open(self.view("plate.meld"))
                self.enter("look-colour", "dist(A, D)")
                self.command("run")
                self.wait(lambda: self.text("legend"))
            else:
                self.share("--colour", "dist(A, D)")
                self.to(self.run_js("return viewer.info.last"))
            # Twice, since what is made anew must hear of it too.
            for restored in (False, True, False, True):
                self.lose(restored)
                self.wait(lambda: np.abs(self.cell(self.pixels(), 0, 0) - PURPLE).max() < 60)
                self.assertLess(np.abs(self.cell(self.pixels(), WIDTH - 1, HEIGHT - 1) - YELLOW).max(), 60)
                self.click(0)
                self.assertEqual(self.text("catom"), "Catom @0")
                self.run_js("viewer.select([])")

    def test_pages_of_any_size_hold_all_that_there_is(self):
        self.addCleanup(self.browser.set_window_size, 1100, 720)
        # Drawn by the server: what draws without a graphics card takes long for millions of pixels.
        self.open(self.view("plate.meld") + "#images")
        sizes = {}
        for width, height in ((420, 900), (700, 700), (1100, 720), (1920, 1080), (3840, 2160)):
            self.browser.set_window_size(width, height)
            self.wait(lambda: self.run_js("return innerWidth") == width)
            self.wait(lambda: self.run_js("return viewer.stage.view.width === document.getElementById('stage').clientWidth"))
            outside, sizes[width] = self.run_js("""
                const beyond = [], all = "header, header *, main, footer, footer *, aside, aside *, #stage";
                for (const element of document.querySelectorAll(all)) {
                    const {left, right, top, bottom, width} = element.getBoundingClientRect();
                    const high = !element.closest("aside") && (top < -1 || bottom > innerHeight + 1);
                    if (width && (left < -1 || right > innerWidth + 1 || high)) beyond.push(element.id || element.tagName);
                }
                const of = (id) => document.getElementById(id).getBoundingClientRect();
                return [beyond, {text: parseFloat(getComputedStyle(document.getElementById("find")).fontSize), stage: of("stage").width,
                    tall: of("stage").height, look: of("look").width, page: document.documentElement.scrollWidth}];""")
            self.assertEqual(outside, [], width)
            self.assertLessEqual(sizes[width]["page"], width)
            # The picture has room, and the panels have their share of the page.
            self.assertGreater(sizes[width]["stage"], width * 0.4, width)
            self.assertGreater(sizes[width]["tall"], 100, width)
            self.assertGreater(sizes[width]["look"], width * 0.09, width)
        self.assertEqual(sizes[1100]["text"], sizes[700]["text"])
        self.assertGreater(sizes[3840]["text"], 1.5 * sizes[1100]["text"])


class Steered(Pages):
    """Runs, their failures and their worlds, changed on the page."""

    def test_a_wrong_body_stops_nothing(self):
        self.open(self.view("plate.meld"))
        for field in ("colour", "only", "labels"):
            self.enter(f"look-{field}", "dsit(A, D)")
            self.wait(lambda: "dsit" in self.text(f"look-{field}-mistake"))
        frames = (("command", "step"), ("command", "to 6"), ("tick", 2), ("command", "run"))
        for how, what in frames:
            if how == "tick":
                self.to(what)
            else:
                self.command(what)
            tick = self.run_js("return viewer.words.tick")
            self.assertEqual(self.text("tick"), f"tick {tick}")
            self.assertIn("dsit", self.text("look-colour-mistake"))
        self.assertGreater(tick, 6)
        self.assertEqual(self.run_js("return viewer.stage.frame.count"), WIDTH * HEIGHT)
        # One is cured after the other.
        self.enter("look-only", "dist(A, 2)")
        self.wait(lambda: self.run_js("return viewer.words.shown") == 3)
        self.assertEqual(self.text("look-only-mistake"), "")
        self.assertIn("dsit", self.text("look-colour-mistake"))

    def test_the_program_is_read_again_and_a_long_run_ends(self):
        self.open(self.view("forever.meld"))
        program = self.read("forever.meld").decode()
        self.write("forever.meld", program + "nonsense\n")
        self.wait(lambda: "goes on under its old rules" in self.text("notice"))
        self.assertIn("forever.meld:3:", self.text("notice"))
        self.write("forever.meld", program + "type new(node).\n")
        self.wait(lambda: "was read again" in self.text("notice"))
        # Fields know its predicates.
        self.browser.find_element(By.ID, "look-only").send_keys("ne")
        self.wait(lambda: "new(A)" in self.offered())
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

    def test_failures_are_made_by_mouse_and_saved(self):
        self.write("jams.toml", PLATE + "[network]\nlongest_jam = 30\n")
        self.write("taps.meld", CORNER + "tap(A) -o token(A, 0).\n")
        self.open(self.view("taps.meld", "--world", "jams.toml"))
        self.enter("look-colour", "dist(A, D)")
        self.command("run")
        self.click(23)

        def press(name, says):
            self.browser.find_element(By.ID, name).click()
            self.wait(lambda: says in self.text("panel"))

        press("cut-links", "cut @23")
        self.command("run")
        self.wait(lambda: "dist(@23, " not in self.text("facts"))
        press("heal-links", "heal @23")
        self.command("run")
        self.wait(lambda: "dist(@23, " in self.text("facts"))
        press("jam-links", "jam 10 @23")
        press("hang", "hang @23")
        self.run_js("viewer.select([0, 1, 2])")
        press("cut-links", "cut around 3 catoms")
        press("restart", "restart 3 catoms")
        self.run_js("viewer.select([22, 23])")
        press("cut-links", "cut @22 @23")
        press("tap", "give tap(@23)")
        press("save-events", "events.toml: 9 events")
        events = self.read("events.toml").decode()
        for line in ('cut = "id == 23"', 'jam = { where = "id == 23", ticks = 10 }', "hang = [23]", "restart = [0, 1, 2]",
                     "cut = [[22, 23]]",
                     'cut = { between = ["id >= 0 && id <= 2", "!(id >= 0 && id <= 2)"] }', 'give = { "tap" = "id == 22" }'):
            self.assertIn(line, events)
        # The world with these events makes the same run.
        self.command("to 60")
        digest = self.browser.execute_script("return viewer.source.command('where')")["answer"]["digest"]
        self.write("again.toml", self.read("jams.toml").decode() + events)
        self.call("meldsim", "run", "taps.meld", "--world", "again.toml", "--ticks", "60", "--digest", "d.txt", "--quiet")
        self.assertIn(digest, self.read("d.txt").decode())

    def test_a_world_is_changed_by_mouse(self):
        self.open(self.view("plate.meld", "--world", "plate.toml"))
        self.browser.find_element(By.ID, "edit-world").click()
        self.wait(lambda: "24" in self.text("world-said"))
        area, stage = self.browser.find_element(By.ID, "world-toml"), self.browser.find_element(By.ID, "stage")

        def tool(name):
            self.browser.find_element(By.ID, f"tool-{name}").click()

        def click(x, y, catoms):
            """Counted in cells from the lower left one."""
            at = self.run_js("""const s = viewer.stage, low = arguments[2];
                const at = s.view.project(low[0] + arguments[0], low[1] + arguments[1], 0);
                return [at.x - s.view.width / 2, at.y - s.view.pixels / 2];""", x, y, low)
            ActionChains(self.browser).move_to_element_with_offset(stage, *map(round, at)).click().perform()
            self.wait(lambda: self.run_js("return viewer.stage.frame.count") == catoms)

        low = self.run_js("return viewer.stage.bounds.low")
        self.run_js("const {stage} = viewer, {view} = stage; view.zoom(0.6, view.width / 2, view.pixels / 2); stage.draw()")
        tool("place")
        click(5.3, 1, 25)  # Beside the last of its row,
        click(8, 1, 26)    # and where nothing is.
        self.assertIn("2", self.text("world-said").split("pieces")[1].split()[0])
        tool("remove")
        click(0, 0, 25)
        tool("select")
        click(8, 1, 25)
        tool("copy")
        click(-0.4, 1, 26)
        text = area.get_attribute("value")
        x, y = (int(c) for c in low[:2])
        self.assertTrue(text.endswith("# Placed and taken out by mouse.\n"
                                      f"[[body]]\ncells = [[{x + 6}, {y + 1}], [{x + 8}, {y + 1}], [{x - 1}, {y + 1}]]\n\n"
                                      f"[without]\ncells = [[{x}, {y}]]\n"), text)
        tool("undo")
        self.wait(lambda: self.run_js("return viewer.stage.frame.count") == 25)
        self.browser.find_element(By.ID, "world-save").click()
        self.wait(lambda: "is written" in self.text("world-saved"))
        out, _ = self.call("meldsim", "world", "plate.toml")
        self.assertIn("25 catoms", out)
        self.write("plate.toml", PLATE)

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
