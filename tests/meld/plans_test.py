"""Runs file tests of linear rules with other plans: without each optional pass of the planner, without all of them, and with modules that
check themselves (which have an index of every table), count, or find neighbours in a table. All give the facts of the file.

    plans_test.py --meldc PATH --meldsim PATH --passes compiler/plan/plan.cpp FILE...
"""
import argparse
import pathlib
import re
import sys
import tempfile

import file_test

# A program for every plan takes its time to compile: these files have many rules.
FORMS = [["--checked"], ["--counters"], ["--links"]]


def optional_passes(table):
    return re.findall(r'^    \{\.name = "(\w+)", \.kind = kOptional', pathlib.Path(table).read_text(), re.M)


def facts_of(test, plan, tools, folder):
    compiled, output = file_test.call([tools["meldc"], "compile", test.path.name, "-O0", "--quiet", "-o", "plan.so"] + plan, folder)
    if compiled != 0:
        return output
    world = ["--world", "world.toml"] if test.values("WORLD") else []
    return file_test.call([tools["meldsim"], "run", "plan.so", "--quiet", "--facts-out", "-"] + world, folder)[1]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--meldc", required=True)
    parser.add_argument("--meldsim", required=True)
    parser.add_argument("--passes", required=True)
    parser.add_argument("files", nargs="+", type=pathlib.Path)
    options = parser.parse_args()
    tools = {"meldc": str(pathlib.Path(options.meldc).resolve()), "meldsim": str(pathlib.Path(options.meldsim).resolve())}
    passes = optional_passes(options.passes)
    if not passes:
        sys.exit(f"no optional pass in {options.passes}")
    without = [["--without", name] for name in passes]
    plans = without + [sum(without, [])] + FORMS
    wrong = 0
    for path in options.files:
        test = file_test.Test(path)
        for plan in plans:
            with tempfile.TemporaryDirectory(prefix="meld-plans-") as name:
                folder = pathlib.Path(name)
                file_test.prepare(test, folder)
                actual = facts_of(test, plan, tools, folder).rstrip("\n").split("\n")
            if actual != test.expected:
                wrong += 1
                print(f"{path.name} {' '.join(plan)}:")
                print("\n".join(sorted(set(actual) ^ set(test.expected))[:20]))
    print(f"{len(options.files)} files with {len(plans)} plans, {wrong} differ")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
