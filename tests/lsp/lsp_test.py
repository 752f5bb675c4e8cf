"""The language server as an editor meets it: every feature, half-written programs, broken messages, and its end.

    lsp_test.py --meldc PATH [unittest options]
"""
import os
import pathlib
import random
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import frame  # noqa: E402
from frame import TOOLS, environment_with, main  # noqa: E402
from session import Session, path_of, uri  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]

PROGRAM = """\
include "shared.meld".

// The limit of all walks.
const limit = 3.

// Hops from a source.
// The least counts.
type dist(node, min int D).   // In links.
type action setColor(node, int Red, int Green, int Blue).
type linear ball(node, int).

dist(A, 0) :- source(A).
dist(B, D + 1) :- neighbor(A, B), dist(A, D), D < limit.
setColor(A, 255, 0, 0) :- dist(A, D), D > 1.
ball(A, N), dist(A, D) -o { B | neighbor(A, B), B <> A | ball(B, N + D) }.
"""
SHARED = "type source(node).\nsource(@0).\n"
WHOLE = {"start": {"line": 0, "character": 0}, "end": {"line": 10 ** 6, "character": 0}}


class Case(frame.Case):
    maxDiff = 4000
    FILES = {"shared.meld": SHARED}

    def setUp(self):
        super().setUp()
        self.server = Session([TOOLS.meldc, "lsp", "--stdio"], environment_with({"XDG_CACHE_HOME": self.folder / "cache"}))
        self.addCleanup(self.server.kill)
        self.capabilities = self.server.start()["capabilities"]
        self.path = self.folder / "main.meld"
        self.shared = self.folder / "shared.meld"

    def open(self, text=PROGRAM):
        self.text = text
        return self.server.open(self.path, text)

    def at(self, needle, inside=""):
        """Line and column of `inside` in the first place of `needle`."""
        offset = self.text.index(needle) + needle.index(inside)
        before = self.text[:offset]
        return before.count("\n"), len(before.rsplit("\n", 1)[-1].encode("utf-16-le")) // 2

    def about(self, method, needle, inside="", **more):
        return self.server.about(method, self.path, *self.at(needle, inside), **more)

    def hover(self, needle, inside=""):
        answer = self.about("hover", needle, inside)
        return answer and answer["contents"]["value"]

    def texts(self, locations):
        """What stands at each location, with its file."""
        found = []
        for location in locations:
            path = path_of(location["uri"])
            lines = (self.text if path == self.path else path.read_text()).split("\n")
            start, end = location["range"]["start"], location["range"]["end"]
            found.append((path.name, start["line"], lines[start["line"]][start["character"]:end["character"]]))
        return found

    def applied(self, edits, text):
        lines = text.split("\n")
        for edit in sorted(edits, key=lambda e: (e["range"]["start"]["line"], e["range"]["start"]["character"]), reverse=True):
            start, end = edit["range"]["start"], edit["range"]["end"]
            self.assertEqual(start["line"], end["line"])
            units = lines[start["line"]].encode("utf-16-le")
            kept = units[:2 * start["character"]].decode("utf-16-le"), units[2 * end["character"]:].decode("utf-16-le")
            lines[start["line"]] = kept[0] + edit["newText"] + kept[1]
        return "\n".join(lines)


class Life(Case):
    def test_it_says_what_it_can_do(self):
        for name in ("hover", "definition", "references", "rename", "documentSymbol", "documentFormatting"):
            self.assertTrue(self.capabilities[name + "Provider"], name)
        self.assertIn("completionProvider", self.capabilities)
        self.assertEqual(self.capabilities["textDocumentSync"], {"openClose": True, "change": 2, "save": True})

    def test_shutdown_and_exit(self):
        self.open()
        self.assertEqual(self.server.end(), 0)
        self.assertEqual(self.server.errors, b"")

    def test_exit_without_shutdown_is_an_error(self):
        self.server.notify("exit")
        self.assertEqual(self.server.process.wait(timeout=60), 1)

    def test_it_ends_with_its_input(self):
        self.server.process.stdin.close()
        self.assertEqual(self.server.process.wait(timeout=60), 1)


