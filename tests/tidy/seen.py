"""Remembers which files were found tidy, so that a check looks again only at files that have changed."""

import hashlib
import json
import pathlib


class Seen:
    """`store`: where it is remembered, or None: nothing is. `rule`: whatever the outcome depends on besides a file's bytes."""

    def __init__(self, store: pathlib.Path | None, rule: str):
        self.store, self.rule = store, rule
        self.marks: dict[str, str] = {}
        try:
            self.known = set(json.loads(store.read_text())) if store else set()
        except (OSError, ValueError):
            self.known = set()

    def mark(self, path: pathlib.Path) -> str:
        return hashlib.sha256(self.rule.encode() + b"\0" + path.suffix.encode() + b"\0" + path.read_bytes()).hexdigest()

    def unseen(self, root: pathlib.Path, files: list[str]) -> list[str]:
        """Those of the files that were not remembered; `remember` then takes them all."""
        self.marks = {file: self.mark(root / file) for file in files}
        return [file for file in files if self.marks[file] not in self.known]

    def remember(self):
        if self.store:
            self.store.write_text(json.dumps(sorted(set(self.marks.values()))))
