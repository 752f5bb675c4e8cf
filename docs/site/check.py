"""Links of a built site, as a browser reads them: pages, pictures, films and places in pages must be there."""
import html.parser
import pathlib
import urllib.parse


class Reader(html.parser.HTMLParser):
    """The places of a page, and what it links to."""

    def __init__(self, text):
        super().__init__()
        self.places, self.links = set(), []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        for name, value in attrs:
            if name == "id" or (name == "name" and tag == "a"):
                self.places.add(value)
            elif name in ("href", "src", "data", "poster") and value and not (tag == "link" and ("rel", "canonical") in attrs):
                self.links.append(value)


def problems(folder):
    """Each link that leads nowhere, as a line."""
    folder = pathlib.Path(folder)
    # Runs are pages of the viewer, whose links its script makes.
    pages = {path: Reader(path.read_text()) for path in folder.rglob("*.html") if path.parent.name != "runs"}
    found = []
    for path, page in sorted(pages.items()):
        for link in page.links:
            parts = urllib.parse.urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / urllib.parse.unquote(parts.path)).resolve() if parts.path else path
            if target.is_dir():
                target /= "index.html"
            place = urllib.parse.unquote(parts.fragment)
            if not target.exists():
                found.append(f"{path.relative_to(folder)}: a link to {link}, which does not exist")
            elif place and target in pages and place not in pages[target].places:
                found.append(f"{path.relative_to(folder)}: a link to {link}, where no such place is")
    return found