class Texts(Case):
    def test_messages_have_code_place_help_and_related_places(self):
        self.assertEqual(self.open(), [])
        messages = self.server.change(self.path, 2, {"text": "type p(node, int X).\ntype q(node).\np(A, N) :- q(A, N), nothing(A).\n"})
        self.assertEqual([(m["code"], m["severity"], m["source"]) for m in messages], [("E0303", 1, "meldc"), ("E0301", 1, "meldc")])
        self.assertEqual(messages[1]["range"], {"start": {"line": 2, "character": 20}, "end": {"line": 2, "character": 27}})
        self.assertEqual(messages[0]["relatedInformation"][0]["location"]["range"]["start"]["line"], 1)

    def test_what_has_no_use_is_marked_also_beside_other_open_programs(self):
        idle = ("const limit = 3.\nfun same(int X, int Y) : int = X.\ntype p(node, int).\ntype forgotten(node).\n"
                "p(A, same(N, 1)) :- id(A, N).\n")
        expected = [("W0406", 0, 2, [1]), ("W0407", 1, 2, [1]), ("W0405", 3, 2, [1])]
        for name in ("a.meld", "z.meld"):  # In front of and behind the other one.
            self.server.open(self.folder / name, "type q(node).\nq(A) :- id(A, 0).\n")
        messages = self.open(idle)
        self.assertEqual([(m["code"], m["range"]["start"]["line"], m["severity"], m.get("tags")) for m in messages], expected)
        once = self.server.change(self.path, 2, {"text": "type p(node).\np(A) :- id(A, N).\n"})
        self.assertEqual([(m["code"], m.get("tags")) for m in once], [("W0402", None)])

    def test_as_you_type(self):
        self.open("type p(node).\np(A) :- \n")
        self.assertEqual([m["code"] for m in self.server.diagnostics["main.meld"]], ["E0110"])
        end = {"start": {"line": 1, "character": 8}, "end": {"line": 1, "character": 8}}
        for number, letter in enumerate("neighbor(A, _).", 2):
            messages = self.server.change(self.path, number, {"range": end, "text": letter})
            end = {"start": {"line": 1, "character": 6 + number + 1}, "end": {"line": 1, "character": 6 + number + 1}}
        self.assertNotIn(1, [m["severity"] for m in messages], messages)

    def test_several_changes_in_one_message_apply_in_order(self):
        self.open("type p(node).\n")
        first = {"range": {"start": {"line": 0, "character": 5}, "end": {"line": 0, "character": 6}}, "text": "quack"}
        second = {"range": {"start": {"line": 1, "character": 0}, "end": {"line": 1, "character": 0}},
                  "text": "quack(A) :- neighbor(A, _).\nother(A) :- quack(A).\n"}
        messages = self.server.change(self.path, 2, first, second)
        self.assertEqual([(m["code"], m["range"]["start"]) for m in messages if m["severity"] == 1],
                         [("E0301", {"line": 2, "character": 0})])

    def test_columns_are_utf_16(self):
        # A rocket is two units, four bytes; an umlaut one unit, two bytes.
        unknown = lambda messages: [m["range"] for m in messages if m["code"] == "E0301"]
        messages = self.open('type p(node).\n/* ü🚀 */ p(A) :- /* 🚀ü */ missing(A).\n')
        self.assertEqual(unknown(messages), [{"start": {"line": 1, "character": 28}, "end": {"line": 1, "character": 35}}])
        change = {"range": {"start": {"line": 1, "character": 28}, "end": {"line": 1, "character": 38}}, "text": "neighbor(A, _)"}
        self.assertEqual(unknown(self.server.change(self.path, 2, change)), [])

    def test_a_mistake_in_an_included_file_is_shown_at_the_include(self):
        self.shared.write_text("type source(node).\nsource(A) :- .\n")
        messages = self.open()
        self.assertEqual([m["range"]["start"]["line"] for m in messages], [0])
        place = messages[0]["relatedInformation"][0]["location"]
        self.assertEqual((path_of(place["uri"]), place["range"]["start"]["line"]), (self.shared, 1))

    def test_open_text_counts_instead_of_the_file(self):
        self.open()
        self.server.open(self.shared, "type sauce(node).\n")
        self.server.change(self.shared, 2, {"text": "type sauce(node).\n\n"})
        while not self.server.diagnostics["main.meld"]:
            self.server.next()
        self.assertIn("no predicate `source`", self.server.diagnostics["main.meld"][0]["message"])
        # Closed, the file counts again, and its own messages go.
        self.server.notify("textDocument/didClose", {"textDocument": {"uri": uri(self.shared)}})
        while self.server.diagnostics["main.meld"]:
            self.server.next()
        self.assertEqual(self.server.diagnostics["shared.meld"], [])

    def test_formatting(self):
        self.open("type p(node).p(A):-p(A).// 🚀")
        ask = {"textDocument": {"uri": uri(self.path)}, "options": {"tabSize": 4, "insertSpaces": True}}
        edits = self.server.ask("textDocument/formatting", ask)
        self.assertEqual(edits, [{"newText": "type p(node).\np(A) :- p(A).  // 🚀\n",
                                  "range": {"start": {"line": 0, "character": 0}, "end": {"line": 0, "character": 29}}}])
        self.server.change(self.path, 2, {"text": edits[0]["newText"]})
        self.assertEqual(self.server.ask("textDocument/formatting", ask), [])
        self.server.change(self.path, 3, {"text": "type p(node"})
        self.assertIn("syntax errors", self.server.answer("textDocument/formatting", ask)["error"]["message"])


