"""`--set KEY=VALUE`: a config is changed before it is judged, so that all rules hold as in a file.

A parameter takes its new value wherever it stood. A single number fixes it, and takes away its
axis if it had one; a list or a form such as `{linspace: ...}` makes it an axis, in the old place
or behind the others. A parameter linked in `cases` is no longer free: a list replaces its values,
a single number is refused, and `case=INDEX` picks one case and fixes all that it links. Any other
key is a path with dots, such as `integrator.rtol`.
"""

from __future__ import annotations

from collections.abc import Sequence

from stickslip.variables import canonical_name
from sweeps.config.diagnostics import Findings, Origin, shortened, shown
from sweeps.config.located import MAX_DEPTH, Entry
from sweeps.config.yaml_reader import read_text

CASE = "case"


def apply_overrides(root: Entry, overrides: Sequence[str], findings: Findings) -> Entry | None:
    """Change `root` as the overrides say; the entry of `case=INDEX` is returned, if there is one.

    Problems are noted in `findings` with the override as their source.
    """
    done: dict[str, str] = {}
    case = None
    for override in overrides:
        key, equals, text = override.partition("=")
        key, origin = key.strip(), Origin(f"--set {shortened(override)}")
        target = canonical_name(key) or key
        if not key or not equals:
            findings.refuse(origin, "", "must be KEY=VALUE, for example temperature=250")
            continue
        if target in done:
            findings.refuse(origin, key, f"is set twice, first by --set {done[target]}")
            continue
        done[target] = override
        entry = read_text(text, origin.source, findings, numbered=False)
        if entry is not None:
            entry.origin = origin
            case = entry if key == CASE else case
            _apply(root, key, entry, findings)
    return case


def _apply(root: Entry, key: str, entry: Entry, findings: Findings) -> None:
    name = canonical_name(key)
    if name:
        _set_parameter(root, name, key, entry, findings)
    elif key != CASE:
        _set_path(root, key.split("."), entry, findings)


def _set_parameter(root: Entry, name: str, key: str, entry: Entry, findings: Findings) -> None:
    is_axis = isinstance(entry.value, (list, dict))
    if _alias(root, "cases", name):
        if is_axis:
            _set_path(root, ["cases", name], entry, findings)
        else:
            message = "is linked in `cases`; pick one case with --set case=0, or give a list"
            findings.refuse(entry.origin, key, message)
        return
    _take(root, "model" if is_axis else "sweep", name)
    _set_path(root, ["sweep" if is_axis else "model", name], entry, findings)


def _set_path(root: Entry, path: list[str], entry: Entry, findings: Findings) -> None:
    *sections, last = path[:MAX_DEPTH]
    target = root
    for section in sections:
        children = target.value
        if section not in children or children[section].value is None:
            children[section] = Entry({}, entry.origin)
        target = children[section]
        if not isinstance(target.value, dict):
            message = f"there are no keys below {section}: it is {shown(target.value)}"
            findings.refuse(entry.origin, ".".join(path), message)
            return
    old = _alias(root, path[0], canonical_name(last)) if len(path) == 2 else None
    target.value[old or last] = entry


def _children(root: Entry, section: str) -> dict[str, Entry]:
    entry = root.value.get(section)
    return entry.value if entry and isinstance(entry.value, dict) else {}


def _alias(root: Entry, section: str, name: str | None) -> str | None:
    """The key by which a section gives a parameter: its full name or its symbol."""
    keys = _children(root, section)
    return next((key for key in keys if name and canonical_name(key) == name), None)


def _take(root: Entry, section: str, name: str) -> None:
    while key := _alias(root, section, name):
        del _children(root, section)[key]
