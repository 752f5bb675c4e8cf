"""Operators in a row, as many as one likes, of every kind that operators.def has: chains_test.py --meldc PATH --meldsim PATH --many N"""
import itertools
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from frame import CAMPAIGN, TOOLS, Case, main, square  # noqa: E402

OPERATORS = pathlib.Path(__file__).resolve().parents[2] / "compiler" / "syntax" / "operators.def"
LEVELS = re.findall(r'^MELD_BINARY\(\w+, +"([^"]+)", +(\w+), ', OPERATORS.read_text(), re.MULTILINE)
# What is compiled and run; --many says what is checked.
RUN = 1500 if CAMPAIGN else 330


def repeated(words, count):
    return itertools.islice(itertools.cycle(words), count)


class Chain:
    """An expression of X, an int, and F, a float; its type and its value for these."""

    def __init__(self, kind, text, value):
        self.kind, self.text, self.value = kind, text, value


def chains(count):
    """For each level, and for ::."""
    def numbers(signs, first, operands, apply):
        text, value = [first[0]], first[1]
        for sign, (word, number) in zip(itertools.cycle(signs), repeated(operands, count - 1)):
            text += [sign, word]
            value = apply(sign, value, number)
        return " ".join(text), value

    x, f = 7, 0.5

    def whole(sign, a, b):
        return {"+": a + b, "-": a - b, "*": a * b, "/": int(a / b) if b else 0, "%": a % b if b else 0}[sign]

    def real(sign, a, b):
        return {"+": a + b, "-": a - b, "*": a * b, "/": a / b if b else 0}[sign]

    found = {
        "Or": [Chain("bool", " || ".join([*repeated(["X < 0", "X = 3"], count - 1), "X = 7"]), "true"),
               Chain("bool", " || ".join(repeated(["X < 0", "X = 3"], count)), "false"),
               Chain("bool", " || ".join(["X = 7", *repeated(["1 / (X - 7) = 0"], count - 1)]), "true")],
        "And": [Chain("bool", " && ".join([*repeated(["X > 0", "X <> 3"], count - 1), "X = 8"]), "false"),
                Chain("bool", " && ".join(repeated(["X > 0", "X <> 3 || X = 3"], count)), "true"),
                Chain("bool", " || ".join(repeated(["X > 0 && X = 3", "X < 0"], count)), "false")],
        "Append": [Chain("string", " ++ ".join(["\"a\"", *repeated(["int2str(X)", "\"b\""], count - 1)]),
                         '"a' + "".join(repeated(["7", "b"], count - 1)) + '"'),
                   Chain("int", "llength(" + " ++ ".join(repeated(["[X]", "[]", "[1, 2]"], count)) + ")",
                         str(sum(repeated([1, 0, 2], count))))],
        "Cons": [Chain("int", "lsum(" + " :: ".join([*repeated(["X", "1"], count - 1), "[2]"]) + ")",
                       str(sum(repeated([7, 1], count - 1)) + 2)),
                 Chain("int", "llength(" + " :: ".join([*repeated(["X", "1"], count - 1), "ltail([X, 2])"]) + ")", str(count))],
    }
    signs = {level: [sign for sign, of in LEVELS if of == level] for level in ("Add", "Multiply")}
    text, value = numbers(signs["Add"], ("X", x), [("1", 1), ("X", x), ("2", 2)], whole)
    sums = [Chain("int", text, str(value))]
    text, value = numbers(signs["Add"][:1], ("F", f), [("0.1", 0.1), ("F", f), ("1e-9", 1e-9)], real)
    sums.append(Chain("float", text, repr(value)))
    found["Add"] = sums
    text, value = numbers(["*", "/"], ("X", x), [("3", 3), ("3", 3), ("X", x), ("X", x)], whole)
    products = [Chain("int", text, str(value))]
    text, value = numbers(["*", "/"], ("F", f), [("0.3", 0.3), ("0.7", 0.7), ("F", f), ("1.1", 1.1)], real)
    products.append(Chain("float", text, repr(value)))
    text, value = numbers(["+", "*"], ("X", x), [("X", x), ("1", 1)], lambda sign, a, b: a + b if sign == "+" else a)
    products.append(Chain("int", text, str(value)))
    found["Multiply"] = products
    return found


