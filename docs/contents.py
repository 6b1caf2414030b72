"""The menu of the site: the pages that a listing links to, section by section."""

from __future__ import annotations

import re

LISTINGS = ("docs/README", "docs/decisions/README")
"""Pages that list others. A page that is in no list is an error: no menu would lead to it."""

_LINK = re.compile(r"\]\((?!\w+:)([^)#\s]+)\.md\)")


def with_contents(page: str) -> str:
    """Add hidden menu entries at the end of each section of a listing."""
    head, *sections = re.split(r"^(?=## )", page, flags=re.MULTILINE)
    return head + "".join(section + _entries(section) for section in sections)


def _entries(section: str) -> str:
    caption, pages = section[3:].partition("\n")[0], dict.fromkeys(_LINK.findall(section))
    if not pages:
        return ""
    options = f":hidden:\n:caption: {caption}"
    return "\n".join(["\n```{toctree}", options, "", *pages, "```\n\n"])
