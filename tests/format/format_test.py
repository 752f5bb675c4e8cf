"""The formatter as a user meets it. What it must keep is found here without its code: tokens as `meldc compile --emit=tokens`
prints them, comments by the regular expression below.

    format_test.py --meldc PATH [--update] [unittest options]

golden/NAME.in is formatted to golden/NAME.meld; --update writes the latter anew.
"""
import os
import pathlib
import random
import re
import stat
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

import frame  # noqa: E402
from frame import TOOLS, main  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
GOLDEN = pathlib.Path(__file__).resolve().parent / "golden"
STRING_OR_COMMENT = re.compile(r'"(?:\\.|[^"\\\n])*"?|//[^\n]*|;;[^\n]*|/\*')


def meldc(*arguments, text=None, cwd=None):
    done = subprocess.run([TOOLS.meldc, *map(str, arguments)], input=text, capture_output=True, cwd=cwd, timeout=120, encoding="utf-8",
                          errors="surrogateescape")
    return done.returncode, done.stdout, done.stderr


def formatted(text):
    code, out, err = meldc("fmt", "-", text=text)
    return out if code == 0 else None


def comments_of(text):
    """(start, end) of each comment."""
    found, at = [], 0
    while match := STRING_OR_COMMENT.search(text, at):
        at = match.end()
        if match[0] == "/*":
            depth = 1
            while depth and at < len(text):
                depth += {"/*": 1, "*/": -1}.get(text[at:at + 2], 0)
                at += 2 if text[at:at + 2] in ("/*", "*/") else 1
        if match[0][0] != '"':
            found.append((match.start(), at))
    return found


def trimmed(comment):
    return "\n".join(line.rstrip() for line in comment.split("\n"))


class Tokens:
    """The tokens of a text with their offsets, as the compiler prints them."""

    def __init__(self, text, folder):
        path = folder / "tokens.meld"
        path.write_text(text)
        _, out, _ = meldc("compile", path, "--emit=tokens")
        starts = [0]
        for line in text.split("\n"):
            starts.append(starts[-1] + len(line) + 1)
        self.list = []
        for line in out.splitlines():
            match = re.match(r"(\d+):(\d+) (\w+) ?(.*)$", line)
            # Columns count bytes.
            row = text[starts[int(match[1]) - 1]:starts[int(match[1])]]
            column = len(row.encode()[:int(match[2]) - 1].decode())
            self.list.append((starts[int(match[1]) - 1] + column, match[3], match[4]))

    def kinds(self):
        return [(kind, text.replace(" ", "").replace("\t", "") if kind == "NeighbourOpen" else text) for _, kind, text in self.list]

    def with_comments(self, text):
        """Tokens and comments in their order."""
        comments = [(start, "comment", trimmed(text[start:end])) for start, end in comments_of(text)]
        both = sorted([(place, *rest) for (place, *_), rest in zip(self.list, self.kinds())] + comments,
                      key=lambda piece: (piece[0], piece[1] == "End"))
        return [rest for _, *rest in both]


def programs():
    for folder in ("examples", "stdlib", "tests", "docs"):
        yield from sorted(path for path in (ROOT / folder).rglob("*.meld") if "__pycache__" not in path.parts)


class Case(frame.Case):
    maxDiff = 4000

    def keeps_everything(self, text, name):
        """Formats the text; checks that the result has its tokens and comments and does not change again."""
        code, out, err = meldc("fmt", "-", text=text)
        self.assertEqual(code, 0, f"{name}: {err}\n{text}")
        self.assertEqual(Tokens(text, self.folder).with_comments(text), Tokens(out, self.folder).with_comments(out), f"{name}\n{out}")
        self.assertEqual(formatted(out), out, f"{name} is not stable")
        self.assertNotRegex(out, r"[ \t]\n|\n\n\n|^\n|\n\n$", f"{name}: blanks")
        return out


class Golden(Case):
    def test_golden_files(self):
        names = sorted(GOLDEN.glob("*.in"))
        self.assertGreaterEqual(len(names), 3)
        for path in names:
            result = self.keeps_everything(path.read_text(), path.name)
            expected = path.with_suffix(".meld")
            if TOOLS.update:
                expected.write_text(result)
            self.assertEqual(result, expected.read_text(), path.name)

    def test_no_line_of_the_golden_files_is_too_long(self):
        for path in GOLDEN.glob("*.meld"):
            for line in path.read_text().splitlines():
                self.assertLessEqual(len(line.split("  //")[0]), 120, line)


