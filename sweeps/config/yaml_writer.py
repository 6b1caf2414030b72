"""Write a config as YAML that readers of YAML 1.1 and 1.2 read alike, without loss in floats."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping

# JSON is YAML, except for raw characters that a reader takes for line breaks or refuses.
_SPECIAL = re.compile(r"[\x7f-\x9f\u2028\u2029\ufeff\ufffe\uffff]")


def block_yaml(mapping: Mapping[str, object]) -> str:
    """Return a line for each key, indented below its section; deeper values stay on that line."""
    lines: list[str] = []
    for key, value in mapping.items():
        if isinstance(value, Mapping) and value:
            lines.append(f"{key}:")
            lines += [f"  {name}: {_flow(child)}" for name, child in value.items()]
        else:
            lines.append(f"{key}: {_flow(value)}")
    return "\n".join(lines) + "\n"


def _flow(value: object) -> str:
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(_flow, value)) + "]"
    if isinstance(value, Mapping):
        return (
            "{" + ", ".join(f"{_flow(key)}: {_flow(child)}" for key, child in value.items()) + "}"
        )
    if isinstance(value, float):
        # In YAML 1.1 1e-09 is a text; 1.0e-09 is a number in both versions.
        return re.sub(r"^(-?\d+)e", r"\1.0e", repr(value))
    quoted = json.dumps(value, ensure_ascii=False, allow_nan=False)
    return _SPECIAL.sub(lambda match: f"\\u{ord(match[0]):04x}", quoted)
