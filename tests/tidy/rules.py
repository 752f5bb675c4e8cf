"""The repository's rules as functions: each takes a file (its path from the root and its lines) and yields problems."""

import re
from typing import Iterator, NamedTuple


class Problem(NamedTuple):
    path: str
    line: int
    rule: str

    def __str__(self):
        return f"{self.path}:{self.line}: {self.rule}"


def check_table_of_folders(page, layers) -> Iterator[Problem]:
    """The reference of the design names every layer in its table of folders: the first cell of a row, whole or by its last word."""
    cells = " ".join(line.split("|")[1] for line in page.split("\n") if line.startswith("| `"))
    for folder in layers.depends:
        if f"`{folder}`" not in cells and f"`{folder.rsplit('/', 1)[-1]}`" not in cells:
            yield Problem("docs/reference/design.md", 1, f"the table of folders has no {folder}, which CMakeLists.txt names")


ANONYMOUS = re.compile(r"^namespace \{\n(.*?)^\}  // namespace$", re.DOTALL | re.MULTILINE)
PRIVATE = [re.compile(r"^(?:inline )?constexpr .*?\b(k[A-Z]\w+)\b"), re.compile(r"^(?:struct|class|enum class|enum) (\w+)\b"),
           re.compile(r"^\w[\w:<>,&* ]*[\w>&*] [&*]*(\w+\(.*)\{")]


def private_names(text) -> Iterator[str]:
    """What a source defines in its anonymous namespaces: constants, types, and functions with the types of their arguments."""
    for body in ANONYMOUS.findall(text):
        for line in body.split("\n"):
            for pattern in PRIVATE:
                if match := pattern.match(line):
                    # Without the names of the arguments and what follows them.
                    yield re.sub(r"\) *\w*$", ")", re.sub(r" \w+(?= = [^,)]*[,)]|[,)])", "", match[1].rstrip()))
                    break


class PrivateNames:
    """The release compiles several sources of a layer as one, so what they define for themselves has different names."""

    def __init__(self):
        self.first = {}

    def problems(self, path, text, layer) -> Iterator[Problem]:
        for name in private_names(text):
            first = self.first.setdefault((layer, name), path)
            if first != path:
                yield Problem(path, 1, f"{name} stands in an anonymous namespace of {first} too, and both are compiled together")


class Layers:
    """Which folder may include which, read from the meld_layer and meld_plugin calls of the top-level CMakeLists.txt."""

    CALL = re.compile(r"^ *meld_(layer|plugin)\(([^)]*)\)", re.MULTILINE)

    def __init__(self, cmake_text: str):
        self.depends = {}
        plugins = {}
        calls = []
        for kind, arguments in self.CALL.findall(cmake_text):
            words = arguments.split()
            if kind == "plugin":
                name = words.pop(0)
                plugins[name] = words[0]
            calls.append((words[0], words[words.index("DEPENDS") + 1:]))
        folders = {folder for folder, _ in calls}
        targets = {folder.replace("/", "_"): folder for folder in folders} | plugins
        for folder, words in calls:
            self.depends[folder] = {targets.get(word, word) for word in words} & folders

    def layer_of(self, path: str) -> str:
        """The longest layer folder above the path, or an empty string."""
        return max((folder for folder in self.depends if path.startswith(folder + "/")), key=len, default="")

    def reachable(self, layer: str) -> set:
        seen, todo = set(), [layer]
        while todo:
            current = todo.pop()
            if current not in seen:
                seen.add(current)
                todo.extend(self.depends.get(current, ()))
        return seen

    def problems_of_order(self, path: str) -> Iterator[Problem]:
        """A layer stands after those it depends on."""
        earlier = set()
        for folder, depends in self.depends.items():
            for later in sorted(depends - earlier):
                yield Problem(path, 1, f"layer {folder} depends on {later}, which stands below it")
            earlier.add(folder)


INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')
PROJECT = ("compiler/", "runtime/", "physics/")