class Programs(Case):
    def test_every_program_keeps_its_tokens_and_comments(self):
        count = 0
        for path in programs():
            try:
                text = path.read_bytes().decode()
            except UnicodeDecodeError:
                continue
            code, _, err = meldc("fmt", "-", text=text)
            if code == 1 and "error[E01" in err:
                self.assertTrue(path.name.startswith("fail_") or path.name == "wrong.meld", f"{path}: {err}")
                continue
            self.keeps_everything(text, path)
            count += 1
        self.assertGreater(count, 60)

    def test_comments_may_stand_between_any_two_tokens(self):
        for path in [*sorted((ROOT / "examples").rglob("*.meld")), *sorted(GOLDEN.glob("*.meld"))]:
            generator = random.Random(f"20 {path.name}")  # Whatever other files there are.
            text = path.read_text()
            tokens = Tokens(text, self.folder).list
            for share in (0.02, 0.3):
                result, last, before = "", 0, "Period"
                for number, (place, kind, _) in enumerate(tokens):
                    result += text[last:place]
                    last = place
                    # A word of a declaration as far left as its start would be taken for the next one, whose full stop is missing.
                    line_end = "\n" if before == "Period" else "\n" + 40 * " "
                    if generator.random() < share:
                        # The path of `include #file` ends at a blank only.
                        result += " " if before == "IncludePath" else ""
                        # Behind a slash a comment needs a blank: `//` starts another one.
                        result += " " if result.endswith("/") else ""
                        result += generator.choice([f"/* {number} */", f" /* {number} */ ", f"// {number}{line_end}",
                                                    f"\n// {number}{line_end}", "/**/",
                                                    f"\n\n/* {number}\n  * /* in */ */{line_end}", f";; {number}{line_end}"])
                    before = kind
                self.keeps_everything(result + text[last:], path)

    def test_another_layout_changes_nothing_but_the_layout(self):
        generator = random.Random(21)
        for path in [*sorted((ROOT / "examples").rglob("*.meld")), *sorted(GOLDEN.glob("*.meld"))]:
            text = path.read_text()
            for start, end in reversed(comments_of(text)):
                text = text[:start] + text[end:]
            tokens = Tokens(text, self.folder)
            ends = [place for place, *_ in tokens.list[1:]]
            loose, flat = "", ""
            for (place, kind, _), end in zip(tokens.list, ends):
                word = text[place:end].strip()
                # A line's end inside an item may mean something where a full stop is forgotten; between items it never does.
                loose += word + generator.choice([" ", "  ", "\t"]) + ("\n" * generator.randint(0, 3) if kind == "Period" else "")
                flat += word + " "
            loose, flat = self.keeps_everything(loose, path), self.keeps_everything(flat, path)
            self.assertEqual(re.sub(r"\s+", "", loose), re.sub(r"\s+", "", flat))


class Command(Case):
    UGLY = "type p(node).p(A):-p(A) .\n"
    NEAT = "type p(node).\np(A) :- p(A).\n"

    def test_what_people_read_is_formatted(self):
        paths = sorted(path for folder in ("examples", "stdlib") for path in (ROOT / folder).rglob("*.meld"))
        self.assertGreater(len(paths), 20)
        code, out, err = meldc("fmt", "--check", *paths)
        self.assertEqual((code, out + err), (0, ""))

    def test_a_file_is_replaced_with_its_permissions(self):
        path = self.write("ugly.meld", self.UGLY)
        path.chmod(0o640)
        code, out, err = meldc("fmt", path)
        self.assertEqual((code, out, err), (0, "", f"{path}: formatted\n"))
        self.assertEqual(path.read_text(), self.NEAT)
        self.assertEqual(stat.S_IMODE(path.stat().st_mode), 0o640)
        self.assertEqual(os.listdir(self.folder), ["ugly.meld"])
        self.assertEqual(meldc("fmt", path), (0, "", ""))

    def test_through_a_link_the_file_is_replaced(self):
        path = self.write("ugly.meld", self.UGLY)
        link = self.folder / "link.meld"
        link.symlink_to("ugly.meld")
        self.assertEqual(meldc("fmt", link)[0], 0)
        self.assertTrue(link.is_symlink())
        self.assertEqual(path.read_text(), self.NEAT)

    def test_check_names_the_files_that_would_change(self):
        ugly, neat = self.write("ugly.meld", self.UGLY), self.write("neat.meld", self.NEAT)
        self.assertEqual(meldc("fmt", "--check", ugly, neat), (1, f"{ugly}\n", ""))
        self.assertEqual(meldc("fmt", "--check", neat), (0, "", ""))
        self.assertEqual(ugly.read_text(), self.UGLY)

    def test_stdout_and_stdin(self):
        path = self.write("ugly.meld", self.UGLY)
        self.assertEqual(meldc("fmt", "--stdout", path), (0, self.NEAT, ""))
        self.assertEqual(path.read_text(), self.UGLY)
        self.assertEqual(meldc("fmt", "-", text=self.UGLY), (0, self.NEAT, ""))
        self.assertEqual(meldc("fmt", "-", text=""), (0, "", ""))

    def test_a_file_with_mistakes_is_left_alone_and_the_others_are_not(self):
        wrong, ugly = self.write("wrong.meld", "type p(node).\np(A) :- .  q( (A).\n"), self.write("ugly.meld", self.UGLY)
        before = wrong.read_text()
        code, out, err = meldc("fmt", wrong, ugly)
        self.assertEqual((code, out), (1, ""))
        self.assertIn("error[E0110]", err)
        self.assertEqual(wrong.read_text(), before)
        self.assertEqual(ugly.read_text(), self.NEAT)

    def test_mistakes_of_meaning_and_missing_includes_are_no_obstacle(self):
        self.assertEqual(formatted('include "nowhere.meld".p(A):-unknown(A,X).'), 'include "nowhere.meld".\np(A) :- unknown(A, X).\n')

    def test_a_file_that_cannot_be_read(self):
        code, _, err = meldc("fmt", self.folder / "missing.meld")
        self.assertEqual(code, 2)
        self.assertIn("missing.meld", err)

    def test_line_ends_and_marks_of_other_systems(self):
        self.assertEqual(formatted("\ufefftype p(node).\r\n\r\n\r\n// c\r\np(A):-p(A).\r\n"), "type p(node).\n\n// c\np(A) :- p(A).\n")

    def test_a_long_program_takes_no_time(self):
        rule = "p(A, 1) :- " + ", ".join(f"p(A, {i})" for i in range(20000)) + ".\n"
        out = formatted("type p(node, int).\n" + rule + "".join(f"p(A, {i}) :- p(A, {i + 1}).\n" for i in range(20000)))
        self.assertLessEqual(max(map(len, out.splitlines())), 120)


if __name__ == "__main__":
    main("meldc", update={"action": "store_true"})
