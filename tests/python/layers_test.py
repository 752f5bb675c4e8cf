"""The layers of the Python package: each module imports those of its own layer or of one below, and never in a circle.

    layers_test.py --meldsim PATH [unittest options]
"""
import ast
import graphlib
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from frame import Case, main  # noqa: E402

PYTHON = pathlib.Path(__file__).resolve().parents[2] / "python"
# From the lowest: calling the tool; values and files; what users call, which is whatever is in no folder.
LAYERS = ("claymeld.tool", "claymeld.data", "claymeld")


def imports_of(name, path, modules):
    """The modules of the package that a module imports: wherever in it, also in functions and for types only, since a circle of these is
    one as well."""
    package = name if path.name == "__init__.py" else name.rpartition(".")[0]
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"), str(path))):
        if isinstance(node, ast.Import):
            found = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            above = package.split(".")[: len(package.split(".")) - node.level + 1] if node.level else []
            home = ".".join([*above, *filter(None, [node.module])])
            # What is imported from a package is a module in it, or a name of its __init__.py.
            found = [f"{home}.{alias.name}" if f"{home}.{alias.name}" in modules else home for alias in node.names]
        else:
            continue
        for each in dict.fromkeys(found):
            if each.partition(".")[0] == "claymeld":
                yield each, node.lineno


def problems_of(root):
    """What is wrong with the imports of the package in a folder, in words."""
    paths = {}
    for path in sorted((root / "claymeld").rglob("*.py")):
        parts = path.relative_to(root).with_suffix("").parts
        paths[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    packages = {name if path.name == "__init__.py" else name.rpartition(".")[0] for name, path in paths.items()}
    problems = [f"{package} is in no layer" for package in sorted(packages.difference(LAYERS))]
    layers = {name: next((number for number, layer in enumerate(LAYERS) if f"{name}.".startswith(f"{layer}.")), 0) for name in paths}
    graph = {}
    for name, path in paths.items():
        graph[name] = set()
        for target, line in imports_of(name, path, paths):
            if target not in paths:
                problems.append(f"{name}:{line} imports {target}, which is no module")
                continue
            graph[name].add(target)
            if layers[target] > layers[name]:
                problems.append(f"{name}:{line} imports {target}, which is of a layer above")
    try:
        graphlib.TopologicalSorter(graph).prepare()
    except graphlib.CycleError as error:
        problems.append("a circle: " + " is imported by ".join(error.args[1]))
    return problems


class Layers(Case):
    def test_imports_go_down_only(self):
        self.assertEqual(problems_of(PYTHON), [])

    def problems(self, files):
        """Of the package with these files, in place of or beside those of a small one that is right."""
        right = {"__init__": "", "tool/__init__": "", "tool/calls": "import os", "data/__init__": "import re",
                 "data/values": "from ..tool.calls import find", "running": "from .data import values\nfrom .tool import calls"}
        root = self.folder / str(len(list(self.folder.iterdir())))
        for name, text in {**right, **files}.items():
            path = root / "claymeld" / f"{name}.py"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
        return problems_of(root)

    def test_what_is_right_is_no_problem(self):
        recording = "from . import plots\nfrom claymeld.data.values import value"
        self.assertEqual(self.problems({"plots": "import numpy", "recording": recording}), [])

    def test_what_is_wrong_is_found(self):
        above = "which is of a layer above"
        for name, text, says in (
                ("tool/calls", "from ..data import NAME", f"claymeld.tool.calls:1 imports claymeld.data, {above}"),
                ("tool/calls", "def late():\n    import claymeld.data", f"claymeld.tool.calls:2 imports claymeld.data, {above}"),
                ("tool/calls", "if TYPE_CHECKING:\n    from .. import running", f"claymeld.tool.calls:2 imports claymeld.running, {above}"),
                ("data/values", "from .. import __version__", f"claymeld.data.values:1 imports claymeld, {above}"),
                ("data/values", "from ..tool.gone import call", "claymeld.data.values:1 imports claymeld.tool.gone, which is no module"),
                ("more/__init__", "", "claymeld.more is in no layer"),
                ("plots", "from . import plots", "a circle: claymeld.plots is imported by claymeld.plots")):
            with self.subTest(name=name, text=text):
                problems = self.problems({name: text})
                self.assertEqual(problems[:1], [says])

    def test_circles_are_found(self):
        for text in ("from .running import Run", "def late():\n    from . import running",
                     "if TYPE_CHECKING:\n    import claymeld.running"):
            with self.subTest(text=text):
                problems = self.problems({"plots": text, "running": "from .plots import plot"})
                self.assertEqual(len(problems), 1)
                self.assertRegex(problems[0], r"^a circle: claymeld\.(plots|running) is imported by claymeld\.")


if __name__ == "__main__":
    main("meldsim")
