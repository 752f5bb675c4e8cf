"""What meldsim answers to questions about a run: ways to satisfy a body, trees of why, histories."""

from __future__ import annotations

import html
from typing import Any, Iterator, Optional

import pandas

from .data.tables import NUMBERS
from .tool.calls import Path, ask


def body_word(body: str) -> str:
    """As a word of a command: what begins with a hyphen would be an option."""
    return f" {body}" if body.startswith("-") else body


def query(target: str, body: str, *words: Any, meldsim: Optional[Path] = None) -> pandas.DataFrame:
    """All ways to satisfy a body, a column for each variable. `attrs` has "tick", "types" in Meld by variable, and "left_out": how many
    ways lack a value, as after a division by zero."""
    answer = ask(["query", target, *map(str, words), body_word(body)], meldsim=meldsim)
    columns: dict[str, Any] = {}
    for number, column in enumerate(answer["columns"]):
        name, kind = column["name"], column["type"]
        cells = [row[number] for row in answer["rows"]]
        if kind == "vec3":
            columns.update((f"{name}.{axis}", pandas.Series([cell[place] for cell in cells], dtype="float64"))
                           for place, axis in enumerate("xyz"))
        else:
            columns[name] = pandas.Series([_value(cell, kind) for cell in cells], dtype=NUMBERS.get(kind, "object"))
    frame = pandas.DataFrame(columns)
    frame.attrs.update(tick=answer["tick"], types={column["name"]: column["type"] for column in answer["columns"]},
                       left_out=answer.get("left_out", {}).get("count", 0))
    return frame


def _value(cell: Any, kind: str) -> Any:
    """What JSON holds, as `claymeld.value` reads it from text: structs, tuples and vec3 are tuples, sets frozensets."""
    if kind.startswith("set "):
        return frozenset(_hashable(_value(item, kind[4:])) for item in cell)
    if kind.startswith("list "):
        return [_value(item, kind[5:]) for item in cell]
    if kind.startswith(":(") and kind.endswith(")"):
        return tuple(_value(item, part) for item, part in zip(cell, _parts(kind[2:-1])))
    if isinstance(cell, list):
        return [_value(item, "") for item in cell] if kind.startswith("array") else tuple(_value(item, "") for item in cell)
    return cell


def _parts(text: str) -> list[str]:
    """The types in a tuple, which may have commas themselves."""
    parts, depth = [""], 0
    for c in text:
        depth += (c == "(") - (c == ")")
        if c == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += c
    return [part.strip() for part in parts]


def _hashable(item: Any) -> Any:
    return tuple(map(_hashable, item)) if isinstance(item, (list, tuple)) else item


class Why:
    """Why a fact holds, or does not: a tree of facts, rules and what they rest on.

    It is true if there is an answer. `str()` and notebooks show it; `roots` are the places in `nodes` where it begins; what a node and
    a way have is listed in docs/reference/debugging.md, "JSON".
    """

    def __init__(self, answer: dict[str, Any]) -> None:
        self.answer = answer
        self.fact: str = answer.get("why", answer.get("why_not", ""))
        self.tick: int = answer["tick"]
        self.roots: list[int] = answer["roots"]
        self.nodes: list[dict[str, Any]] = answer["nodes"]

    def __bool__(self) -> bool:
        return bool(self.roots)

    def __repr__(self) -> str:
        return f"<Why {self.fact} in tick {self.tick}: {len(self.nodes)} nodes>"

    def facts(self) -> list[str]:
        """All facts of the tree, each once."""
        return list(dict.fromkeys(node["fact"] for node in self.nodes))

    def __str__(self) -> str:
        if not self.roots:
            says = "does not hold" if "why" in self.answer else "holds"
            return f"{self.fact}  {says} in tick {self.tick}"
        return "\n".join(line for root in self.roots for line in self._lines(root, "", set()))

    def _title(self, node: dict[str, Any]) -> str:
        words = [node["fact"], {"derived": "", "missing": "does not hold"}.get(node["is"], node["is"])]
        words += [f"rank {node['rank']}"] if "rank" in node else []
        words += [node["note"]] if node.get("note") else []
        return "  ".join(word for word in words if word)

    @staticmethod
    def _rule(way: dict[str, Any]) -> str:
        return f"{way['file']}:{way['line']}: {way['text']}" if "file" in way else str(way.get("note", ""))

    def _lines(self, place: int, indent: str, above: set[int]) -> Iterator[str]:
        node = self.nodes[place]
        yield indent + self._title(node)
        if place in above:
            return
        for way in node.get("ways", []):
            yield f"{indent}  {self._rule(way)}"
            for part in way.get("parts", []):
                if "node" in part:
                    yield from self._lines(part["node"], indent + "    ", above | {place})
                else:
                    yield f"{indent}    {_part(part)}"

    def _repr_html_(self) -> str:
        if not self.roots:
            return f"<p><code>{html.escape(str(self))}</code></p>"
        return '<div style="font-family: monospace">' + "".join(self._html(root, 0, set()) for root in self.roots) + "</div>"

    def _html(self, place: int, depth: int, above: set[int]) -> str:
        node = self.nodes[place]
        title = html.escape(self._title(node))
        if place in above or not node.get("ways"):
            return f'<div style="margin-left: 2.2em">{title}</div>'
        inner = ""
        for way in node["ways"]:
            inner += f'<div style="margin-left: 1.1em; opacity: 0.65">{html.escape(self._rule(way))}</div>'
            for part in way.get("parts", []):
                inner += (self._html(part["node"], depth + 1, above | {place}) if "node" in part
                          else f'<div style="margin-left: 2.2em">{html.escape(_part(part))}</div>')
        return f'<details style="margin-left: 1.1em"{" open" if depth < 3 else ""}><summary>{title}</summary>{inner}</details>'


def _part(part: dict[str, Any]) -> str:
    return {"absent": "absent: ", "fails": "FAILS: "}.get(part["is"], "") + str(part["text"])


def why(command: str, target: str, fact: str, *words: Any, meldsim: Optional[Path] = None) -> Why:
    """Of the commands `why` and `why-not`."""
    return Why(ask([command, target, *map(str, words), body_word(fact)], meldsim=meldsim))


def history(target: str, fact: str, *words: Any, meldsim: Optional[Path] = None) -> pandas.DataFrame:
    """The ticks in which facts came and went, a row for each: "tick", "fact", "change" ("there" at the first tick, "came" or "went"),
    "how", "by" (the fact in its place), and the first rule that did it: "file", "line", "rule"."""
    answer = ask(["history", target, *map(str, words), body_word(fact)], meldsim=meldsim)
    rows: list[dict[str, Any]] = [dict(tick=answer["first_tick"], fact=held, change="there") for held in answer["at_first"]]
    for tick in answer["ticks"]:
        for change in tick["changes"]:
            rule: dict[str, Any] = next(iter(change.get("rules", [])), {})
            rows.append(dict(tick=tick["tick"], fact=change["fact"], change=change["is"], how=change["how"], by=change.get("by"),
                             file=rule.get("file"), line=rule.get("line"), rule=rule.get("text")))
    frame = pandas.DataFrame(rows, columns=["tick", "fact", "change", "how", "by", "file", "line", "rule"])
    return frame.astype({"tick": "int64", "line": "Int64"})
