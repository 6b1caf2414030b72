"""The JSON Schema of a config, for editors that complete and check YAML while it is written.

It says what one value may be; what needs two values, such as a parameter both fixed and swept, is
judged by `sweeps.config.load` alone.
"""

from __future__ import annotations

import json
import math
from typing import Any

from pydantic.json_schema import models_json_schema

from stickslip.variables import PARAMETERS, ParameterVariable
from sweeps.config.axes import MAX_VALUES
from sweeps.config.numbers import RATIONAL_PATTERN
from sweeps.config.schema import SECTIONS

Schema = dict[str, Any]

_RATIONAL = {"type": "string", "pattern": RATIONAL_PATTERN}
_NUMBER = {"anyOf": [{"type": "number"}, _RATIONAL]}
_NUM = {"type": "integer", "minimum": 1, "maximum": MAX_VALUES}


def json_schema() -> Schema:
    """The schema, draft 2020-12, as a mapping ready for JSON."""
    sections = {name: _nullable({"$ref": f"#/$defs/{name}"}) for name in SECTIONS}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "stickslip config",
        "description": "What to compute, how, and where to write it.",
        "type": "object",
        "additionalProperties": False,
        "properties": {
            "title": {"type": ["string", "null"], "description": "one line about the result"},
            "model": _parameters("fixed parameters; the rest keep the paper's values", _fixed),
            "sweep": _parameters("full product of these axes, in this order", _swept),
            "cases": _parameters(
                "linked values: the first of each, the second of each ...", _swept
            ),
            **sections,
            "output": {
                "type": ["string", "null"],
                "description": "result file; default results/<name of the config>.nc",
            },
        },
        "$defs": _definitions(),
    }


def json_schema_text() -> str:
    """The schema as it is shipped."""
    return json.dumps(json_schema(), indent=2, ensure_ascii=False) + "\n"


def _definitions() -> Schema:
    values = {f"value_{name}": _value(variable) for name, variable in PARAMETERS.items()}
    axes = {f"axis_{name}": _axis(name) for name in PARAMETERS}
    return {**values, **axes, **_forms(), **_sections()}


def _parameters(description: str, kind: Any) -> Schema:
    """A section of parameters, by name and by symbol."""
    properties = {}
    for name, variable in PARAMETERS.items():
        properties[name] = kind(variable)
        properties[variable.symbol] = kind(variable)
    return {
        "description": description,
        "type": ["object", "null"],
        "additionalProperties": False,
        "properties": properties,
    }


def _fixed(variable: ParameterVariable) -> Schema:
    return {
        "$ref": f"#/$defs/value_{variable.name}",
        "description": _description(variable),
        "default": variable.default,
    }


def _swept(variable: ParameterVariable) -> Schema:
    return {"$ref": f"#/$defs/axis_{variable.name}", "description": _description(variable)}


def _description(variable: ParameterVariable) -> str:
    text = f"{variable.meaning} ({variable.symbol}) [{variable.units}]"
    return f"{text}: {variable.comment}" if variable.comment else text


def _value(variable: ParameterVariable) -> Schema:
    bounds: Schema = {}
    if math.isfinite(variable.lower):
        bounds["exclusiveMinimum" if variable.lower_open else "minimum"] = variable.lower
    if math.isfinite(variable.upper):
        bounds["maximum"] = variable.upper
    if variable.nonzero:
        bounds["not"] = {"const": 0}
    return {"anyOf": [{"type": "number", **bounds}, _RATIONAL]}


def _axis(name: str) -> Schema:
    listed = {
        "type": "array",
        "minItems": 1,
        "maxItems": MAX_VALUES,
        "items": {"$ref": f"#/$defs/value_{name}"},
    }
    return {"anyOf": [listed, *({"$ref": f"#/$defs/{form}"} for form in _forms())]}


def _forms() -> Schema:
    return {
        "linspace": _form("linspace", "[first, last]: `num` evenly spaced values", 2, num=True),
        "geomspace": _form(
            "geomspace", "[first, last]: `num` values of constant ratio; not exponents", 2, num=True
        ),
        "arange": _form("arange", "[start, stop, step]: the stop is included", 3, num=False),
    }


def _form(name: str, description: str, count: int, *, num: bool) -> Schema:
    ends = {"type": "array", "items": _NUMBER, "minItems": count, "maxItems": count}
    properties = {name: {**ends, "description": description}} | ({"num": _NUM} if num else {})
    return {
        "type": "object",
        "additionalProperties": False,
        "required": list(properties),
        "properties": properties,
    }


def _sections() -> Schema:
    """Pydantic's schemas of the sections, under the names that they have in a config."""
    models = [(model, "validation") for model in SECTIONS.values()]
    _, schema = models_json_schema(models)  # type: ignore[arg-type]  # a list is a Sequence
    definitions = schema["$defs"]
    return {name: _with_rationals(definitions[m.__name__]) for name, m in SECTIONS.items()}


def _with_rationals(schema: Any) -> Any:
    """The same schema, where a fraction may stand for any number, without pydantic's titles."""
    if isinstance(schema, list):
        return [_with_rationals(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
    schema = {key: value for key, value in schema.items() if key != "title"}
    if schema.get("type") == "number":
        outer = {key: schema[key] for key in ("description", "default") if key in schema}
        inner = {key: value for key, value in schema.items() if key not in outer}
        return outer | {"anyOf": [inner, _RATIONAL]}
    return {key: _with_rationals(value) for key, value in schema.items()}


def _nullable(schema: Schema) -> Schema:
    return {"anyOf": [schema, {"type": "null"}]}
