"""Makes the tables of docs/configuration.md: `python docs/configuration.py`.

They come from the declarations of parameters and sections; the text between them is written by
hand.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any

from stickslip.variables import PARAMETERS, canonical_name
from sweeps.config.json_schema import json_schema
from sweeps.config.load import KEYS, from_yaml

PAGE = Path(__file__).with_suffix(".md")

_TABLE = re.compile(r"(<!-- table: (\w+) -->\n).*?(<!-- end of table -->)", re.DOTALL)
_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
# The upper bound of a count is that of 64-bit integers, which is not worth showing.
_UNREACHED = 2**63 - 1

_AXES = (
    "[300, 200, 250]",
    "{linspace: [0, 1], num: 5}",
    "{geomspace: [1e4, 1e6], num: 3}",
    "{arange: [200, 300, 25]}",
    "{arange: [1, 0, -1/4]}",
)


def with_tables(page: str) -> str:
    """Return the page with each of its tables updated."""
    tables = {
        "keys": _keys,
        "parameters": _parameters,
        "axes": _axes,
        "sample_keys": _sample_keys,
    }

    def made(match: re.Match[str]) -> str:
        begin, name, end = match.groups()
        table = tables[name]() if name in tables else _section(name)
        return f"{begin}\n{table}\n\n{end}"

    return _TABLE.sub(made, page)


def table(head: str, rows: Iterable[Iterable[str]]) -> str:
    """Return a Markdown table."""
    columns = head.count("|") - 1
    return "\n".join([head, "|---" * columns + "|", *("| " + " | ".join(r) + " |" for r in rows)])


def _keys() -> str:
    schema = json_schema()
    rows = []
    for key in KEYS:
        value = schema["properties"][key]
        kind = value["anyOf"][0]
        group = schema["$defs"].get(key.capitalize(), kind)
        meaning = value.get("description") or group["description"]
        is_text = kind.get("type") == "string"
        rows.append((f"`{key}`" if is_text else f"[`{key}`](#{key})", meaning))
    return table("| key | holds |", rows)


def _parameters() -> str:
    keys = json_schema()["properties"]["model"]["anyOf"][0]["properties"]
    rows = (
        (
            f"`{name}`",
            f"`{variable.symbol}`",
            re.sub(r"(?<=[A-Za-z])-?\d+", lambda m: m[0].translate(_SUPERSCRIPTS), variable.unit),
            _value(variable.default),
            _valid(keys[name]),
            variable.meaning + (f"; {variable.comment}" if variable.comment else ""),
        )
        for name, variable in PARAMETERS.items()
    )
    return table("| parameter | symbol | unit | default | valid | meaning |", rows)


def _axes() -> str:
    rows = []
    for axis in _AXES:
        (values,) = from_yaml(f"sweep: {{temperature: {axis}}}").sweep.values()
        rows.append((f"`{axis}`", ", ".join(map(_value, values))))
    return table("| written | values |", rows)


def _section(name: str) -> str:
    schema = json_schema()["$defs"][name.capitalize()]
    rows = (
        (f"`{key}`", _value(value.get("default")), _valid(value), value["description"])
        for key, value in schema["properties"].items()
    )
    return table("| key | default | valid | meaning |", rows)


def _sample_keys() -> str:
    """Return the keys of `sample` that are not parameters."""
    properties = json_schema()["$defs"]["Sample"]["properties"]
    own = [key for key in properties if canonical_name(key) is None]
    rows = (
        (f"`{key}`", _value(properties[key].get("default")), _valid(properties[key]),
         properties[key]["description"])
        for key in own
    )  # fmt: skip
    return table("| key | default | valid | meaning |", rows)


def _valid(schema: Mapping[str, Any]) -> str:
    """Return the valid values of a key in words, from its JSON Schema."""
    kinds = [kind for kind in schema.get("anyOf", [schema]) if kind.get("type") != "null"]
    kind = kinds[0]
    if keys := json_schema()["$defs"].get(kind.get("$ref", "")[8:], {}).get("properties"):
        return f"a mapping with {' or '.join(f'`{key}`' for key in keys)}"
    if kind.get("type") == "object":
        return "parameters, each with an axis"
    names = kind.get("enum") or [kind[k] for k in ("const",) if k in kind]
    if names:
        return ", ".join(f"`{name}`" for name in names)
    bounds = [
        f"{sign} {_value(kind[bound])}"
        for bound, sign in (
            ("exclusiveMinimum", ">"),
            ("minimum", "≥"),
            ("exclusiveMaximum", "<"),
            ("maximum", "≤"),
        )
        if bound in kind and kind[bound] < _UNREACHED
    ]
    bounds += ["not 0"] if "not" in schema else []
    words = {
        "number": "",
        "integer": "whole number",
        "boolean": "`true`, `false`",
        "string": "text",
        "array": "list",
    }
    word = words[kind.get("type", "number")]
    return " ".join(filter(None, [word, ", ".join(bounds)])) or "any number"


def _value(value: object) -> str:
    """Return a value as a person writes it: -2/3, 1e-9."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return f"`{str(value).lower()}`"
    if isinstance(value, str):
        return f"`{value}`"
    if isinstance(value, list):
        return f"`[{', '.join(str(item) for item in value)}]`"
    number: float = value  # type: ignore[assignment]  # all other types are handled above
    if number >= 1e4 and number % 1e4 == 0:
        mantissa, _, exponent = f"{number:e}".partition("e")
        return f"{float(mantissa):g}e{int(exponent)}"
    short = f"{number:g}".replace("e-0", "e-")
    return short if float(short) == number else str(Fraction(number).limit_denominator(99))


if __name__ == "__main__":
    PAGE.write_text(with_tables(PAGE.read_text()))
