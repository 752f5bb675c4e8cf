"""As much of a TextMate engine as the grammar of Meld needs: match, begin and end, captures, includes; a line at a time."""

import re


class Grammar:
    def __init__(self, grammar):
        self.grammar = grammar
        self.compiled = {}

    def regex(self, pattern):
        if pattern not in self.compiled:
            self.compiled[pattern] = re.compile(pattern)
        return self.compiled[pattern]

    def all_regexes(self):
        """Every regular expression of the grammar."""
        todo = [self.grammar]
        while todo:
            node = todo.pop()
            if isinstance(node, dict):
                yield from (node[key] for key in ("match", "begin", "end") if key in node)
                todo.extend(node.values())
            elif isinstance(node, list):
                todo.extend(node)

    def flat(self, patterns):
        for pattern in patterns:
            if "include" in pattern:
                yield from self.flat([self.grammar["repository"][pattern["include"][1:]]])
            elif "match" in pattern or "begin" in pattern:
                yield pattern
            else:
                yield from self.flat(pattern["patterns"])

    def scopes(self, text):
        """For each character the scopes it has, outermost first."""
        result, stack = [], []
        for line in text.splitlines(keepends=True):
            scopes = [[] for _ in line]
            at = 0
            while at <= len(line):
                at = self.step(line, at, stack, scopes)
            result += scopes
        return result

    def step(self, line, at, stack, scopes):
        rules = (list(self.flat(stack[-1]["patterns"] if stack else self.grammar["patterns"]))
                 if not stack or "patterns" in stack[-1] else [])
        best, rule = None, None
        if stack:
            best = self.regex(stack[-1]["end"]).search(line.rstrip("\n"), at)
        for candidate in rules:
            match = self.regex(candidate.get("match") or candidate["begin"]).search(line.rstrip("\n"), at)
            if match and (best is None or match.start() < best.start()):
                best, rule = match, candidate
        outer = [entry["name"] for entry in stack if "name" in entry]
        stop = best.start() if best else len(line)
        for i in range(at, stop):
            scopes[i] += outer
        if best is None:
            return len(line) + 1
        if rule is None:
            ended = stack.pop()
            self.paint(scopes, best, outer, ended.get("endCaptures", {}))
        else:
            named = [rule["name"]] if "name" in rule else []
            self.paint(scopes, best, outer + named, rule.get("captures") or rule.get("beginCaptures") or {})
            if "begin" in rule:
                stack.append(rule)
                return best.end()
        return best.end() if best.end() > at or rule is None else at + 1

    def paint(self, scopes, match, names, captures):
        for i in range(match.start(), match.end()):
            scopes[i] += names
        for group, capture in captures.items():
            for i in range(*match.span(int(group))):
                scopes[i].append(capture["name"])
