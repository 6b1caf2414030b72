"""The JSON Schema of a config, with which editors complete and check YAML.

It checks single values. Only `sweeps.config.load` finds conflicts between values, such as a
parameter both fixed and swept.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from typing import Any

from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
from pydantic_core.core_schema import FloatSchema

from stickslip.variables import PARAMETERS, STARTING, ParameterVariable
from sweeps.config.numbers import RATIONAL_PATTERN
from sweeps.config.schema import Config

_DIALECT = "https://json-schema.org/draft/2020-12/schema"


class _Generator(GenerateJsonSchema):
    """Pydantic's schema, but with fractions allowed for all numbers and without titles of keys."""

    def float_schema(self, schema: FloatSchema) -> JsonSchemaValue:
        rational = {"type": "string", "pattern": RATIONAL_PATTERN}
        return {"anyOf": [super().float_schema(schema), rational]}

    def field_title_should_be_set(self, schema: Any) -> bool:  # noqa: ARG002 - pydantic's signature
        return False


def json_schema() -> dict[str, Any]:
    """Return the schema, according to draft 2020-12, as a mapping ready for JSON."""
    schema = Config.model_json_schema(schema_generator=_Generator)
    keys, groups = schema["properties"], schema["$defs"]
    schedule = groups["Simulation"]["properties"]["schedule"]["anyOf"][0]
    groups["Number"] = _name_parameters(keys["model"], "Number", dict)
    for mapping in (keys["sweep"], keys["cases"], schedule):
        groups["Axis"] = _name_parameters(mapping, "Axis", lambda bounds: {"items": bounds})
    groups["Distribution"] = _name_parameters(
        groups["Sample"],
        "Distribution",
        lambda bounds: {
            "items": bounds,
            "properties": {"log": {"items": bounds}},
        },
    )
    for name in STARTING:  # cannot be scheduled: a run begins once
        del schedule["properties"][name], schedule["properties"][PARAMETERS[name].symbol]
    # A section without keys is null in YAML, and editors should not insert its defaults.
    for name, key in keys.items():
        key.pop("default", None)
        keys[name] = key if "anyOf" in key else {"anyOf": [key, {"type": "null"}]}
    about = schema["description"].partition("\n")[0]
    return {"$schema": _DIALECT} | schema | {"title": "stickslip config", "description": about}


def json_schema_text() -> str:
    """Return the text of the schema that we ship."""
    return json.dumps(json_schema(), indent=2, ensure_ascii=False) + "\n"


def _name_parameters(
    mapping: dict[str, Any], kind: str, within: Callable[[dict[str, Any]], dict[str, Any]]
) -> Any:
    """Add all parameters as keys to the schema of a mapping, by full name and by symbol.

    Each key refers to a `kind` of values, whose schema is returned. `within` returns the keywords
    that keep such a value within the bounds of a parameter.
    """
    schema, keys = mapping["additionalProperties"], mapping.setdefault("properties", {})
    for name, variable in PARAMETERS.items():
        meaning = f"{variable.meaning} ({variable.symbol}) [{variable.unit or 1}]"
        meaning += f": {variable.comment}" if variable.comment else ""
        key = {"$ref": f"#/$defs/{kind}", **within(_bounds(variable)), "description": meaning}
        keys[name] = keys[variable.symbol] = key
    mapping["additionalProperties"] = False
    return schema


def _bounds(variable: ParameterVariable) -> dict[str, Any]:
    """Return the keywords for the range of a parameter, which only apply to numbers."""
    bounds: dict[str, Any] = {}
    if math.isfinite(variable.lower):
        bounds["exclusiveMinimum" if variable.lower_open else "minimum"] = variable.lower
    if math.isfinite(variable.upper):
        bounds["maximum"] = variable.upper
    return bounds | ({"not": {"const": 0}} if variable.nonzero else {})
