"""Colours of editors and documents. Each token of the compiler must get the colour of its kind from the TextMate grammar and from the
Pygments lexer, in every example, in the formatter's golden files, and in every_token.meld, which has all kinds.

    editors_test.py --meldc PATH [unittest options]
"""
import json
import pathlib
import re
import subprocess
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(ROOT / "tests"), str(ROOT / "editors/pygments")]

from frame import TOOLS, Case, main  # noqa: E402
from meld_lexer import MeldLexer  # noqa: E402
from pygments.lexers import load_lexer_from_file  # noqa: E402
from pygments.token import Comment, Error, Keyword, Name, Number, Operator, Punctuation, String  # noqa: E402
from textmate import Grammar  # noqa: E402

# Token kinds by the beginnings of the TextMate scopes they may have, and the Pygments types.
DECLARATION = (("keyword.declaration",), (Keyword.Declaration,))
CONTROL = (("keyword.",), (Keyword,))
BRACKET = (("punctuation.section",), (Punctuation,))
SEPARATOR = (("punctuation.separator",), (Punctuation,))
STOP = (("punctuation.terminator",), (Punctuation, Operator))
OPERATOR = (("keyword.operator",), (Operator,))
SIGIL = (("storage.modifier.sigil",), (Operator,))
INCLUDE = (("keyword.control.import",), (Keyword.Namespace,))
COLOURS = {
    "Name": (("entity.", "constant.", "storage.", "support."), (Name, Keyword.Type, Keyword, Keyword.Constant)),
    "Variable": (("variable.other",), (Name.Variable,)),
    "Anonymous": (("variable.language.anonymous",), (Name.Builtin.Pseudo,)),
    "Int": (("constant.numeric",), (Number.Integer, Operator)),
    "Float": (("constant.numeric.float",), (Number.Float,)),
    "String": (("string.",), (String,)),
    "Catom": (("constant.other.catom",), (Name.Constant,)),
    "World": (("variable.language.world",), (Name.Builtin.Pseudo,)),
    "RunArgument": (("variable.parameter.run",), (Name.Builtin.Pseudo,)),
    "AtName": (("entity.other",), (Name.Decorator,)),
    "Delay": (("constant.numeric.delay",), (Number,)),
    "Period": STOP, "ExistsPeriod": STOP, "Comma": SEPARATOR, "Semicolon": SEPARATOR, "Bar": SEPARATOR, "Colon": SEPARATOR,
    "LeftParen": BRACKET, "RightParen": BRACKET, "LeftBracket": BRACKET, "RightBracket": BRACKET, "LeftBrace": BRACKET,
    "RightBrace": BRACKET, "StructOpen": BRACKET, "NeighbourOpen": (("keyword.operator", "punctuation.section"), (Operator,)),
    "Cons": OPERATOR, "ViewArrow": OPERATOR, "LinearArrow": OPERATOR, "ResultArrow": OPERATOR, "LastArrow": OPERATOR,
    "Equal": OPERATOR, "NotEqual": OPERATOR,
    "Less": OPERATOR, "LessEqual": OPERATOR, "Greater": OPERATOR, "GreaterEqual": OPERATOR, "And": OPERATOR, "Or": OPERATOR,
    "Tilde": OPERATOR, "Plus": OPERATOR, "Minus": OPERATOR,
    "Star": OPERATOR, "Slash": OPERATOR, "Percent": OPERATOR, "Caret": OPERATOR, "Append": OPERATOR,
    "Bang": SIGIL, "Question": SIGIL, "Dollar": SIGIL,
    "Type": DECLARATION, "Const": DECLARATION, "Fun": DECLARATION, "Extern": DECLARATION, "Node": DECLARATION, "Import": DECLARATION,
    "Export": DECLARATION, "Module": DECLARATION, "Hint": DECLARATION,
    "If": CONTROL, "Then": CONTROL, "Else": CONTROL, "Otherwise": CONTROL, "EndWord": CONTROL, "Let": CONTROL, "In": CONTROL,
    "Not": CONTROL, "Forall": CONTROL, "Exists": CONTROL, "Delta": CONTROL,
    "Aggregate": (("support.function.aggregate",), (Name.Builtin,)),
    "SizedAggregate": (("support.function.aggregate",), (Name.Builtin,)),
    "Include": INCLUDE, "IncludePath": (("keyword.control.import", "string."), (Keyword.Namespace, String)), "Use": INCLUDE,
}


