"""The JSON Schema of a config, for editors that complete and check YAML while it is written.

It says what one value may be; what needs two values, such as a parameter both fixed and swept, is
judged by `sweeps.config.load` alone.
"""

from __future__ import annotations

import json
import math
from typing import Annotated, Any, Literal, TypeAlias

from annotated_types import Len
from pydantic import BaseModel, ConfigDict, Field, RootModel, create_model
from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
from pydantic_core.core_schema import FloatSchema

from stickslip.variables import PARAMETERS, STARTING, ParameterVariable
from sweeps.config.axes import FORMS, MAX_VALUES, Form
from sweeps.config.numbers import RATIONAL_PATTERN
from sweeps.config.order import MOST_AXES, MOST_LEVELS, Refine
from sweeps.config.schema import SECTIONS, Simulation

# What pydantic makes models of: types, and pairs of a type and a field.
_Type: TypeAlias = Any


class _Generator(GenerateJsonSchema):
    """Pydantic's schema, where a fraction may stand for any number, without a title per key."""

    def float_schema(self, schema: FloatSchema) -> JsonSchemaValue:
        rational = {"type": "string", "pattern": RATIONAL_PATTERN}
        return {"anyOf": [super().float_schema(schema), rational]}

    def field_title_should_be_set(self, schema: Any) -> bool:  # noqa: ARG002 - pydantic's signature
        return False


def json_schema() -> dict[str, Any]:
    """The schema, draft 2020-12, as a mapping ready for JSON."""
    values = {name: _value(variable) for name, variable in PARAMETERS.items()}
    forms = [_form(name, form) for name, form in FORMS.items()]
    axes = {name: _axis(name, value, forms) for name, value in values.items()}
    sections = SECTIONS | {"simulation": _with_schedule(axes)}
    config = _model(
        "stickslip config",
        "What to compute, how, and where to write it.",
        title=_key(str | None, "One line about the result."),
        model=_parameters("model", "Fixed parameters; the rest keep the paper's values.", values),
        sweep=_parameters("sweep", "Full product of these axes, in this order.", axes),
        cases=_parameters("cases", "Linked values: the first of each, the second ...", axes),
        sample=_sample(values),
        follow=_key(str | None, "Swept axis along which each point starts from the one before."),
        refine=_refine(),
        **{name: (section | None, None) for name, section in sections.items()},
        output=_key(str | None, "Result file; left out, NAME.yaml writes results/NAME.nc."),
    )
    dialect = {"$schema": "https://json-schema.org/draft/2020-12/schema"}
    return dialect | config.model_json_schema(schema_generator=_Generator)


def json_schema_text() -> str:
    """The schema as it is shipped."""
    return json.dumps(json_schema(), indent=2, ensure_ascii=False) + "\n"


def _model(name: str, description: str, **fields: _Type) -> type[BaseModel]:
    return create_model(name, __config__=ConfigDict(extra="forbid"), __doc__=description, **fields)


def _key(kind: _Type, description: str) -> _Type:
    # A factory makes the key optional without a default in the schema.
    return kind, Field(default_factory=lambda: None, description=description)


def _parameters(section: str, description: str, kinds: dict[str, _Type]) -> _Type:
    """A section of parameters, by name and by symbol."""
    fields = {}
    for name in kinds:
        variable = PARAMETERS[name]
        text = f"{variable.meaning} ({variable.symbol}) [{variable.units}]"
        text += f": {variable.comment}" if variable.comment else ""
        key = _key(kinds[name], text)
        if section == "model":
            key = kinds[name], Field(variable.default, description=text)
        fields[name] = fields[variable.symbol] = key
    return _model(section, description, **fields) | None, None


def _with_schedule(axes: dict[str, _Type]) -> _Type:
    """The section `simulation`, with the parameters that a schedule may hold."""
    free = {name: axis for name, axis in axes.items() if name not in STARTING}
    about = Simulation.model_fields["schedule"].description
    kind, _ = _parameters("schedule", about or "", free)
    schedule = kind, Field(None, description=about)
    about = Simulation.__doc__
    return create_model("Simulation", __base__=Simulation, __doc__=about, schedule=schedule)


def _sample(values: dict[str, _Type]) -> _Type:
    """The section `sample`: how many points, and the range of each parameter."""
    about = "Points drawn from a box, as linked values; NAME: [low, high] or {log: [low, high]}."
    count = Annotated[int, Field(ge=1, le=MAX_VALUES)]
    fields: dict[str, _Type] = {
        "sobol": _key(count, "points of a scrambled Sobol sequence, best a power of 2"),
        "latin_hypercube": _key(count, "points of a Latin hypercube"),
        "seed": (Annotated[int, Field(ge=0)], Field(0, description="where the draw begins")),
    }
    for name, value in values.items():
        ends = Annotated[list[value], Len(2, 2)]  # type: ignore[valid-type]
        logarithmic = _model("log", "{log: [low, high]}", log=(ends, Field()))
        fields[name] = fields[PARAMETERS[name].symbol] = _key(
            ends | logarithmic, PARAMETERS[name].meaning
        )
    return _model("sample", about, **fields) | None, None


def _refine() -> _Type:
    """The section `refine`."""
    about = "Axes computed coarsely first, then finer where the regime changes or a middle misses."
    where = list[Literal["regime"] | Annotated[float, Field(gt=0, lt=1)]]
    fields: dict[str, _Type] = {
        "axes": (Annotated[list[str], Len(1, MOST_AXES)], Field(description="swept axes")),
        "levels": (
            Annotated[int, Field(ge=1, le=MOST_LEVELS)],
            Field(Refine.levels, description="halvings of the spacing"),
        ),
        "where": (
            where,
            Field(
                ["regime", Refine.miss],
                description="a change of regime; part of an amplitude by which the middle of a "
                "cell may miss interpolation",
            ),
        ),
    }
    return _model("refine", about, **fields) | None, None


def _value(variable: ParameterVariable) -> _Type:
    """The value of a parameter; a model, so that the schema defines it once."""
    lower, upper = variable.lower, variable.upper
    bounds = Field(
        gt=lower if variable.lower_open else None,
        ge=None if variable.lower_open or math.isinf(lower) else lower,
        le=None if math.isinf(upper) else upper,
        json_schema_extra={"not": {"const": 0}} if variable.nonzero else None,
    )
    kind: _Type = RootModel[Annotated[float, bounds]]
    return create_model(f"value_{variable.name}", __base__=kind)


def _axis(name: str, value: _Type, forms: list[_Type]) -> _Type:
    kind: _Type = Annotated[list[value], Len(1, MAX_VALUES)]
    for form in forms:
        kind |= form
    return create_model(f"axis_{name}", __base__=RootModel[kind])


def _form(name: str, form: Form) -> _Type:
    ends = Annotated[list[float], Len(form.ends, form.ends)]
    fields: dict[str, _Type] = {name: (ends, Field(description=form.meaning))}
    if form.counted:
        fields["num"] = (Annotated[int, Field(ge=1, le=MAX_VALUES)], Field())
    return _model(name, form.example, **fields)
