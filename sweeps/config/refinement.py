"""`refine`: axes computed coarsely first, and then more finely where needed."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from annotated_types import Len
from pydantic import AfterValidator, BeforeValidator, Field, PlainValidator

from stickslip.variables import canonical_name
from sweeps.config.group import Group
from sweeps.config.numbers import Text, finite
from sweeps.config.written_config import quoted

_MOST_LEVELS = 6
_MOST_AXES = 3  # with more axes, corners of cells cost more points than refinement saves
_REGIME = "regime"

# The full name of a parameter; a later check requires that it is swept.
AxisName = Annotated[Text, AfterValidator(lambda name: canonical_name(name) or name)]


def _condition(value: object) -> str | float:
    if value == _REGIME:
        return _REGIME
    try:
        part = finite(value)
    except ValueError:
        raise ValueError(f"must be {_REGIME} or a number, not {quoted(value)}") from None
    if not 0 < part < 1:
        raise ValueError(f"must be a fraction between 0 and 1, not {part:g}")
    return part


Condition = Annotated[
    str | float,
    PlainValidator(
        _condition,
        json_schema_input_type=Literal["regime"] | Annotated[float, Field(gt=0, lt=1)],
    ),
]


def _with_regime(conditions: tuple[str | float, ...]) -> tuple[str | float, ...]:
    """Return the conditions in a fixed order; the regime counts even if it is not named."""
    parts = [condition for condition in conditions if condition != _REGIME]
    if len(parts) > 1:
        raise ValueError(f"takes {_REGIME} and at most one number, such as [{_REGIME}, 1e-2]")
    return _REGIME, *parts


class Refine(Group):
    """Axes computed coarsely, then more finely where the regime changes or interpolation misses."""

    example: ClassVar[str] = (
        "{axes: [temperature, angular_frequency], levels: 3, where: [regime, 1e-2]}"
    )

    axes: Annotated[list[AxisName], Len(1, _MOST_AXES)] = Field(description="swept axes")
    levels: int = Field(3, ge=1, le=_MOST_LEVELS, description="halvings of the spacing")
    where: Annotated[
        tuple[Condition, ...],
        AfterValidator(_with_regime),
        BeforeValidator(lambda value: value if isinstance(value, (list, tuple)) else [value]),
    ] = Field(
        (_REGIME, 1e-2),
        description=f"`{_REGIME}`: refine where the regime changes; a number: the fraction of an "
        "amplitude by which interpolation may be wrong in the middle of a cell",
    )

    @property
    def miss(self) -> float | None:
        """The number in `where`, a fraction of an amplitude; None if only the regime counts."""
        return next((part for part in self.where if isinstance(part, float)), None)
