"""docs/formats.md has the numbers of the formats that the code has, and one version of Claymeld stands everywhere.

    formats_test.py [unittest options]
"""
import json
import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
# Where each number stands in the code.
NUMBERS = {
    "recording": ("runtime/results/hdf5/file_kind.h", r"kRecordingVersion = (\d+)"),
    "facts": ("runtime/results/hdf5/file_kind.h", r"kFactsVersion = (\d+)"),
    "snapshot": ("runtime/sim/state/share_file.cpp", r'"meld snapshot(\d+)"'),
    "changes": ("runtime/sim/state/share_file.cpp", r'kChangesMagic\[16\] = "meld snapshot(\d+)"'),
    "module": ("runtime/module/abi/module_abi.h", r"kAbiVersion = (\d+)"),
    "profile": ("runtime/results/profile/file/profile_file.cpp", r"kVersion = (\d+)"),
}
# The same numbers in Python, which reads these files itself.
PYTHON = {
    "recording": ("python/claymeld/data/layout.py", r'^FORMAT, VERSION = "claymeld recording", (\d+)'),
    "facts": ("python/claymeld/data/tables.py", r"^VERSION = (\d+)"),
}
# Where the version of Claymeld stands; each must be there.
VERSIONS = {
    "python/claymeld/__init__.py": r'__version__ = "(.*?)"',
    "editors/vscode/package.json": r'"version": "(.*?)"',
    "CITATION.cff": r"^version: (.*)$",
}


def found(path, pattern):
    return re.search(pattern, (ROOT / path).read_text(), re.MULTILINE)


class Formats(unittest.TestCase):
    def test_the_page_has_the_numbers_of_the_code(self):
        rows = [line.split("|")[2] for line in (ROOT / "docs/formats.md").read_text().splitlines() if line.startswith("|")]
        said = dict(pair for row in rows for pair in re.findall(r"\b(\w+) (\d+)\b", row))
        self.assertEqual(said, {name: found(*place)[1] for name, place in NUMBERS.items()})

    def test_python_reads_the_same_numbers(self):
        for name, place in PYTHON.items():
            match = found(*place)
            self.assertTrue(match, f"{place[0]} does not say which {name} it reads")
            self.assertEqual(match[1], found(*NUMBERS[name])[1], name)

    def test_the_page_says_where_the_numbers_stand(self):
        page = (ROOT / "docs/formats.md").read_text()
        for path, _ in [*NUMBERS.values(), *PYTHON.values()]:
            self.assertIn(f"`{path}`", page)

    def test_one_version_stands_everywhere(self):
        version = found("runtime/base/version.h", r'kVersion\[\] = "(.*?)"')[1]
        for path, pattern in VERSIONS.items():
            match = found(path, pattern)
            self.assertTrue(match, path)
            self.assertEqual(match[1], version, path)
        self.assertEqual(json.loads((ROOT / "editors/vscode/package.json").read_text())["version"], version)


if __name__ == "__main__":
    unittest.main()