class Questions(Case):
    def test_hover_on_a_predicate(self):
        self.open()
        text = self.hover("dist(B, D + 1)")
        for part in ("type dist(node, min int D).", "Hops from a source.\nThe least counts.", "In links.", "persistent",
                     "aggregate: min of D", "stored as: single",
                     "recursive over links", "Derived by:\n```meld\ndist(A, 0) :- source(A).\ndist(B, D + 1)", "Read by:"):
            self.assertIn(part, text)
        self.assertIn("linear", self.hover("ball(A, N)"))
        self.assertIn("action", self.hover("setColor(A, 255"))
        self.assertIn("From the prelude", self.hover("neighbor(A, B), dist"))
        self.assertIn("sensed", self.hover("neighbor(A, B), dist"))
        self.assertIn("type source(node).", self.hover("source(A)"))

    def test_hover_on_other_names(self):
        self.open(PROGRAM + "fun twice(int X) : int = 2 * X.\ndist(A, twice(1)) :- source(A).\n")
        self.assertIn("int D", self.hover("D < limit"))
        self.assertIn("node B", self.hover("B <> A"))
        self.assertIn("const limit = 3.", self.hover("limit.\n"))
        self.assertIn("The limit of all walks.", self.hover("limit.\n"))
        self.assertIn("fun twice(int X) : int = 2 * X.", self.hover("twice(1)"))
        self.assertIn("shared.meld", self.hover('"shared.meld"'))
        self.assertIsNone(self.hover(":- source"))

    def test_hover_while_the_program_is_wrong(self):
        self.open(PROGRAM + "dist(A, X) :- source(A), dist(A,\n")
        self.assertIn("type dist(node, min int D).", self.hover("dist(A,\n"))
        self.assertIn("not declared", (self.open_again("p(A) :- q(A).\n"), self.hover("q(A)"))[1])

    def open_again(self, text):
        self.text = text
        return self.server.change(self.path, 2, {"text": text})

    def test_definition(self):
        self.open(PROGRAM + "fun twice(int X) : int = 2 * X.\ndist(A, twice(1)) :- source(A).\n")
        where = lambda *place: self.texts(self.about("definition", *place))
        self.assertEqual(where("dist(A, D), D <"), [("main.meld", 7, "dist")])
        self.assertEqual(where("limit.\n"), [("main.meld", 3, "limit")])
        self.assertEqual(where("twice(1)"), [("main.meld", 15, "twice")])
        self.assertEqual(where("source(A)"), [("shared.meld", 0, "source")])
        self.assertEqual(where('"shared.meld"'), [("shared.meld", 0, "")])
        self.assertEqual(where("D < limit"), [("main.meld", 12, "D")])
        self.assertEqual(where("neighbor(A, B), dist")[0][::2], ("prelude.meld", "neighbor"))
        self.assertEqual(where(":- source"), [])

    def test_predicates_of_one_name_are_told_apart_by_their_arguments(self):
        self.open("type p(node).\ntype p2(node, int).\np(A) :- neighbor(A, _, 2).\np(A) :- neighbor(A, _).\n")
        lines = [self.about("definition", f"neighbor(A, _{more}")[0]["range"]["start"]["line"] for more in (")", ", 2)")]
        self.assertNotEqual(lines[0], lines[1])

    def test_references(self):
        self.open()
        where = lambda place, declared: self.texts(self.about("references", place, context={"includeDeclaration": declared}))
        self.assertEqual([line for _, line, _ in where("dist(A, 0)", True)], [7, 11, 12, 12, 13, 14])
        self.assertEqual([line for _, line, _ in where("dist(A, 0)", False)], [11, 12, 12, 13, 14])
        self.assertEqual(sorted(where("source(A)", True)),
                         [("main.meld", 11, "source"), ("shared.meld", 0, "source"), ("shared.meld", 1, "source")])
        # A variable stays in its rule.
        self.assertEqual([line for _, line, _ in where("D < limit", True)], [12, 12, 12])

    def test_the_prelude_can_be_opened(self):
        self.open()
        path = path_of(self.about("definition", "neighbor(A, B), dist")[0]["uri"])
        self.text = path.read_text()
        self.assertEqual(self.text, (ROOT / "stdlib/prelude.meld").read_text())
        self.assertEqual(self.server.open(path, self.text), [])
        line = self.text[:self.text.index("neighborCount(")].count("\n")
        self.assertIn("sensed", self.server.about("hover", path, line, 15)["contents"]["value"])

    def test_completion(self):
        self.open(PROGRAM.replace("D > 1.", "D > 1, di"))
        answer = self.about("completion", "di\n", "\n")
        items = {item["label"]: item for item in answer["items"]}
        self.assertIn("Hops from a source.", items["dist"]["documentation"]["value"])
        self.assertEqual(items["dist"]["detail"], "type dist(node, min int D).")
        line, column = self.at("di\n", "\n")
        self.assertEqual(items["dist"]["textEdit"]["range"],
                         {"start": {"line": line, "character": column - 2}, "end": {"line": line, "character": column}})
        self.assertEqual(items["D"]["kind"], 6)
        self.assertIn("forall", items)
        self.assertIn("limit", items)
        self.assertIn("Other touches the catom.", items["neighbor"]["documentation"]["value"])
        self.assertEqual(items["setColor"]["kind"], 23)
        self.assertNotIn("N", items)

    def test_completion_depends_on_the_place(self):
        self.open("type \n// ty\nconst c = 1.\nty\n\"ty\np(A) :- q(A-ne")
        labels = lambda needle, inside="": {item["label"] for item in self.about("completion", needle, inside)["items"]}
        self.assertTrue({"linear", "action", "int"} <= labels("type \n", "\n"))
        self.assertNotIn("forall", labels("type \n", "\n"))
        self.assertEqual(labels("// ty\n", "\n"), set())
        self.assertIn("type", labels("\nty\n\"", "\n\""))
        # Behind a variable a hyphen is a minus.
        line, column = self.at("A-ne", "A")
        edit = self.server.about("completion", self.path, line, column + 4)["items"][0]["textEdit"]
        self.assertEqual(edit["range"]["start"]["character"], column + 2)

    def test_symbols(self):
        self.open()
        symbols = self.server.ask("textDocument/documentSymbol", {"textDocument": {"uri": uri(self.path)}})
        self.assertEqual([s["name"] for s in symbols],
                         ["shared.meld", "limit", "dist", "setColor", "ball", "dist", "dist", "setColor", "ball"])
        self.assertEqual(symbols[2]["detail"], "type dist(node, min int D).")
        for symbol in symbols:
            inner, outer = symbol["selectionRange"], symbol["range"]
            self.assertLessEqual((outer["start"]["line"], outer["start"]["character"]),
                                 (inner["start"]["line"], inner["start"]["character"]))
            self.assertLessEqual((inner["end"]["line"], inner["end"]["character"]), (outer["end"]["line"], outer["end"]["character"]))


