"""Each rule finds what it is for and leaves alone what it must."""

import pathlib
import tempfile
import unittest

from references import References
from rules import Layers, PrivateNames, check_file, check_table_of_folders
from seen import Seen

CMAKE = """
meld_layer(runtime/base DEPENDS fmt::fmt)
meld_layer(runtime/module/abi DEPENDS runtime/base)
meld_plugin(meld_backend compiler/build/backend DEPENDS runtime_base meld_clang)
meld_layer(compiler/build DEPENDS runtime/module/abi meld_backend)
meld_layer(runtime/comm DEPENDS runtime/base meld_mpi)
meld_layer(physics DEPENDS runtime/base)
meld_layer(runtime/show/library/plugin DEPENDS runtime/base)
meld_layer(runtime/world/model DEPENDS runtime/base)
"""


def rules_broken(path, body="", opening="// What it is.\n#pragma once\n"):
    return [problem.rule for problem in check_file(path, opening + body, Layers(CMAKE))]


class LayerRules(unittest.TestCase):
    def test_a_layer_sees_itself_and_what_is_below(self):
        self.assertEqual(rules_broken("runtime/module/abi/a.h", '#include "runtime/module/abi/b.h"\n#include "runtime/base/c.h"\n'), [])
        self.assertEqual(rules_broken("compiler/build/a.h", '#include "runtime/base/c.h"\n'), [])

    def test_a_layer_does_not_see_what_is_above_or_beside(self):
        self.assertEqual(len(rules_broken("runtime/base/a.h", '#include "runtime/module/abi/b.h"\n')), 1)
        self.assertEqual(len(rules_broken("runtime/comm/a.h", '#include "compiler/build/b.h"\n')), 1)

    def test_a_plugin_is_a_layer_of_its_own(self):
        self.assertEqual(rules_broken("compiler/build/a.h", '#include "compiler/build/backend/b.h"\n'), [])
        self.assertEqual(len(rules_broken("compiler/build/backend/a.h", '#include "compiler/build/b.h"\n')), 1)

    def test_each_source_folder_is_a_layer(self):
        self.assertEqual(len(rules_broken("runtime/attic/a.h")), 1)

    def test_includes_are_full_paths_in_quotes(self):
        self.assertEqual(len(rules_broken("runtime/base/a.h", '#include "c.h"\n')), 1)
        self.assertEqual(len(rules_broken("runtime/base/a.h", "#include <runtime/base/c.h>\n")), 1)

    def test_layers_stand_in_order(self):
        upside_down = Layers("meld_layer(a/b DEPENDS a/c)\nmeld_layer(a/c DEPENDS)\n")
        self.assertEqual(len(list(upside_down.problems_of_order("CMakeLists.txt"))), 1)
        self.assertEqual(list(Layers(CMAKE).problems_of_order("CMakeLists.txt")), [])


class PrivateNameRules(unittest.TestCase):
    def broken(self, *texts):
        names = PrivateNames()
        return [problem for number, text in enumerate(texts)
                for problem in names.problems(f"runtime/base/{number}.cpp", f"namespace {{\n{text}\n}}  // namespace\n", "runtime/base")]

    def test_sources_of_a_layer_name_different_things_differently(self):
        for text in ("constexpr int kMax = 3;", "struct Row {", "int twice(int a, int b) {", "bool holds(const Fact& fact) {"):
            self.assertEqual(len(self.broken(text, text)), 1, text)

    def test_functions_may_differ_in_their_arguments(self):
        self.assertEqual(self.broken("int twice(int a) {", "int twice(double a) {", "int thrice(int a) {"), [])


class HeaderRules(unittest.TestCase):
    def test_outside_libraries_stay_in_their_layer(self):
        for header, home in (("mpi.h", "runtime/comm/a.h"), ("ode/ode.h", "physics/a.h"),
                             *((name, "runtime/show/library/plugin/a.h") for name in ("embree3/rtcore.h", "cairo/cairo.h", "civetweb.h")),
                             ("assimp/scene.h", "runtime/world/model/a.h"),
                             ("llvm/IR/Module.h", "compiler/build/backend/a.h")):
            self.assertEqual(rules_broken(home, f"#include <{header}>\n"), [])
            self.assertEqual(len(rules_broken("runtime/module/abi/a.h", f"#include <{header}>\n")), 1)

    def test_threads_are_started_in_one_place(self):
        body = "#include <thread>\nstd::thread worker;\n"
        self.assertEqual(rules_broken("runtime/base/process/parallel_for.cpp", body), [])
        self.assertEqual(len(rules_broken("runtime/module/abi/a.cpp", body)), 2)
        self.assertEqual(rules_broken("runtime/module/abi/a.cpp", "// Not a std::thread.\n"), [])

    def test_headers_open_with_a_sentence_and_pragma_once(self):
        self.assertEqual(len(rules_broken("runtime/module/abi/a.h", "", "// What it is.\n")), 1)
        self.assertEqual(len(rules_broken("runtime/module/abi/a.h", "", "#pragma once\n")), 1)


