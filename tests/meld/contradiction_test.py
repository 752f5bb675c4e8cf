"""Warnings of conditions that cannot be true together, against trying all small numbers: none may be wrong, few may be missing.

    contradiction_test.py --meldc PATH [--seed N] [--rules N]
"""
import argparse
import itertools
import json
import pathlib
import random
import subprocess
import sys
import tempfile

# Each rule is right for some of these, or, with what terms() makes of them, for no ints at all or only for far larger ones.
NUMBERS = range(-9, 10)
COMPARISONS = {"<": "<", "<=": "<=", ">": ">", ">=": ">=", "=": "==", "<>": "!="}


def number(n):
    return str(n) if n >= 0 else f"(-{-n})"


def term(draw, depth=0):
    """A term in Meld, which is one in Python too."""
    kind = draw.random()
    if kind < 0.15:
        return number(draw.randint(-4, 4))
    if kind < 0.65 or depth > 1:
        return draw.choice("XYZ")
    sign = draw.choice("+-*")
    left = number(draw.randint(-3, 3)) if sign == "*" else term(draw, depth + 1)
    return f"({left} {sign} {term(draw, depth + 1)})"


def condition(draw, depth=0):
    """In Meld and in Python."""
    kind = draw.random()
    if depth < 2 and kind < 0.15:
        (left, left_python), (right, right_python) = condition(draw, depth + 1), condition(draw, depth + 1)
        sign, word = draw.choice([("||", "or"), ("&&", "and")])
        return f"({left} {sign} {right})", f"({left_python} {word} {right_python})"
    if depth < 2 and kind < 0.22:
        inner, inner_python = condition(draw, depth + 1)
        return f"~({inner})", f"(not {inner_python})"
    left, right, sign = term(draw), term(draw), draw.choice(list(COMPARISONS))
    return f"{left} {sign} {right}", f"({left} {COMPARISONS[sign]} {right})"


def rule(draw):
    """A rule, some of whose conditions may stand in a negation, and all of them as one in Python."""
    all_of = [condition(draw) for _ in range(draw.randint(1, 6))]
    inside = draw.randrange(len(all_of)) if draw.random() < 0.5 else len(all_of)
    body = ["p(A, X, Y, Z)"] + [meld for meld, _ in all_of[:inside]]
    if inside < len(all_of):
        body.append("not (p(A, X, Y, Z), " + ", ".join(meld for meld, _ in all_of[inside:]) + ")")
    return "q(A) :- " + ", ".join(body) + ".", " and ".join(python for _, python in all_of)


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("--meldc", required=True)
    arguments.add_argument("--seed", type=int, default=1)
    arguments.add_argument("--rules", type=int, default=300)
    options = arguments.parse_args()
    draw = random.Random(options.seed)
    rules = [rule(draw) for _ in range(options.rules)]
    with tempfile.TemporaryDirectory() as folder:
        program = pathlib.Path(folder) / "program.meld"
        program.write_text("\n".join(["type p(node, int, int, int). type q(node)."] + [meld for meld, _ in rules]) + "\n")
        done = subprocess.run([options.meldc, "check", "--json", program], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=100)
    if done.returncode != 0:
        sys.exit(f"meldc ended with {done.returncode}: {done.stdout.decode(errors='replace')[:2000]}")
    warned = {message["line"] - 2 for message in json.loads(done.stdout) if message["code"] in ("W0403", "W0408")}
    wrong, impossible = [], 0
    for number_of_rule, (meld, python) in enumerate(rules):
        holds = eval(f"lambda X, Y, Z: {python}")
        possible = any(holds(*numbers) for numbers in itertools.product(NUMBERS, repeat=3))
        impossible += not possible
        if possible and number_of_rule in warned:
            wrong.append(meld)
    print(f"{len(rules)} rules, {impossible} with no numbers that fit, {len(warned)} of them told, {len(wrong)} told wrongly")
    for meld in wrong:
        print(f"    {meld}")
    # What multiplies two terms or asks for a sum of three in several ways is beyond it.
    sys.exit(1 if wrong or len(warned) < 0.75 * impossible else 0)


if __name__ == "__main__":
    main()