class Names(Case):
    def rename(self, needle, name, inside=""):
        return self.about("rename", needle, inside, newName=name)["changes"]

    def refusal(self, needle, name):
        line, column = self.at(needle)
        asked = {"textDocument": {"uri": uri(self.path)}, "position": {"line": line, "character": column}, "newName": name}
        answer = self.server.answer("textDocument/rename", asked)
        return answer["error"]["message"]

    def check(self, text):
        self.call("meldc", "check", self.write("renamed.meld", text))

    def test_predicates_constants_and_variables(self):
        self.open()
        changed = self.applied(self.rename("dist(A, 0)", "hop-count")[uri(self.path)], PROGRAM)
        self.assertEqual(changed, PROGRAM.replace("dist", "hop-count"))
        self.check(changed)
        changed = self.applied(self.rename("limit = 3", "far")[uri(self.path)], PROGRAM)
        self.assertEqual(changed, PROGRAM.replace("const limit", "const far").replace("< limit", "< far"))
        # A variable is renamed in its rule and nowhere else.
        changed = self.applied(self.rename("B <> A", "Other")[uri(self.path)], PROGRAM)
        self.assertEqual(changed, PROGRAM.replace("{ B | neighbor(A, B), B <> A | ball(B,",
                                                  "{ Other | neighbor(A, Other), Other <> A | ball(Other,"))
        self.check(changed)

    def test_in_every_open_program_that_shares_the_file(self):
        self.open()
        other = self.folder / "other.meld"
        other_text = 'include "shared.meld".\ntype p(node).\np(A) :- source(A).\n'
        self.server.open(other, other_text)
        unrelated = self.folder / "unrelated.meld"
        self.server.open(unrelated, "type source(node).\nsource(@1).\n")
        changes = self.rename("source(A)", "origin")
        self.assertEqual(set(changes), {uri(self.path), uri(self.shared), uri(other)})
        self.assertEqual(self.applied(changes[uri(self.shared)], SHARED), SHARED.replace("source", "origin"))
        self.assertEqual(self.applied(changes[uri(other)], other_text), other_text.replace("source", "origin"))

    def test_what_is_refused(self):
        self.open(PROGRAM + "type end(node).\nball(@0, if limit > 1 then 1 else 2 end).\n")
        self.assertIn("prelude", self.refusal("neighbor(A, B), dist", "touches"))
        self.assertIn("prelude", self.refusal("setColor(A, 255", "paint"))
        self.assertIn("taken", self.refusal("dist(A, 0)", "ball"))
        self.assertIn("taken", self.refusal("D < limit", "A"))
        self.assertIn("not a name", self.refusal("dist(A, 0)", "Dist"))
        self.assertIn("not a name", self.refusal("dist(A, 0)", "two words"))
        self.assertIn("not a variable", self.refusal("D < limit", "d"))
        self.assertIn("nothing here", self.refusal(":- source", "x"))
        self.assertIn("something else", self.refusal("ball(A, N)", "not"))

    def test_original_meld_has_lower_case_variables(self):
        self.open("type p(node, int).\ntype q(node, int).\nq(a, n) :- p(a, n), n > 1.\n")
        changed = self.applied(self.rename("n > 1", "count-of-it")[uri(self.path)], self.text)
        self.assertEqual(changed, self.text.replace("(a, n)", "(a, count-of-it)").replace("n > 1", "count-of-it > 1"))