PTHREAD_FILES = ("runtime/base/process/parallel_for.cpp", "runtime/base/process/deep_stack.cpp", "runtime/show/view/http.cpp")
# Header, the folders that may include it, why.
RESTRICTED_HEADERS = [
    (re.compile(r"^mpi\.h$"), ("runtime/comm/", "tests/"), "only runtime/comm talks to MPI"),
    (re.compile(r"^ode/"), ("physics/", "tests/bench/", "tests/unit/physics/"), "only physics talks to ODE"),
    (re.compile(r"^(embree3/|cairo/|civetweb\.h$)"), ("runtime/show/library/plugin/",),
     "only runtime/show/library includes Embree, Cairo and civetweb"),
    (re.compile(r"^(assimp/|tinyxml2\.h$)"), ("runtime/world/model/",), "only runtime/world/model uses assimp and TinyXML"),
    (re.compile(r"^(histedit\.h|editline/)"), ("runtime/ask/debug/",), "only runtime/ask/debug uses libedit"),
    (re.compile(r"^(llvm|llvm-c|clang|clang-c|lld)/"), ("compiler/build/", "compiler/diagnostics/"),
     "only compiler/build and compiler/diagnostics use LLVM"),
    (re.compile(r"^mlir/"), ("compiler/lsp/",), "only compiler/lsp uses MLIR"),
    (re.compile(r"^(thread|future)$"), ("runtime/base/process/parallel_for.cpp", "runtime/comm/", "runtime/show/view/http.cpp", "tests/"),
     "threads come from runtime/base/process/parallel_for.h"),
    (re.compile(r"^pthread\.h$"), PTHREAD_FILES,
     "threads come from runtime/base/process/parallel_for.h"),
]
THREAD = re.compile(r"\bstd::(jthread|thread|async)\b(?!::hardware_concurrency)|\bpthread_create\b")
THREAD_FILES = PTHREAD_FILES + ("runtime/comm/transport/threads.", "tests/")
MAX_LINES = 600
MAX_COLUMNS = 140


def includes(lines):
    for number, line in enumerate(lines, 1):
        match = INCLUDE.match(line)
        if match:
            yield number, match[1], match[2]


def check_layers(path, lines, layers: Layers) -> Iterator[Problem]:
    if not path.startswith(PROJECT):
        return
    layer = layers.layer_of(path)
    if not layer:
        yield Problem(path, 1, "the folder is not a layer; add it to CMakeLists.txt")
        return
    allowed = layers.reachable(layer)
    for number, quote, header in includes(lines):
        if quote == "<":
            if header.startswith(PROJECT):
                yield Problem(path, number, f'a header of the project is included with quotes: "{header}"')
        elif not header.startswith(PROJECT):
            yield Problem(path, number, f'include "{header}" by its full path from the root')
        elif layers.layer_of(header) not in allowed:
            yield Problem(path, number, f"{layer} may not include {header} (CMakeLists.txt does not put it below)")


def check_restricted_headers(path, lines) -> Iterator[Problem]:
    for number, _, header in includes(lines):
        for pattern, allowed, reason in RESTRICTED_HEADERS:
            if pattern.match(header) and not path.startswith(allowed):
                yield Problem(path, number, f"<{header}> here: {reason}")


def check_threads(path, lines) -> Iterator[Problem]:
    if path.startswith(THREAD_FILES):
        return
    for number, line in enumerate(lines, 1):
        if THREAD.search(line.split("//")[0]):
            yield Problem(path, number, "threads come from runtime/base/process/parallel_for.h")


def check_header(path, lines) -> Iterator[Problem]:
    if path.endswith(".h") and "#pragma once" not in lines:
        yield Problem(path, 1, "a header has #pragma once")


def check_opening(path, lines) -> Iterator[Problem]:
    if path.endswith(".h") and not (lines and lines[0].startswith("//")):
        yield Problem(path, 1, "the first line of a header says in a sentence what the file is")


def check_text(path, lines) -> Iterator[Problem]:
    if len(lines) > MAX_LINES:
        yield Problem(path, MAX_LINES + 1, f"{len(lines)} lines are more than {MAX_LINES}; split the file")
    for number, line in enumerate(lines, 1):
        if len(line) > MAX_COLUMNS:
            yield Problem(path, number, f"{len(line)} columns are more than {MAX_COLUMNS}; break the line")
        if "\t" in line:
            yield Problem(path, number, "a tab; indent with spaces")
        if line.endswith((" ", "\r")):
            yield Problem(path, number, "white space at the end of the line")


def check_file(path, text, layers: Layers) -> Iterator[Problem]:
    """All rules for one file of C++, CMake, Python, Meld or the shell."""
    lines = text.split("\n")
    if lines[-1] == "":
        lines.pop()
    else:
        yield Problem(path, len(lines), "the last line does not end")
    yield from check_text(path, lines)
    if path.endswith((".h", ".cpp")):
        yield from check_header(path, lines)
        yield from check_opening(path, lines)
        yield from check_layers(path, lines, layers)
        yield from check_restricted_headers(path, lines)
        yield from check_threads(path, lines)