def program(all_of):
    lines = ["type given(node, int, float).", "given(@0, 7, 0.5)."]
    for i, chain in enumerate(all_of):
        lines += [f"type r{i}(node, {chain.kind}).", f"r{i}(A, {chain.text}) :- given(A, X, F)."]
        if chain.kind == "bool":
            lines += [f"type c{i}(node).", f"c{i}(A) :- given(A, X, F), {chain.text}."]
    return "\n".join(lines) + "\n"


class Chains(Case):
    FILES = {"w.toml": square(1)}

    def test_every_level_that_chains_is_here(self):
        """The others need brackets, or stand alone: comparisons, and powers, which read from the right."""
        self.assertEqual({level for _, level in LEVELS} - {"Compare", "Power"} | {"Cons"}, set(chains(2)))

    def test_they_compute_what_they_say(self):
        all_of = [chain for level in chains(RUN).values() for chain in level]
        self.write("p.meld", program(all_of))
        out, _ = self.call("meldsim", "run", "p.meld", "--world", "w.toml", "--quiet", "--facts-out", "-", seconds=170)
        facts = set(out.splitlines())
        for i, chain in enumerate(all_of):
            value = chain.value
            self.assertIn(f"r{i}(@0, {value}).", facts, chain.text[:60])
            if chain.kind == "bool":
                self.assertEqual(f"c{i}(@0)." in facts, value == "true", chain.text[:60])

    def test_very_many_are_checked_and_formatted(self):
        for level, some in chains(TOOLS.many).items():
            with self.subTest(level):
                self.write("p.meld", program(some))
                self.call("meldc", "check", "p.meld")
                self.call("meldc", "compile", "p.meld", "--emit=cpp")
                formatted, _ = self.call("meldc", "fmt", "--stdout", "p.meld")
                self.assertEqual(re.sub(r"\s", "", formatted), re.sub(r"\s", "", program(some)))

    def test_one_that_breaks_off_is_reported(self):
        for sign in ("+", "&&", "++", "::"):
            self.write("p.meld", "type p(node, int).\np(A, " + f" {sign} ".join(["X"] * TOOLS.many) + f" {sign} ) :- p(A, X).\n")
            _, err = self.call("meldc", "check", "p.meld", code=1)
            self.assertIn("E0110", err)

    def test_types_are_checked_in_them(self):
        self.write("p.meld", "type p(node, int).\np(A, " + " + ".join(["X"] * 500 + ['"a"'] + ["X"] * 500) + ") :- p(A, X).\n")
        _, err = self.call("meldc", "check", "p.meld", code=1)
        self.assertIn("`+` cannot combine int and string", err)
        self.write("p.meld", "type p(node, string).\np(A, " + " ++ ".join(["X"] * 500 + ["1"] + ["X"] * 500) + ") :- p(A, X).\n")
        _, err = self.call("meldc", "check", "p.meld", code=1)
        self.assertIn("`++` cannot combine string and int", err)

    def test_what_nests_is_refused(self):
        deep = {"(": ("(1 + ", ")"), "~": ("~", ""), "^": ("2 ^ ", ""), "1 + ~": ("1 + ~ ", ""), "if": ("if true then 1 else ", " end"),
                "let": ("let Y = ", " in Y end"), "[": ("[", "]"), "f(": ("abs(", ")"), "chains": ("(" + "X + " * 100, ")")}
        for name, (before, after) in deep.items():
            for count in (1200, 50000):
                with self.subTest(name, count=count):
                    self.write("p.meld", "type p(node, int).\np(A, " + before * count + "X" + after * count + ") :- p(A, X).\n")
                    _, err = self.call("meldc", "check", "p.meld", code=1)
                    self.assertIn("E0112", err)


if __name__ == "__main__":
    main("meldc", "meldsim", many={"type": int, "default": 30000, "help": "how many operators are checked in a row"})
