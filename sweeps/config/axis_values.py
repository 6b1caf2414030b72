"""The values of an axis, from a list or from one of the forms linspace, geomspace and arange."""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction
from typing import Annotated, ClassVar

from annotated_types import Len
from pydantic import AfterValidator, BeforeValidator, Field, TypeAdapter

from sweeps.config.group import Group
from sweeps.config.numbers import Finite
from sweeps.config.written_config import quoted
from sweeps.human import did_you_mean

# Far more than any sweep of this model needs, far less than would fill the memory.
MAX_VALUES = 1_000_000
# As a fraction of a step: an arange includes a stop this close to a step.
_STOP_TOLERANCE = 1e-9

Count = Annotated[int, Field(ge=1, le=MAX_VALUES)]
Pair = Annotated[list[Finite], Len(2, 2)]


def _of_one_sign(ends: list[float]) -> list[float]:
    first, last = ends
    if 0 in ends or (first < 0) != (last < 0):
        raise ValueError(
            f"a logarithmic axis cannot go from {first:g} to {last:g}: both must have the same "
            "sign and not be 0 (they are values, not exponents)"
        )
    return ends


def _with_steps(numbers: list[float]) -> list[float]:
    start, stop, step = numbers
    steps = (stop - start) / step if step else math.nan
    if math.isnan(steps) or steps < -_STOP_TOLERANCE:
        raise ValueError(
            f"steps of {step:g} do not reach {stop:g} from {start:g}; write {Arange.example}"
        )
    if steps >= MAX_VALUES:
        raise ValueError(f"has more than {MAX_VALUES} values; use fewer")
    return numbers


class Linspace(Group):
    """Evenly spaced values, each rounded once from the decimals in the config.

    Grids with a common value therefore have the same float there, and a finer sweep finds the
    points of the coarse one: 0.3 is the same in ten steps from 0 to 1 and in fifty from 0 to 5.
    """

    example: ClassVar[str] = "{linspace: [first, last], num: 171}"

    linspace: Pair = Field(description="[first, last]: `num` evenly spaced values")
    num: Count

    def values(self) -> tuple[float, ...]:
        """Return the values of the axis."""
        first, last = map(_as_written, self.linspace)
        return _steps(first, (last - first) / max(self.num - 1, 1), self.num)


class Geomspace(Group):
    """Values of constant ratio; the same fraction of the way gives the same float for any `num`."""

    example: ClassVar[str] = "{geomspace: [first, last], num: 171}"

    geomspace: Annotated[Pair, AfterValidator(_of_one_sign)] = Field(
        description="[first, last]: `num` values of constant ratio (values, not exponents)"
    )
    num: Count

    def values(self) -> tuple[float, ...]:
        """Return the values of the axis."""
        first, last = self.geomspace
        low, high = math.log10(abs(first)), math.log10(abs(last))
        parts = (i / (self.num - 1) for i in range(1, self.num - 1))
        between = (math.copysign(10.0 ** (low + (high - low) * part), first) for part in parts)
        return (first, *between, last) if self.num > 1 else (first,)


class Arange(Group):
    """Values with a given step, which include the stop if a step comes close to it."""

    example: ClassVar[str] = "{arange: [start, stop, step]}"

    arange: Annotated[list[Finite], Len(3, 3), AfterValidator(_with_steps)] = Field(
        description="[start, stop, step]: includes the stop, if a step reaches it"
    )

    def values(self) -> tuple[float, ...]:
        """Return the values of the axis."""
        start, stop, step = self.arange
        steps = (stop - start) / step
        size = math.floor(steps + _STOP_TOLERANCE) + 1
        made = _steps(_as_written(start), _as_written(step), size)
        return (*made[:-1], stop) if abs(size - 1 - steps) <= _STOP_TOLERANCE else made


_FORMS = {form.__name__.lower(): form for form in (Linspace, Geomspace, Arange)}
_EXAMPLES = "a list such as [200, 250], or " + ", ".join(form.example for form in _FORMS.values())

_List = Annotated[list[Finite], Len(1, MAX_VALUES)]
_NUMBERED = TypeAdapter(dict[int, Finite])


def _values(written: object) -> tuple[float, ...]:
    """Return the values of an axis from the form in the config; raises ValueError."""
    if isinstance(written, list):
        if not written:
            raise ValueError("has no values; name at least one, or leave it out")
        if len(written) > MAX_VALUES:
            raise ValueError(f"has more than {MAX_VALUES} values; use fewer")
        return tuple(_numbers(written))
    keys = written if isinstance(written, dict) else {}
    forms = [form for name, form in _FORMS.items() if name in keys]
    if len(forms) == 1:
        return forms[0].model_validate(written).values()
    hint = did_you_mean(next(iter(keys)), _FORMS) if keys and not forms else ""
    raise ValueError(f"must be {_EXAMPLES}" + (hint if keys else f", not {quoted(written)}"))


def _numbers(written: list[object]) -> Iterator[float]:
    """Yield the numbers in a list; refuse other items, but report a thousand at most.

    Reporting all items of a page pasted into a list would fill the memory.
    """
    for start in range(0, len(written), 1000):
        some = dict(enumerate(written[start : start + 1000], start))
        yield from _NUMBERED.validate_python(some).values()


Axis = Annotated[
    tuple[float, ...],
    BeforeValidator(_values, json_schema_input_type=_List | Linspace | Geomspace | Arange),
]


def _as_written(value: float) -> Fraction:
    """Return the decimal number behind a float, such as 1/10 for 0.1."""
    return Fraction(repr(value))


def _steps(start: Fraction, step: Fraction, count: int) -> tuple[float, ...]:
    """Return the floats nearest to start + i step."""
    common = math.lcm(start.denominator, step.denominator)
    first, each = int(start * common), int(step * common)
    return tuple((first + each * i) / common for i in range(count))