class Actions(Case):
    def actions(self, needle, inside="", **context):
        """The code actions at a place of the text."""
        line, column = self.at(needle, inside)
        return self.ask({"start": {"line": line, "character": column}, "end": {"line": line, "character": column}}, **context)

    def ask(self, where, **context):
        return self.server.ask("textDocument/codeAction", {"textDocument": {"uri": uri(self.path)}, "range": where,
                                                           "context": {"diagnostics": [], **context}})

    def after(self, action, path=None):
        """The text with the edits of an action, all in one file."""
        (address, edits), = action["edit"]["changes"].items()
        self.assertEqual(path_of(address), path or self.path)
        return self.applied(edits, self.text if path is None else path.read_text())

    def test_it_says_that_it_has_them(self):
        self.assertEqual(self.capabilities["codeActionProvider"], {"codeActionKinds": ["quickfix"]})

    def test_each_cure_with_its_message_the_best_first(self):
        messages = self.open("type p(node).\ntype dist(node, int).\np(A) :- dust(A, 3).\n")
        found = self.actions("dust")
        self.assertEqual([(a["title"], a["kind"], a["isPreferred"]) for a in found],
                         [("Write `dist`", "quickfix", True), ("Declare `type dust(node, int).`", "quickfix", False)])
        self.assertEqual([a["diagnostics"] for a in found], [[m for m in messages if m["code"] == "E0301"]] * 2)
        self.assertEqual(self.after(found[0]), self.text.replace("dust", "dist"))
        declared = self.after(found[1])
        self.assertEqual(declared, self.text.replace("int).\n", "int).\ntype dust(node, int).\n", 1))
        self.assertEqual([m["code"] for m in self.server.change(self.path, 2, {"text": declared}) if m["severity"] == 1], [])

    def test_the_types_of_a_declaration_come_from_all_uses(self):
        self.open("type q(node, float).\nseen(A, X, []) :- q(A, _).\nseen(A, X, [\"a\"]) :- q(A, X).\nq(A, X) :- seen(A, X, _).\n")
        self.assertEqual([a["title"] for a in self.actions("seen")], ["Declare `type seen(node, float, list string).`"])

    def test_the_link_a_rule_needs(self):
        self.open("type c(node, int).\ntype same(node, node).\nsame(A, B) :- c(A, X), c(B, X).\n"
                  "same(A, A) :- c(A, X), not c(B, X).\n")
        add, = self.actions("c(B, X).", "B")
        self.assertEqual((add["title"], self.after(add).split("\n")[2]),
                         ("Add `neighbor(A, B)`", "same(A, B) :- c(A, X), neighbor(A, B), c(B, X)."))
        line = self.text.split("\n").index("same(A, A) :- c(A, X), not c(B, X).")
        add, = self.ask({"start": {"line": line, "character": 29}, "end": {"line": line, "character": 29}})
        self.assertEqual(self.after(add).split("\n")[line], "same(A, A) :- c(A, X), not (neighbor(A, B), c(B, X)).")

    def test_a_conversion_in_utf_16_columns(self):
        self.open('type p(node, string).\n/* 🚀ü */ p(A, N) :- id(A, N).\n')
        convert, = [a for a in self.actions("N) :-") if "2str" in a["title"]]
        self.assertEqual(self.after(convert), self.text.replace("p(A, N)", "p(A, int2str(N))"))
        self.assertEqual(self.server.change(self.path, 2, {"text": self.after(convert)}), [])

    def test_only_what_is_asked_for(self):
        self.open("type p(node).\ntype q(node).\np(A) :- p(A).\n")
        whole = {"start": {"line": 0, "character": 0}, "end": {"line": 3, "character": 0}}
        self.assertEqual([a["title"] for a in self.ask(whole)], ["Leave out the declaration"])
        self.assertEqual([a["title"] for a in self.ask(whole, only=["quickfix"])], ["Leave out the declaration"])
        self.assertEqual(self.ask(whole, only=["refactor", "quickfix.other"]), [])
        self.assertEqual(self.ask({"start": {"line": 0, "character": 0}, "end": {"line": 0, "character": 13}}), [])

    def test_a_cure_in_an_included_file_is_offered_at_the_include(self):
        self.shared.write_text("type source(node)\nsource(@0).\n")
        self.open()
        found, = self.actions('"shared.meld"')
        self.assertEqual(self.after(found, self.shared), SHARED)
        # The open text of that file counts, saved or not.
        self.server.open(self.shared, "// ü\ntype source(node)\nsource(@0).\n")
        while len(self.server.diagnostics["main.meld"][0]["relatedInformation"]) == 0 or \
                self.server.diagnostics["main.meld"][0]["relatedInformation"][0]["location"]["range"]["start"]["line"] != 1:
            self.server.next()
        found, = self.actions('"shared.meld"')
        edit, = found["edit"]["changes"][uri(self.shared)]
        self.assertEqual(edit, {"range": {"start": {"line": 1, "character": 17}, "end": {"line": 1, "character": 17}}, "newText": "."})

    def test_what_belongs_to_the_compiler_stays(self):
        # Its cure would be an export in a library.
        messages = self.open('use "broadcast".\ntype p(node).\np(A) :- broadcast-nearest(A, _, _, _).\n')
        self.assertEqual([m["code"] for m in messages if m["severity"] == 1], ["E0320"])
        self.assertEqual(self.actions("broadcast-nearest"), [])

    def test_broken_questions(self):
        self.open("type p(node)\np(A) :- p(A).\n")
        whole = {"start": {"line": 0, "character": 0}, "end": {"line": 3, "character": 0}}
        document = {"textDocument": {"uri": uri(self.path)}}
        for params in ({}, document, {**document, "range": whole}, {**document, "range": whole, "context": 7},
                       {**document, "range": {"start": 3}, "context": {}}, {**document, "range": whole, "context": {"only": 7}}):
            self.assertEqual(self.server.answer("textDocument/codeAction", params)["error"]["code"], -32602, params)
        # Messages of other servers may have any form.
        self.assertEqual(len(self.ask(whole, diagnostics=[{"anything": 1}])), 1)
        closed = {"textDocument": {"uri": uri(self.folder / "closed.meld")}, "range": whole, "context": {"diagnostics": []}}
        self.assertIn("not open", self.server.answer("textDocument/codeAction", closed)["error"]["message"])
        backwards = {"start": {"line": 10 ** 6, "character": 5}, "end": {"line": 0, "character": 0}}
        self.assertEqual(self.ask(backwards), [])