class TableOfFolders(unittest.TestCase):
    def test_each_layer_has_a_row(self):
        whole = "| `runtime/base`, `abi`, `comm` | low |\n| `compiler/build`, `backend` | high |\n| `physics` | |\n"
        whole += "| `runtime/world/model`, `runtime/show/library/plugin` | |\n"
        self.assertEqual(list(check_table_of_folders(whole, Layers(CMAKE))), [])
        missing = [p.rule for p in check_table_of_folders(whole.replace("`abi`", "abi") + "| other | `abi` |\n", Layers(CMAKE))]
        self.assertEqual(len(missing), 1)
        self.assertIn("runtime/module/abi", missing[0])


class TextRules(unittest.TestCase):
    def test_tabs_and_spaces_at_the_end(self):
        self.assertEqual(len(rules_broken("tests/a.cpp", "\tint x;\nint y; \n")), 2)

    def test_length(self):
        self.assertEqual(len(rules_broken("tests/a.cpp", "int x;\n" * 598)), 0)
        self.assertEqual(len(rules_broken("tests/a.cpp", "int x;\n" * 599)), 1)

    def test_width(self):
        for path in ("tests/a.cpp", "compiler/check/a.def", "tests/a.py", "cmake/a.cmake", "scripts/a"):
            self.assertEqual(rules_broken(path, "x" * 140 + "\n"), [])
            self.assertEqual(len(rules_broken(path, "x" * 141 + "\n" + "x" * 200 + "\n")), 2)
        # Characters count, not bytes.
        self.assertEqual(rules_broken("tests/a.py", "é" * 140 + "\n"), [])

    def test_the_last_line_ends(self):
        self.assertEqual(len(rules_broken("tests/a.cpp", "int x;")), 1)


class ReferenceRules(unittest.TestCase):
    def broken(self, path, text):
        here = References({"docs/a.md": "# A\n\n## What is there\n", "runtime/module/abi/a.h": "void begin();\n",
                           "runtime/module/abi/b.cpp": "",
                           "stdlib/tree.meld": ""})
        return [problem.rule for problem in here.problems(path, text.split("\n"))]

    def test_comments_point_to_files(self):
        self.assertEqual(self.broken("runtime/module/abi/a.h", "// As a.h says, runtime/module/abi/b.cpp too, and docs/a.md.\n"), [])
        self.assertEqual(len(self.broken("runtime/module/abi/a.h", "int x;  // As c.h says.\n")), 1)
        self.assertEqual(len(self.broken("runtime/module/abi/a.h", "// module/a.h\n")), 1)
        self.assertEqual(len(self.broken("tests/a.py", "# See evaluation.md.\n")), 1)
        self.assertEqual(len(self.broken("docs/a.md", "The rest is in `runtime/module/abi/c.h`.\n")), 1)

    def test_headings_exist(self):
        self.assertEqual(self.broken("runtime/module/abi/a.h", '// docs/a.md, "What is there"\n'), [])
        self.assertEqual(len(self.broken("runtime/module/abi/a.h", '// docs/a.md, "What is not"\n')), 1)

    def test_functions_are_in_their_file(self):
        self.assertEqual(self.broken("docs/a.md", "`runtime/module/abi/a.h: begin()` begins.\n"), [])
        self.assertEqual(len(self.broken("docs/a.md", "`runtime/module/abi/a.h: beg()` begins.\n")), 1)
        self.assertEqual(len(self.broken("docs/a.md", "`runtime/module/abi/c.h: begin()` begins.\n")), 2)

    def test_code_and_placeholders_are_left_alone(self):
        self.assertEqual(self.broken("docs/a.md", "```cpp\n// c.h\n```\n    c.h\n"), [])
        body = '#include "c.h"\nauto s = "// c.h";\n// <c.h>, file.meld, PROGRAM.toml, --link=FILE.c\n'
        self.assertEqual(self.broken("runtime/module/abi/a.h", body), [])


class SeenFiles(unittest.TestCase):
    def test_what_has_changed_is_looked_at_again(self):
        with tempfile.TemporaryDirectory() as folder:
            root, store = pathlib.Path(folder), pathlib.Path(folder) / "seen.json"
            (root / "a.h").write_text("a")
            (root / "b.h").write_text("b")

            def unseen(rule="of 19", remember=True):
                seen = Seen(store, rule)
                files = seen.unseen(root, ["a.h", "b.h"])
                if remember:
                    seen.remember()
                return files

            self.assertEqual(unseen(remember=False), ["a.h", "b.h"])
            self.assertEqual(unseen(), ["a.h", "b.h"])
            self.assertEqual(unseen(), [])
            (root / "b.h").write_text("c")
            self.assertEqual(unseen(remember=False), ["b.h"])
            self.assertEqual(unseen(), ["b.h"])
            self.assertEqual(unseen(), [])
            self.assertEqual(unseen("of 20"), ["a.h", "b.h"])
            store.write_text("[")
            self.assertEqual(unseen(), ["a.h", "b.h"])


if __name__ == "__main__":
    unittest.main()
