"""Files of the repository that pages link to, as pages of the site; and which page a file is."""
import pathlib
import re

ROOT = pathlib.Path(__file__).resolve().parents[2]
# Pages outside docs/.
PAGES = {"CHANGELOG.md": "changes"}
LANGUAGES = {".meld": "meld", ".toml": "toml", ".h": "cpp", ".cpp": "cpp", ".def": "cpp", ".py": "python", ".js": "javascript",
             ".json": "json", ".yml": "yaml", ".yaml": "yaml", "CMakeLists.txt": "cmake", ".cmake": "cmake", ".sh": "bash"}
LINK = re.compile(r"\]\(([^)\s#]+)(?:#[^)\s]*)?\)")
CODE = re.compile(r"^```.*?^```$|`[^`\n]*`", re.MULTILINE | re.DOTALL)


def page_of(path):
    """The page of the site that shows a file or folder, given from the root of the repository, or None."""
    name = path.as_posix()
    if name in PAGES:
        return PAGES[name]
    if name.startswith("docs/"):
        return name.removeprefix("docs/").removesuffix(".md") if name.endswith(".md") else None
    if name == "examples/meld":
        return "examples/index"
    if path.parent.as_posix() == "examples/meld" and path.suffix == ".meld":
        return f"examples/{path.stem}"
    if (ROOT / path).is_dir():
        return f"files/{name}/index"
    return f"files/{name}"


def target(page, link):
    """The file that a link of a page (both as paths) leads to, from the root of the repository; None if it is outside."""
    found = pathlib.Path(page).resolve().parent.joinpath(link).resolve()
    return found.relative_to(ROOT) if found.is_relative_to(ROOT) else None


def links(page):
    """The files and folders that a page links to."""
    for link in LINK.findall(CODE.sub("", page.read_text())):
        if "://" not in link and (found := target(page, link)) is not None and (ROOT / found).exists():
            yield found


def language(path):
    if path.name in LANGUAGES or path.suffix in LANGUAGES:
        return LANGUAGES.get(path.name) or LANGUAGES[path.suffix]
    return "bash" if (ROOT / path).read_text().startswith("#!/usr/bin/env bash") else "text"


def file_page(path):
    return f"# {path}\n\n```{{literalinclude}} /repository/{path}\n:language: {language(path)}\n:linenos:\n```\n"


def folder_page(path, entries):
    lines = "\n".join(f"- [{entry.name}](/{page_of(entry)}.md)" for entry in entries)
    return f"# {path}\n\n{lines}\n"


def pages(source):
    """Each file that a page links to, and those of each folder that a page links to, as a page with its text."""
    texts, found = [path for path in source.rglob("*.md")] + sorted((ROOT / "docs").rglob("*.md")), {}
    todo = {link for text in texts for link in links(text)}
    while todo:
        path = todo.pop()
        name = page_of(path)
        if name is None or name in found or not name.startswith("files/"):
            continue
        if not (ROOT / path).is_dir():
            found[name] = ROOT / path if path.suffix == ".md" else file_page(path)
            todo |= set(links(ROOT / path)) if path.suffix == ".md" else set()
            continue
        readme = ROOT / path / "README.md"
        entries = [entry.relative_to(ROOT) for entry in sorted((ROOT / path).iterdir())
                   if entry.is_file() and not entry.name.startswith(".")]
        found[name] = readme if readme.exists() else folder_page(path, entries)
        todo |= set(links(readme)) if readme.exists() else set(entries)
    return found
