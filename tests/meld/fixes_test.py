"""The fixes of messages, tried on every program of the file tests: each is applied alone, its message must be gone, and no other error may
have come. And the table fixes.toml says of every code whether a fix exists.

    fixes_test.py --meldc PATH
"""
import argparse
import collections
import itertools
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib

HERE = pathlib.Path(__file__).resolve().parent
KINDS = HERE.parents[1] / "compiler/diagnostics/kinds.def"


def check(meldc, folder, paths, *options):
    """The messages of these programs, by program. Those with other files are checked alone, since a message in such a file names that."""
    alone = [path for path in paths if re.search(rb"^\s*#?(include|import|use)\b", (folder / path).read_bytes(), re.M)]
    together = sorted(set(paths) - set(alone))
    found = collections.defaultdict(list)
    for group in [together] + [[path] for path in alone]:
        if not group:
            continue
        done = subprocess.run([meldc, "check", "--json", "--all", *options, *map(str, group)], cwd=folder, stdin=subprocess.DEVNULL,
                              capture_output=True, timeout=120)
        if done.returncode not in (0, 1):
            sys.exit(f"meldc ends with {done.returncode}: {done.stderr.decode()}")
        for message in json.loads(done.stdout):
            found[group[0] if group != together else message["path"]].append(message)
    return found


def apply(text, edits):
    """Bytes with the edits, whose columns count bytes from 1."""
    starts = [0]
    for line in text.split(b"\n"):
        starts.append(starts[-1] + len(line) + 1)
    place = lambda line, column: starts[line - 1] + column - 1
    spans = sorted((place(e["line"], e["column"]), place(e["end_line"], e["end_column"]), e["text"].encode()) for e in edits)
    for (_, end, _), (begin, _, _) in zip(spans, spans[1:]):
        assert end <= begin, "edits of one fix overlap"
    for begin, end, new in reversed(spans):
        text = text[:begin] + new + text[end:]
    return text


def counted(messages):
    return collections.Counter((m["code"], m["message"]) for m in messages)


def errors(messages):
    return counted(m for m in messages if m["severity"] == "error")


class Variant:
    """A program after one fix of one of its messages."""

    def __init__(self, folder, number, program, message, fix):
        self.program, self.message, self.fix = program, message, fix
        # Beside it, so that what it includes is found.
        own = [e for e in fix["edits"] if e["path"] == program]
        if own == fix["edits"]:
            self.path = str(pathlib.Path(program).with_name(f"fixed{number}.meld"))
        else:
            place = folder / f"fixed{number}"
            shutil.copytree(folder / pathlib.Path(program).parent, place, ignore=shutil.ignore_patterns("fixed*"))
            self.path = f"fixed{number}/{pathlib.Path(program).name}"
        for path in {e["path"] for e in fix["edits"]}:
            inside = pathlib.Path(path).relative_to(pathlib.Path(program).parent)
            target = folder / (self.path if path == program else pathlib.Path(self.path).parent / inside)
            target.write_bytes(apply((folder / path).read_bytes(), [e for e in fix["edits"] if e["path"] == path]))

    def wrong(self, before, after):
        key = (self.message["code"], self.message["message"])
        problems = []
        if counted(after)[key] >= counted(before)[key]:
            problems.append("the message is still there")
        new = errors(after) - errors(before)
        problems += [f"a new error: {code} {text}" for code, text in new]
        return problems

    def __str__(self):
        place = f"{self.message['path']}:{self.message['line']}"
        return f"{self.program} ({place}): {self.message['code']} {self.message['message']}\n  {self.fix['title']}"


def copied(folder):
    """The programs of the file tests, in a copy."""
    shutil.copytree(HERE, folder, dirs_exist_ok=True, ignore=shutil.ignore_patterns("*.py", "__pycache__"))
    return sorted(str(p.relative_to(folder)) for p in folder.rglob("*.meld") if p.parent.name != "parts")


