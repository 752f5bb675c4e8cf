"""Runs a program with meldsim on several numbers of processes and threads, and reads what it writes."""

import collections
import json
import pathlib
import re
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from frame import CAMPAIGN, environment_with  # noqa: E402

WHERE = "\ntype where-cell(node, int X, int Y, int Z).\nwhere-cell(A, X, Y, Z) :- cell(A, X, Y, Z).\n"
# Processes and threads: the first list in a program's first world; the others, in turn, in its further worlds. The campaign
# (`scripts/test --all`) takes more of them.
if CAMPAIGN:
    SIZES = [(processes, threads) for processes in (1, 2, 3, 4) for threads in (1, 2)]
    FURTHER = [[(1, 1), (2, 2), (3, 1), (4, 2)], [(1, 2), (2, 1), (3, 2), (4, 1)]]
else:
    SIZES = [(1, 1), (1, 2), (2, 1), (3, 2)]
    FURTHER = [[(1, 1), (2, 2)], [(1, 2), (3, 1)], [(1, 1), (4, 1)]]
FACT = re.compile(r"([^(]+)\((.*)\)\.")
# What a run has done does not depend on how it was divided.
SAME = ("ended", "ticks", "catoms", "evaluations", "derivations", "exported_changes", "linear_messages", "dropped_messages")


class Outcome:
    """The facts at the end, {predicate: [arguments]} with catoms as ids, the cell of each catom, and the summary."""

    def __init__(self, text, summary):
        self.summary = summary
        self.facts = collections.defaultdict(list)
        for line in text.splitlines():
            name, arguments = FACT.fullmatch(line).groups()
            self.facts[name].append(tuple(literal(word) for word in split(arguments)))
        self.cell_of = {row[0]: row[1:] for row in self.facts.pop("where-cell", [])}


def split(arguments):
    """At the commas that stand in no list, no vector and no string; strings here have no quotation marks inside."""
    words, depth, quoted = [""], 0, False
    for letter in arguments:
        quoted ^= letter == '"'
        depth += 0 if quoted else (letter in "[(") - (letter in ")]")
        if letter == "," and depth == 0 and not quoted:
            words.append("")
        else:
            words[-1] += letter
    return [word.strip() for word in words]


def literal(word):
    if word.startswith("["):
        return [literal(inner) for inner in split(word[1:-1])] if word != "[]" else []
    if word.startswith('"') or word in ("true", "false"):
        return json.loads(word)
    if word.startswith("@"):
        return int(word[1:])
    if word.startswith("vec3("):
        return tuple(float(part) for part in word[5:-1].split(","))
    if word.startswith("("):
        return tuple(literal(inner) for inner in split(word[1:-1]))
    return int(word) if re.fullmatch(r"-?\d+", word) else float(word)


class Runner:
    def __init__(self, meldsim, program, folder, telling=WHERE):
        self.meldsim = meldsim
        self.folder = pathlib.Path(folder)
        self.worlds = 0
        self.program = pathlib.Path(program)
        # The program as it is, and with its cells (or whatever is asked for) told.
        self.telling = self.folder / self.program.name
        self.telling.write_text(self.program.read_text() + telling)
        self.told = tuple(re.findall(r"type ([\w-]+)", telling))
        self.environment = environment_with({"CLAYMELD_CACHE": self.folder / "cache"})

    def run(self, program, world, processes, threads, options):
        facts, digest = self.folder / "out.facts", self.folder / "out.digest"
        facts.unlink(missing_ok=True)
        command = [self.meldsim, "run", program, "--world", world, "--facts-out", facts, "--digest", digest, "--digest-check", "3",
                   "--json", "-n", str(processes), "--threads", str(threads), *options]
        done = subprocess.run(command, env=self.environment, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            sys.exit(f"{' '.join(map(str, command))}\nended with {done.returncode}:\n{done.stdout}{done.stderr}")
        return facts.read_text(), digest.read_text(), json.loads(done.stdout)

    def run_plainly(self, world, processes, threads, options=()):
        """The facts at the end and what came of the run, of the program as it is and without a digest a tick."""
        command = [self.meldsim, "run", self.program, "--world", world, "--facts-out", self.folder / "out.facts", "--json",
                   "-n", str(processes), "--threads", str(threads), *options]
        done = subprocess.run(command, env=self.environment, capture_output=True, text=True, check=True)
        return (self.folder / "out.facts").read_text(), json.loads(done.stdout)["outcomes"][0]

    def run_sizes(self, world, options=(), sizes=None, same=SAME, plain_world=None):
        """The outcome in this world (a path), which must be the same for all numbers of processes and threads; `same`: also of
        the summary. `plain_world`: where the program as it is runs, if the world names programs that tell more, too."""
        sizes = sizes or (FURTHER[self.worlds % len(FURTHER)] if self.worlds else SIZES)
        self.worlds += 1
        text, digests, summary = self.run(self.telling, world, *sizes[0], options)
        for processes, threads in sizes[1:]:
            other, their_digests, told = self.run(self.telling, world, processes, threads, options)
            divided = f"{processes} processes of {threads} threads"
            if other != text:
                sys.exit(f"{divided} derive other facts:\n{first_difference(text, other)}")
            if their_digests != digests:
                sys.exit(f"{divided} go another way:\n{first_difference(digests, their_digests)}")
            for key in same:
                if told[key] != summary[key]:
                    sys.exit(f"{divided} report {key} {told[key]}, not {summary[key]}")
        # Reporting the cells does not change what the program derives.
        plain, _, _ = self.run(self.program, plain_world or world, 1, 1, options)
        added = tuple(name + "(" for name in self.told)
        untold = "".join(line for line in text.splitlines(keepends=True) if not line.startswith(added))
        if plain != untold:
            sys.exit(f"where this is not told other facts are derived:\n{first_difference(untold, plain)}")
        return Outcome(text, summary)


def first_difference(one, other):
    for a, b in zip(one.splitlines(), other.splitlines()):
        if a != b:
            return f"  {a}\n  {b}"
    return f"  {len(one.splitlines())} and {len(other.splitlines())} lines"