def tokens_of(path):
    """(kind, start, end) of each token of a file of ASCII text, as the compiler reads it."""
    text = path.read_text()
    starts = [0]
    for line in text.split("\n"):
        starts.append(starts[-1] + len(line) + 1)
    out = subprocess.run([TOOLS.meldc, "compile", path, "--emit=tokens"], capture_output=True, text=True, timeout=60).stdout
    for line in out.splitlines():
        match = re.match(r"(\d+):(\d+) (\w+) ?(.*)$", line)
        start = starts[int(match[1]) - 1] + int(match[2]) - 1
        if match[3] != "End":
            yield match[3], start, start + len(match[4])


def precise_files():
    """Programs whose every token is looked at."""
    yield HERE / "every_token.meld"
    yield from sorted((ROOT / "examples").rglob("*.meld"))
    yield from sorted((ROOT / "stdlib").rglob("*.meld"))


def wrongly_scanned(path):
    """Files that are wrong on purpose below the level of tokens."""
    return path.name in ("fail_unexpected_character.meld", "fail_invalid_text.meld", "fail_unterminated_comment.meld",
                         "fail_number_out_of_range.meld", "fail_other_languages.meld", "fail_computed_delay.meld",
                         "fail_hash_comment.meld")


def all_files():
    for folder in ("examples", "stdlib", "tests"):
        yield from sorted(path for path in (ROOT / folder).rglob("*.meld") if not wrongly_scanned(path))


class Table(Case):
    def test_every_kind_has_a_colour_and_stands_in_the_sample(self):
        kinds = set(re.findall(r"^MELD_TOKEN\((\w+),", (ROOT / "compiler/syntax/tokens.def").read_text(), re.MULTILINE)) - {"End"}
        self.assertEqual(set(COLOURS), kinds)
        self.assertEqual({kind for kind, _, _ in tokens_of(HERE / "every_token.meld")}, kinds)

    def test_the_sample_has_no_syntax_errors(self):
        self.call("meldc", "fmt", "--stdout", HERE / "every_token.meld")


class Pygments(unittest.TestCase):
    def colours(self, text):
        """For each character its type."""
        result = []
        for kind, value in MeldLexer(stripnl=False, ensurenl=False).get_tokens(text):
            result += [kind] * len(value)
        self.assertEqual(len(result), len(text))
        return result

    def test_no_error_in_any_program(self):
        count = 0
        for path in all_files():
            text = path.read_text()
            for index, kind in enumerate(self.colours(text)):
                self.assertIsNot(kind, Error, f"{path}: {text[max(0, index - 20):index + 20]!r}")
            count += 1
        self.assertGreater(count, 60)

    def test_tokens_have_the_colour_of_their_kind(self):
        for path in precise_files():
            text = path.read_text()
            colours = self.colours(text)
            for kind, start, end in tokens_of(path):
                allowed = COLOURS[kind][1]
                wrong = [c for c, letter in zip(colours[start:end], text[start:end])
                         if not letter.isspace() and not any(c in one for one in allowed) and c not in String]
                self.assertEqual(wrong, [], f"{path}: {kind} {text[start:end]!r} in {text[max(0, start - 30):end + 10]!r}")
                self.assertTrue(kind in ("String", "IncludePath") or not any(c in String for c in colours[start:end]),
                                f"{path}: {kind} {text[start:end]!r}")

    def test_it_is_found_by_pygments(self):
        lexer = load_lexer_from_file(str(ROOT / "editors/pygments/meld_lexer/__init__.py"), "MeldLexer")
        self.assertEqual(lexer.name, "Meld")
        first = next(iter(lexer.get_tokens("// c\n")))
        self.assertIn(first[0], Comment)


class TextMate(unittest.TestCase):
    def setUp(self):
        self.grammar = Grammar(json.loads((ROOT / "editors/vscode/syntaxes/meld.tmLanguage.json").read_text()))

    def test_the_regular_expressions_compile(self):
        found = list(self.grammar.all_regexes())
        self.assertGreater(len(found), 30)
        for pattern in found:
            re.compile(pattern)

    def test_tokens_have_the_scope_of_their_kind(self):
        for path in precise_files():
            text = path.read_text()
            scopes = self.grammar.scopes(text)
            for kind, start, end in tokens_of(path):
                for index in range(start, end):
                    if text[index].isspace():
                        continue
                    names = [name for name in scopes[index] if not name.startswith("constant.character.escape")]
                    self.assertTrue(names, f"{path}: {kind} {text[start:end]!r} has no scope")
                    self.assertTrue(names[-1].startswith(COLOURS[kind][0]),
                                    f"{path}: {kind} {text[start:end]!r} is {names} in {text[max(0, start - 30):end + 10]!r}")

    def test_comments_are_comments_all_through(self):
        text = "/* a /* b */ c\n d */ p(A). // e\n;; f\n"
        scopes = self.grammar.scopes(text)
        for index, letter in enumerate(text):
            if letter.isalpha():
                self.assertEqual(any(name.startswith("comment") for name in scopes[index]), letter not in "pA", f"{letter} at {index}")


