"""Values of Meld as Python has them, from the text that files hold."""

import re
from typing import Any

ESCAPE = re.compile(rb"\\(x[0-9a-f]{2}|.)", re.DOTALL)
BYTES = {b"n": b"\n", b"t": b"\t", b"r": b"\r"}
TOKEN = re.compile(r'\s*(?:("(?:[^"\\]|\\.)*")|(@\d+)|(true|false)\b|(-?(?:\d[\w.+-]*|inf|nan))|(vec3\(|:\(|[\[\](){},]))')
CLOSING = {"[": "]", "{": "}", "(": ")", ":(": ")", "vec3(": ")"}


def unescaped(text: str) -> str:
    """A string without the escapes of its bytes; bytes that are no UTF-8 as Python's surrogate escapes."""
    if "\\" not in text:
        return text

    def byte(match: re.Match[bytes]) -> bytes:
        code = match[1]
        return bytes([int(code[1:], 16)]) if len(code) == 3 else BYTES.get(code, code)

    return ESCAPE.sub(byte, text.encode("utf-8")).decode("utf-8", "surrogateescape")


def value(text: str) -> Any:
    """What a literal of Meld is in Python: lists and arrays are lists, structs, tuples and vec3 tuples, catoms their numbers, sets
    frozensets, in which lists are tuples."""
    found, end = _value(text, 0)
    if text[end:].strip():
        raise ValueError(f"{text!r} goes on after a value of Meld")
    return found


def _token(text: str, at: int) -> re.Match[str]:
    match = TOKEN.match(text, at)
    if match is None:
        raise ValueError(f"{text!r} is no value of Meld from character {at} on")
    return match


def _value(text: str, at: int) -> tuple[Any, int]:
    match = _token(text, at)
    string, node, truth, number, opening = match.groups()
    at = match.end()
    if string is not None:
        return unescaped(string[1:-1]), at
    if node is not None:
        return int(node[1:]), at
    if truth is not None:
        return truth == "true", at
    if number is not None:
        return (int(number) if number.lstrip("-").isdigit() else float(number)), at
    if opening not in CLOSING:
        raise ValueError(f"{text!r} has {opening} where a value of Meld should be")
    items = []
    while True:
        match = _token(text, at)
        if match[5] == CLOSING[opening]:
            break
        if match[5] == ",":
            at = match.end()
        item, at = _value(text, at)
        items.append(item)
    if opening == "{":
        return frozenset(map(_hashable, items)), match.end()
    return (items if opening == "[" else tuple(items)), match.end()


def _hashable(item: Any) -> Any:
    return tuple(map(_hashable, item)) if isinstance(item, (list, tuple)) else item
