"""Follows every link inside the built site, to its file and its anchor: a step of `make docs`.

Links that leave the site are listed, and not followed: `docs/_build/external-links.txt`.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

BUILT = Path(__file__).parent / "_build"


class Page(HTMLParser):
    """The links of an HTML page and the anchors that it has."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: list[str] = []
        self.anchors: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Called by `feed`."""
        for name, value in attrs:
            if value and name in ("href", "src", "data"):
                self.links.append(value)
            if value and (name == "id" or (name == "name" and tag == "a")):
                self.anchors.add(value)


@cache
def page_of(path: Path) -> Page:
    """Return a page, which is read only once."""
    return Page(path.read_text("utf-8"))


def broken_links(site: Path) -> Iterator[str]:
    """Return the links of a site that lead to no file or anchor, as lines."""
    for path in sorted(site.rglob("*.html")):
        for link in page_of(path).links:
            if not is_external(link) and (why := _complaint(path, link)):
                yield f"{path.relative_to(site)}: {link}: {why}"


def external_links(site: Path) -> dict[str, str]:
    """Return the external links of a site, each with the first page that has it."""
    found: dict[str, str] = {}
    for path in sorted(site.rglob("*.html")):
        for link in filter(is_external, page_of(path).links):
            found.setdefault(link, str(path.relative_to(site)))
    return found


def is_external(link: str) -> bool:
    """Tell whether a link leaves the site."""
    return bool(urlsplit(link).scheme or link.startswith("//"))


def _complaint(page: Path, link: str) -> str:
    parts = urlsplit(link)
    target = (page.parent / unquote(parts.path)).resolve() if parts.path else page.resolve()
    if not target.is_file():
        return "no such file"
    anchor = unquote(parts.fragment)
    if anchor and target.suffix == ".html" and anchor not in page_of(target).anchors:
        return "no such anchor"
    return ""


def main() -> None:
    """Check the built site."""
    site = BUILT / "html"
    if not site.is_dir():
        sys.exit(f"{site} is missing: `make docs` builds it")
    pages, broken = sum(1 for _ in site.rglob("*.html")), list(broken_links(site))
    outside = external_links(site)
    listed = "".join(f"{link}  ({page})\n" for link, page in sorted(outside.items()))
    (BUILT / "external-links.txt").write_text(listed, encoding="utf-8")
    print(
        f"links of {pages} pages: {len(broken)} broken; {len(outside)} that lead elsewhere listed"
    )
    if broken:
        sys.exit("\n".join(broken))


if __name__ == "__main__":
    main()
