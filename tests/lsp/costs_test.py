"""Costs of rules in the editor: costs_test.py --meldc PATH --meldsim PATH [unittest options]"""
import json
import pathlib
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from frame import TOOLS, environment_with, main  # noqa: E402
from lsp_test import PROGRAM, SHARED, WHOLE, Case  # noqa: E402
from session import Session, uri  # noqa: E402

# Fires at no catom.
IDLE = "dist(A, 99) :- source(A), limit > 5.\n"


class Costs(Case):
    """What a profile says of the rules, shown beside them."""

    def profile(self, text=PROGRAM, name="run.profile", *options):
        """Runs the program on a line of four catoms; what the profile says of its rules, in order."""
        self.write("profiled/main.meld", text)
        self.write("profiled/shared.meld", SHARED)
        self.write("profiled/main.toml", 'lattice = "square"\n[[body]]\nshape = "box(4, 1, 1)"\n')
        self.call("meldsim", "run", "profiled/main.meld", "--ticks", 20, "--quiet", "--stats", "--profile", name, *options)
        return json.loads((self.folder / name).read_text())["statistics"]["rules"]

    def show(self, *profile):
        return self.server.answer("workspace/executeCommand", {"command": "meld.profile", "arguments": [str(p) for p in profile]})

    def hints(self, where=None, path=None):
        """(line, column, label) of each."""
        found = self.server.ask("textDocument/inlayHint", {"textDocument": {"uri": uri(path or self.path)}, "range": where or WHOLE})
        for hint in found:
            self.assertTrue(hint["paddingLeft"])
            self.assertEqual(hint["tooltip"]["kind"], "markdown")
        return [(hint["position"]["line"], hint["position"]["character"], hint["label"]) for hint in found]

    def told_of(self, rule):
        """How its figures are worded, but for the time."""
        if rule["firings"] == 0:
            return "never fired"
        words = [f"{rule['firings']:,} firing" + "s" * (rule["firings"] != 1)]
        if rule["messages"]:
            words.append(f"{rule['messages']:,} message" + "s" * (rule["messages"] != 1))
        return ", ".join(words)

    @staticmethod
    def without_time(hints):
        return [(line, column, label.split("of the time, ")[-1]) for line, column, label in hints]

    def places(self):
        """The ends of the rules."""
        lines = self.text.split("\n")
        return [(i, len(line.encode("utf-16-le")) // 2) for i, line in enumerate(lines) if ":-" in line or "-o" in line]

    def test_beside_each_rule_stands_what_it_did(self):
        rules = self.profile(PROGRAM + IDLE)
        self.open(PROGRAM + IDLE)
        self.assertEqual(self.hints(), [])
        self.assertIsNone(self.show(self.folder / "run.profile")["result"])
        own = [rule for rule in rules if rule["file"] == "main.meld"]
        self.assertEqual([rule["line"] - 1 for rule in own], [line for line, _ in self.places()])
        wanted = [(*place, self.told_of(rule)) for place, rule in zip(self.places(), own)]
        self.assertEqual(self.without_time(self.hints()), wanted)
        self.assertIn("never fired", [label for *_, label in wanted])
        self.assertIn("messages", wanted[1][2])
        # Only where they are asked for.
        line = wanted[2][0]
        rule = {"start": {"line": line, "character": 0}, "end": {"line": line + 1, "character": 0}}
        self.assertEqual(self.without_time(self.hints(rule)), [wanted[2]])
        # In the included file, what its own rules did.
        self.server.open(self.shared, SHARED)
        self.assertEqual(self.without_time(self.hints(path=self.shared)), [(1, 11, "1 firing")])
        # And no longer.
        self.assertIsNone(self.show()["result"])
        self.assertEqual(self.hints(), [])

    def test_a_rule_of_several_heads_has_the_costs_of_all(self):
        text = "type p(node).\ntype q(node, int).\np(A), q(A, N) :- id(A, N), N > 1.\n"
        rules = self.profile(text)
        self.open(text)
        self.show(self.folder / "run.profile")
        self.assertEqual(len(rules), 2)
        self.assertEqual(self.without_time(self.hints()), [(2, 33, "4 firings")])

    def test_a_rule_that_moved_has_its_costs_and_one_that_changed_has_none(self):
        self.profile()
        self.open()
        self.show(self.folder / "run.profile")
        before = self.hints()
        self.text = "// 🚀\n\n" + PROGRAM.replace("dist(B, D + 1) :- ", "dist(B, D + 1)   :-  /* ü */ ").replace("D > 1", "D > 2")
        self.server.change(self.path, 2, {"text": self.text})
        after = self.hints()
        self.assertEqual([label for *_, label in after], [label for at, (*_, label) in enumerate(before) if at != 2])
        places = self.places()
        self.assertEqual([place[:2] for place in after], places[:2] + places[3:])

    def test_the_time_of_a_rule(self):
        """Figures of a profile are believed, whatever they are."""
        self.profile()
        place = self.folder / "run.profile"
        profile = json.loads(place.read_text())
        for rule in profile["statistics"]["rules"]:
            rule["cpu_seconds"] = {12: 0.75, 13: 0.25}.get(rule["line"], 0)
        place.write_text(json.dumps(profile))
        self.open()
        self.show(place)
        labels = [label for *_, label in self.hints()]
        self.assertTrue(labels[0].startswith("75.0 % of the time, 1 firing"), labels)
        self.assertTrue(labels[1].startswith("25.0 % of the time, "), labels)
        self.assertNotIn("time", labels[2])

    def test_without_counts_there_is_the_time_alone(self):
        self.profile()
        self.call("meldsim", "run", "profiled/main.meld", "--ticks", 20, "--quiet", "--profile", "run.profile")
        place = self.folder / "run.profile"
        profile = json.loads(place.read_text())
        for rule in profile["statistics"]["rules"]:
            self.assertNotIn("firings", rule)
            rule["cpu_seconds"] = {12: 0.75, 13: 0.25}.get(rule["line"], 0)
        place.write_text(json.dumps(profile))
        self.open()
        self.show(place)
        self.assertEqual([label for *_, label in self.hints()], ["75.0 % of the time", "25.0 % of the time"])

    def test_a_profile_that_is_written_anew_is_read_anew(self):
        self.profile()
        self.open()
        self.show(self.folder / "run.profile")
        before = self.hints()
        time.sleep(0.02)
        self.profile(PROGRAM, "run.profile", "--set", "limit=1")
        self.assertNotEqual(self.hints(), before)
        # What is no profile changes nothing.
        before = self.hints()
        self.write("run.profile", "{")
        self.assertEqual(self.hints(), before)

    def test_what_is_no_profile(self):
        self.profile()
        self.open()
        self.show(self.folder / "run.profile")
        before = self.hints()
        whole = (self.folder / "run.profile").read_text()
        for name, text, says in (("no.json", "[]", "is no profile"), ("deep.json", "[" * 10 ** 6, "levels deep"),
                                 ("other.json", '{"claymeld_profile": 99}', "another version"),
                                 ("part.json", whole.replace('"evaluations"', '"valuations"'), "a part is missing"),
                                 ("cut.json", whole[:len(whole) // 2], "not whole")):
            with self.subTest(name):
                self.write(name, text)
                self.assertIn(says, self.show(self.folder / name)["error"]["message"])
        self.assertIn("there is no file", self.show(self.folder / "nothing")["error"]["message"])
        self.assertIn("no command", self.server.answer("workspace/executeCommand", {"command": "meld.other"})["error"]["message"])
        self.assertEqual(self.hints(), before)
        self.assertEqual(self.server.end(), 0)

    def another_session(self, **more):
        server = Session([TOOLS.meldc, "lsp"], environment_with({"XDG_CACHE_HOME": self.folder / "cache"}))
        self.addCleanup(server.kill)
        return server, server.start(**more)["capabilities"]

    def test_from_the_start_by_an_option(self):
        self.profile()
        self.server, capabilities = self.another_session(initializationOptions={"profile": str(self.folder / "run.profile")})
        self.assertTrue(capabilities["inlayHintProvider"])
        self.assertEqual(capabilities["executeCommandProvider"], {"commands": ["meld.profile"]})
        self.open()
        self.assertEqual(len(self.hints()), 4)
        self.server, _ = self.another_session(initializationOptions={"profile": "/nothing"})
        self.assertIn("there is no file", self.server.shown[0]["message"])

    def test_editors_that_can_ask_anew_are_told_to(self):
        self.profile()
        self.server, _ = self.another_session(capabilities={"workspace": {"inlayHint": {"refreshSupport": True}}})
        self.open()
        self.show(self.folder / "run.profile")
        while (message := self.server.next()).get("method") != "workspace/inlayHint/refresh":
            pass
        self.server.send(id=message["id"], result=None)
        self.assertEqual(len(self.hints()), 4)


if __name__ == "__main__":
    main("meldc", "meldsim")