class Extension(unittest.TestCase):
    FOLDER = ROOT / "editors/vscode"

    def test_the_files_that_it_names_exist(self):
        package = json.loads((self.FOLDER / "package.json").read_text())
        contributes = package["contributes"]
        for path in (package["main"], contributes["languages"][0]["configuration"], contributes["grammars"][0]["path"]):
            self.assertTrue((self.FOLDER / path).is_file(), path)
        self.assertEqual(contributes["languages"][0]["id"], contributes["grammars"][0]["language"])
        self.assertEqual(contributes["grammars"][0]["scopeName"], "source.meld")

    def test_attributes_of_a_launch_are_those_that_the_debugger_reads(self):
        package = json.loads((self.FOLDER / "package.json").read_text())
        debugger = package["contributes"]["debuggers"][0]
        offered = debugger["configurationAttributes"]["launch"]["properties"]
        reads = (ROOT / "runtime/ask/dap/launch.cpp").read_text()
        table = re.search(r"kAttributes = \{\{(.*?)\}\};", reads, re.DOTALL)[1]
        known = set(re.findall(r'\{"(\w+)", "--', table)) | set(re.findall(r'(?:contains|flag)\((?:arguments, )?"(\w+)"', reads))
        # That one is VS Code's own.
        self.assertEqual(set(offered), known - {"noDebug"})
        page = (ROOT / "docs/reference/debugging.md").read_text().split("A configuration says what is run.")[1].split("\n\n")[1]
        first_cells = " ".join(row.split("|")[1] for row in page.split("\n") if row.startswith("| `"))
        self.assertEqual(set(re.findall(r"`(\w+)`", first_cells)), set(offered))
        for configuration in debugger["initialConfigurations"] + [s["body"] for s in debugger["configurationSnippets"]]:
            self.assertEqual((configuration["type"], configuration["request"]), (debugger["type"], "launch"))
            self.assertLessEqual(set(configuration) - {"type", "request", "name"}, set(offered))

    def test_what_the_code_registers_is_what_the_manifest_names(self):
        package = json.loads((self.FOLDER / "package.json").read_text())
        code = "".join((self.FOLDER / name).read_text() for name in ("client.js", "costs.js", "debug.js"))
        contributes = package["contributes"]
        self.assertEqual(set(re.findall(r'registerCommand\("([^"]+)"', code)), {c["command"] for c in contributes["commands"]})
        self.assertEqual(set(re.findall(r'registerDebug\w+\("([^"]+)"', code)), {d["type"] for d in contributes["debuggers"]})
        self.assertEqual({"meld." + name for name in re.findall(r'getConfiguration\("meld"\)\.get\("(\w+)"\)', code)},
                         set(contributes["configuration"]["properties"]))
        # The server's own command has another name: the library registers that.
        self.assertIn('kProfileCommand = "meld.profile"', (ROOT / "compiler/lsp/protocol.h").read_text())
        self.assertIn('command: "meld.profile"', code)
        self.assertEqual(package["activationEvents"], [f"onDebugResolve:{d['type']}" for d in contributes["debuggers"]])
        for name in re.findall(r'require\("\./(\w+)"\)', code):
            self.assertTrue((self.FOLDER / f"{name}.js").is_file())

    def test_versions_are_that_of_claymeld(self):
        version = re.search(r'kVersion\[\] = "([^"]+)"', (ROOT / "runtime/base/version.h").read_text())[1]
        self.assertEqual(json.loads((self.FOLDER / "package.json").read_text())["version"], version)
        lexer = (ROOT / "editors/pygments/pyproject.toml").read_text()
        self.assertEqual(re.search(r'^version = "([^"]+)"', lexer, re.MULTILINE)[1], version)

    def test_words_are_those_of_the_language(self):
        configuration = json.loads((self.FOLDER / "language-configuration.json").read_text())
        word = re.compile(configuration["wordPattern"])
        for text, first in (("a-b(X)", "a-b"), ("A-B", "A"), ("new-neighbor-belief", "new-neighbor-belief"), ("setColor2(X)", "setColor2"),
                            ("0.5.", "0.5"), ("is-it? ", "is-it?")):
            self.assertEqual(word.match(text)[0], first)


if __name__ == "__main__":
    main("meldc")