def with_comments(text):
    """The program with numbered comments: in every gap outside round and square brackets, and at a line end behind every comma there.
    A hint that goes takes those in it along, so it gets none."""
    number = itertools.count()
    depth = 0
    out = []
    texts = rb'"(?:[^"\\\n]|\\.)*"|//[^\n]*|/\*.*?\*/'
    lines = rb"(?m:^[ \t]*(?:[#%]|--)[^\n]*|^(?:priority|prio|index|compact|data|allocator)\b[^.]*)"
    for part in re.findall(texts + rb"|" + lines + rb"|, *|(?<=\S) +(?=\S)|.", text, re.S):
        depth += part.startswith((b"(", b"[")) - part.startswith((b")", b"]"))
        if depth == 0 and part.startswith(b","):
            part = b", // %d,\n        " % next(number)
        elif depth == 0 and part.isspace() and b"\n" not in part:
            part = b" /* %d, */ " % next(number)
        out.append(part)
    return b"".join(out)


def numbers(text):
    return [int(n) for n in re.findall(rb"(?:/\*|//) (\d+),", text)]


def check_safe_fixes(meldc, change=lambda text: text):
    """All together, as --fix applies them: none is left, they make no error, and lose no comment."""
    with tempfile.TemporaryDirectory(prefix="meld-fixes-") as name:
        folder = pathlib.Path(name)
        programs = copied(folder)
        for path in programs:
            (folder / path).write_bytes(change((folder / path).read_bytes()))
        texts = {path: (folder / path).read_bytes() for path in programs}
        before = check(meldc, folder, programs)
        subprocess.run([meldc, "check", "--fix", "--json", *programs], cwd=folder, stdin=subprocess.DEVNULL, capture_output=True,
                       timeout=120)
        safe = {m["path"] for messages in before.values() for m in messages if any(fix["safe"] for fix in m["fixes"])}
        after = check(meldc, folder, programs)
        wrong = [f"only {len(safe)} programs have safe fixes"] if len(safe) < 15 else []
        for program in programs:
            text = (folder / program).read_bytes()
            if (text != texts[program]) != (program in safe):
                wrong.append(f"{program}: --fix {'changes' if text != texts[program] else 'leaves'} it")
            if numbers(text) != numbers(texts[program]):
                wrong.append(f"{program}: --fix loses comments {sorted(set(numbers(texts[program])) - set(numbers(text)))}")
            wrong += [f"{program}: --fix leaves {m['code']} {m['message']}" for m in after[program] if any(f["safe"] for f in m["fixes"])]
            wrong += [f"{program}: --fix makes {code} {text}" for code, text in errors(after[program]) - errors(before[program])]
    return wrong


def check_fixes(meldc, table):
    wrong = []
    with tempfile.TemporaryDirectory(prefix="meld-fixes-") as name:
        folder = pathlib.Path(name)
        programs = copied(folder)
        before = check(meldc, folder, programs)
        variants = [Variant(folder, number, program, message, fix)
                    for number, (program, message, fix) in enumerate(
                        (program, message, fix) for program in programs for message in before[program] for fix in message["fixes"])]
        after = check(meldc, folder, [variant.path for variant in variants])
        for variant in variants:
            hidden = table["hidden"].get(variant.program, {})
            problems = [p for p in variant.wrong(before[variant.program], after[variant.path])
                        if not any(p.startswith(f"a new error: {code}") for code in hidden)]
            if problems:
                wrong.append(f"{variant}: {'; '.join(problems)}")
        if len(variants) < 100:
            wrong.append(f"only {len(variants)} fixes were tried")
    return wrong, {variant.message["code"] for variant in variants}, len(variants)


def check_table(table, fixed):
    codes = set(re.findall(r'^MELD_KIND\(\w+, "(\w+)"', KINDS.read_text(), re.M))
    with_fix, without = set(table["fix"]), set(table["none"])
    wrong = [f"fixes.toml does not say whether {code} has a fix" for code in sorted(codes - with_fix - without)]
    wrong += [f"fixes.toml has {code} twice" for code in sorted(with_fix & without)]
    wrong += [f"there is no code {code}" for code in sorted((with_fix | without) - codes)]
    wrong += [f"no program shows a fix of {code}" for code in sorted(with_fix - fixed)]
    wrong += [f"{code} has a fix, and fixes.toml says that it has none" for code in sorted(fixed & without)]
    return wrong if codes else ["kinds.def has no codes"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--meldc", required=True)
    options = parser.parse_args()
    table = tomllib.loads((HERE / "fixes.toml").read_text())
    wrong, fixed, count = check_fixes(options.meldc, table)
    wrong += check_table(table, fixed) + check_safe_fixes(options.meldc) + check_safe_fixes(options.meldc, with_comments)
    print("\n".join(wrong) or f"{count} fixes of {len(fixed)} codes")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