class Hostile(Case):
    def every_question(self, path, line, character):
        for method, more in (("hover", {}), ("definition", {}), ("references", {"context": {"includeDeclaration": True}}),
                             ("rename", {"newName": "another"}), ("completion", {})):
            self.server.answer("textDocument/" + method,
                               {"textDocument": {"uri": uri(path)}, "position": {"line": line, "character": character}, **more})
        self.server.answer("textDocument/codeAction", {
            "textDocument": {"uri": uri(path)}, "context": {"diagnostics": []},
            "range": WHOLE})
        self.server.answer("textDocument/inlayHint", {"textDocument": {"uri": uri(path)}, "range": WHOLE})
        for method in ("documentSymbol", "formatting"):
            self.server.answer("textDocument/" + method, {"textDocument": {"uri": uri(path)}, "options": {}})

    def test_half_written_programs(self):
        generator = random.Random(5)
        names = [ROOT / "examples/meld/shape_change.meld", ROOT / "tests/format/golden/rules.meld",
                 ROOT / "tests/format/golden/declarations.meld"]
        for name in names:
            text = name.read_text()
            self.server.open(self.folder / name.name, "")
            for version in range(2, 42):
                end = generator.randrange(len(text))
                part = text[:end] if version % 2 else text[:end] + text[end + generator.randrange(1, 30):]
                self.server.change(self.folder / name.name, version, {"text": part})
                line = part[:end].count("\n")
                self.every_question(self.folder / name.name, line, len(part[:end].rsplit("\n", 1)[-1]))
        self.assertEqual(self.server.end(), 0)

    def test_texts_that_are_no_programs(self):
        version = 1
        self.open("")
        for text in ("\0", "\ufeff", "/* /* */", '"', "((((((((", "}}}}", "[", "p([", "p({", "type", "type p(", "const", "fun f(", ":-",
                     "-o", "exists X", "import p as", "priority p/", "\r\n\r\n", "// \U0001f680", "p(" * 3000, "type p(node).\n" * 300,
                     "include \"main.meld\".", "include \"..\".", "[sum => ", "p(A)@+", "delta(", "export p",
                     "type route linear p(node, min int [<- "):
            version += 1
            self.server.change(self.path, version, {"text": text})
            for place in ((0, 0), (0, 3), (0, 10 ** 6), (10 ** 6, 0)):
                self.every_question(self.path, *place)
        self.assertEqual(self.server.end(), 0)

    def test_messages_a_million_deep_are_broken_ones(self):
        for opening, closing in ((b"[", b"]"), (b'{"a":', b"}")):
            params = opening * 10**6 + b"1" + closing * 10**6
            self.server.raw(b'{"jsonrpc": "2.0", "id": 77, "method": "initialize", "params": ' + params + b"}")
        text = "type p(node).\n// " + "[" * 5_000 + ' " \\ ' + "{" * 5_000 + "\np(A) :- q(A).\n"
        self.assertEqual([d["range"]["start"]["line"] for d in self.open(text)], [2])
        self.assertEqual(self.server.end(), 0)

    def test_broken_messages(self):
        self.server.raw(b"{ this is no json")
        self.server.raw(b'{"jsonrpc": "2.0", "method": "textDocument/didOpen", "params": {"textDocument": 7}}')
        self.server.notify("textDocument/didChange",
                           {"textDocument": {"uri": uri(self.path), "version": 3}, "contentChanges": [{"text": "x"}]})
        self.server.notify("textDocument/didClose", {"textDocument": {"uri": uri(self.path)}})
        self.server.notify("no/such/notification")
        self.assertEqual(self.server.answer("no/such/method")["error"]["code"], -32601)
        self.assertEqual(self.server.answer("textDocument/hover", {"textDocument": {}})["error"]["code"], -32602)
        start = {"textDocument": {"uri": uri(self.path)}, "position": {"line": 0, "character": 0}}
        answer = self.server.answer("textDocument/hover", start)
        self.assertIn("not open", answer["error"]["message"])
        self.assertEqual(self.open(), [])

    def test_includes_of_what_has_no_end(self):
        os.mkfifo(self.folder / "pipe")
        for version, path in enumerate(("pipe", "/dev/zero", "/dev/tty"), 2):
            self.open("") if version == 2 else None
            self.server.change(self.path, version, {"text": f'include "{path}".\ntype p(node).\n'})
            symbols = self.server.ask("textDocument/documentSymbol", {"textDocument": {"uri": uri(self.path)}})
            self.assertEqual(symbols[-1]["name"], "p")
        self.assertEqual(self.server.end(), 0)

    def test_ranges_outside_of_the_text(self):
        self.open("type p(node).\n")
        far = {"start": {"line": 50, "character": 3}, "end": {"line": 60, "character": 0}}
        self.server.change(self.path, 2, {"range": far, "text": "type q(node).\n"})
        backwards = {"start": {"line": 1, "character": 3}, "end": {"line": 0, "character": 0}}
        self.server.change(self.path, 3, {"range": backwards, "text": ""})
        symbols = self.server.ask("textDocument/documentSymbol", {"textDocument": {"uri": uri(self.path)}})
        self.assertEqual([s["name"] for s in symbols], ["p", "q"])


if __name__ == "__main__":
    main("meldc")
