"""Every data member of a run has an entry that says where a snapshot finds it, or why it needs none: members_test.py ROOT.

The entries are in members.toml and members_of_bodies.toml.

Whoever adds a member, or a module that acts in every tick, is asked here whether snapshots know of it.
docs/reference/internals.md, "The state of a run", lists the same by where it is stored.
"""

import pathlib
import re
import sys
import tomllib

# What an entry may begin with.
KINDS = ("saved", "given", "derived", "tick", "output", "figure", "none")


def without_comments(text):
    return re.sub(r"//[^\n]*", "", re.sub(r"/\*.*?\*/", "", text, flags=re.S))


def body_of(text, name):
    """What stands between the braces of a class."""
    found = re.search(r"\b(?:class|struct)\s+(?:alignas\(\w+\)\s+)?" + re.escape(name) + r"\b[^;{(]*\{", text)
    if not found:
        return None
    depth, start = 1, found.end()
    for i in range(start, len(text)):
        depth += {"{": 1, "}": -1}.get(text[i], 0)
        if depth == 0:
            return text[start:i]
    return None


def statements(body):
    """Those of the class itself; what stands in inner braces is left out."""
    depth, statement = 0, ""
    for character in body:
        if character == "{":
            depth += 1
            statement += "{" if depth == 1 else ""
        elif character == "}":
            depth -= 1
            if depth == 0 and re.search(r"\)[^=]*\{$|^\s*(?:class|struct|enum|union)\b.*\{$", statement, flags=re.S):
                # A function ends here; a type may declare a member after its braces.
                statement = "struct " if not re.search(r"\)[^=]*\{$", statement, flags=re.S) else ""
        elif depth == 0 and character == ";":
            yield statement.strip()
            statement = ""
        elif depth == 0:
            statement += character
            statement = re.sub(r"^\s*(?:public|private|protected)\s*:", "", statement)


def members(body):
    for statement in statements(body):
        if re.match(r"(?:using|friend|typedef|template|static|enum|class|struct \w+$)\b", statement) or statement in ("", "struct"):
            continue
        text = re.sub(r"\{$|\{(?=,)", "", statement)
        while re.search(r"<[^<>]*>", text):
            text = re.sub(r"<[^<>]*>", "", text)
        text = re.sub(r"=[^,]*", "", text)
        if "(" in text or "operator" in text or not re.search(r"\s", text.strip()):
            continue
        for part in text.split(","):
            name = re.search(r"(\w+)\s*(?:\[[^\]]*\]\s*)*\{?$", part.strip())
            if name:
                yield name.group(1)


def modules(root):
    """Classes that act in a run: those that derive from SimModule or Component."""
    for path in sorted((root / "runtime").rglob("*.h")) + sorted((root / "runtime").rglob("*.cpp")):
        for name in re.findall(r"class (\w+)[^;{]*: public (?:sim::)?(?:SimModule|Component)\b", without_comments(path.read_text())):
            if name != "Component":
                yield name, path.relative_to(root)


def main():
    root = pathlib.Path(sys.argv[1])
    table = {}
    for file in ("members.toml", "members_of_bodies.toml"):
        table |= tomllib.loads((pathlib.Path(__file__).parent / file).read_text())
    problems = []
    for name, path in modules(root):
        if name not in table:
            problems.append(f"{path}: {name} acts in a run, and tests/state/members.toml has no table of its members")
    for name, entries in table.items():
        path = root / entries.pop("file")
        # A table may say the namespace of a class whose name two have.
        text = without_comments(path.read_text())
        body = body_of(text, name) or body_of(text, name.split("::")[-1])
        if body is None:
            problems.append(f"{path.relative_to(root)} has no class {name}")
            continue
        found = set(members(body))
        if not found and entries:
            problems.append(f"{path.relative_to(root)}: {name} has no members that could be read")
        for member in sorted(found - set(entries)):
            problems.append(f"{path.relative_to(root)}: {name}::{member} is not in tests/state/members.toml: is it saved, or why not?")
        for member in sorted(set(entries) - found):
            problems.append(f"tests/state/members.toml: {name} has no member {member}")
        for member, why in entries.items():
            if why.split(":")[0] not in KINDS:
                problems.append(f"tests/state/members.toml: {name}::{member} begins with none of {', '.join(KINDS)}")
    print("\n".join(problems) if problems else f"{len(table)} classes")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
