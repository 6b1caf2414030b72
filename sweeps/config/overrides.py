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
from sweeps.config.diagnostics import MAX_DEPTH, Diagnostics, Located, located, quoted, shortened
from sweeps.config.parameter_space import key_of
from sweeps.config.yaml_reader import read_text

CASE = "case"


def apply_overrides(
    root: Located, overrides: Sequence[str], diagnostics: Diagnostics
) -> Located | None:
    """Change `root` as the overrides say; the value of `case=INDEX` is returned, if there is one.

    Problems are noted with the override as their source.
    """
    done: dict[str, str] = {}
    case = None
    for override in overrides:
        key, equals, text = override.partition("=")
        key = key.strip()
        name = canonical_name(key)
        here = Located(None, f"--set {shortened(override)}", None, key, diagnostics)
        if not key or not equals:
            here.key = ""
            here.refuse("must be KEY=VALUE, for example temperature=250")
            continue
        if (name or key) in done:
            here.refuse(f"is set twice, first by --set {done[name or key]}")
            continue
        done[name or key] = override
        value = read_text(text, here.source, diagnostics, numbered=False)
        if value is None:
            continue
        value.key = key
        if name:
            _set_parameter(root, name, value)
        elif key == CASE:
            case = value
        else:
            _set_path(root, key.split("."), value)
    return case


def _set_parameter(root: Located, name: str, value: Located) -> None:
    is_axis = isinstance(value.value, (list, dict))
    if key_of(root, "cases", name):
        if is_axis:
            _set_path(root, ["cases", name], value)
        else:
            value.refuse("is linked in `cases`; pick one case with --set case=0, or give a list")
        return
    gone, section = ("model", "sweep") if is_axis else ("sweep", "model")
    while key := key_of(root, gone, name):
        del root.value[gone].value[key]
    _set_path(root, [section, name], value)


def _set_path(root: Located, path: list[str], value: Located) -> None:
    *sections, last = path[:MAX_DEPTH]
    target = root
    for section in sections:
        children = target.value
        if section not in children or children[section].value is None:
            children[section] = located({}, value.source, value.diagnostics, section)
        target = children[section]
        if not isinstance(target.value, dict):
            message = f"there are no keys below {section}: it is {quoted(target.value)}"
            value.key = ".".join(path)
            value.refuse(message)
            return
    name = canonical_name(last) if len(path) == 2 else None
    key = (key_of(root, path[0], name) if name else None) or last
    place = ".".join([*sections, key])
    target.value[key] = located(value.plain(), value.source, value.diagnostics, place)
