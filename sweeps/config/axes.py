"""The values of an axis: a list, or one of the forms linspace, geomspace and arange."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

from sweeps.config.diagnostics import Located, quoted
from sweeps.config.numbers import finite, whole
from sweeps.human import did_you_mean

# Far above any sweep of this model, far below what would fill the memory.
MAX_VALUES = 1_000_000
# Of a step: decides whether the stop of an arange is one of its values.
_STOP_TOLERANCE = 1e-9


@dataclass(frozen=True)
class Form:
    """A way to write an axis: how many numbers it takes, and whether it takes `num` as well."""

    example: str
    meaning: str
    ends: int = 2
    counted: bool = True


FORMS = {
    "linspace": Form(
        "{linspace: [first, last], num: 171}", "[first, last]: `num` evenly spaced values"
    ),
    "geomspace": Form(
        "{geomspace: [first, last], num: 171}",
        "[first, last]: `num` values of constant ratio; not exponents",
    ),
    "arange": Form(
        "{arange: [start, stop, step]}",
        "[start, stop, step]: the stop is included",
        ends=3,
        counted=False,
    ),
}
_EXAMPLES = "a list such as [200, 250], or " + ", ".join(form.example for form in FORMS.values())


@dataclass(frozen=True)
class Axis:
    """How many values an axis has, and how to make them: sizes are judged before memory is used."""

    size: int
    values: Callable[[], tuple[float, ...]]


def parse_axis(node: Located) -> Axis | None:
    """The axis that a value describes; None where it is refused."""
    return node.read(lambda _: _axis(node))


def _axis(node: Located) -> Axis | None:
    """The axis; None where something below is refused, a ValueError where the value itself is."""
    if isinstance(node.value, dict):
        axis = _formed(node)
    elif not isinstance(node.value, list):
        raise ValueError(f"must be {_EXAMPLES}, not {quoted(node.value)}")
    elif not node.value:
        raise ValueError("has no values; name at least one, or leave it out")
    else:
        values = _numbers(node)
        axis = None if values is None else Axis(len(values), lambda: values)
    if axis and axis.size > MAX_VALUES:
        raise ValueError(f"has more than {MAX_VALUES} values; take fewer")
    return axis


def _numbers(node: Located) -> tuple[float, ...] | None:
    """The numbers of a list; None, after all its items are judged, where one is refused."""
    values = [item.read(finite) for item in node.value]
    accepted = tuple(value for value in values if value is not None)
    return accepted if len(accepted) == len(values) else None


def _formed(node: Located) -> Axis | None:
    names = [name for name in FORMS if name in node.value]
    if len(names) != 1:
        hint = "" if names else did_you_mean(next(iter(node.value), ""), FORMS)
        raise ValueError(f"must be {_EXAMPLES}{hint}")
    name, form = names[0], FORMS[names[0]]
    known = [name, "num"] if form.counted else [name]
    for key in node.value:
        if key not in known:
            node.refuse(f"unknown key; write {form.example}{did_you_mean(key, known)}", key)
    here: Located = node.value[name]
    ends = here.read(lambda _: _ends(here, form))
    if not form.counted:
        return here.read(lambda _: _arange(*ends)) if ends else None
    if "num" not in node.value:
        node.refuse(f"`num` is missing; write {form.example}")
    num = node.value["num"].read(_at_least_one) if "num" in node.value else None
    return here.read(lambda _: _spaced(name, ends, num)) if ends else None


def _ends(node: Located, form: Form) -> tuple[float, ...] | None:
    if not isinstance(node.value, list) or len(node.value) != form.ends:
        got = f"{len(node.value)}" if isinstance(node.value, list) else quoted(node.value)
        raise ValueError(f"must be a list of {form.ends} numbers, not {got}; write {form.example}")
    return _numbers(node)


def _at_least_one(value: object) -> int:
    number = whole(value)
    if number < 1:
        raise ValueError(f"must be at least 1, not {number}")
    return number


def _spaced(form: str, ends: tuple[float, ...], num: int | None) -> Axis | None:
    first, last = ends
    if form == "geomspace" and (0 in ends or (first < 0) != (last < 0)):
        raise ValueError(
            f"no logarithmic axis leads from {first:g} to {last:g}: both must have the "
            "same sign and not be 0 (they are values, not exponents)"
        )
    values = _geometrically if form == "geomspace" else _evenly
    return None if num is None else Axis(num, lambda: values(first, last, num))


def _evenly(first: float, last: float, num: int) -> tuple[float, ...]:
    """Evenly spaced values, each rounded once from the decimals as they were written.

    So grids with a value in common have the same float there, and a refined sweep finds the points
    of the coarse one: 0.3 is 0.3 among ten steps from 0 to 1 and among fifty from 0 to 5.
    """
    start, parts = _as_written(first), max(num - 1, 1)
    return _steps(start, (_as_written(last) - start) / parts, num)


def _geometrically(first: float, last: float, num: int) -> tuple[float, ...]:
    """Values of constant ratio; equal parts of the way give equal floats, whatever `num` is."""
    low, high = math.log10(abs(first)), math.log10(abs(last))
    parts = (i / (num - 1) for i in range(1, num - 1))
    between = (math.copysign(10.0 ** (low + (high - low) * part), first) for part in parts)
    return (first, *between, last) if num > 1 else (first,)


def _as_written(value: float) -> Fraction:
    """The decimal number that a float stands for, such as 1/10 for 0.1."""
    return Fraction(repr(value))


def _steps(start: Fraction, step: Fraction, count: int) -> tuple[float, ...]:
    """The floats next to start + i step."""
    common = math.lcm(start.denominator, step.denominator)
    first, each = int(start * common), int(step * common)
    return tuple((first + each * i) / common for i in range(count))


def _arange(start: float, stop: float, step: float) -> Axis:
    steps = (stop - start) / step if step else math.nan
    if math.isnan(steps) or steps < -_STOP_TOLERANCE:
        form = FORMS["arange"].example
        raise ValueError(f"no steps of {step:g} lead from {start:g} to {stop:g}; write {form}")
    size = math.floor(steps + _STOP_TOLERANCE) + 1 if steps < MAX_VALUES else MAX_VALUES + 1

    def values() -> tuple[float, ...]:
        made = _steps(_as_written(start), _as_written(step), size)
        return (*made[:-1], stop) if abs(size - 1 - steps) <= _STOP_TOLERANCE else made

    return Axis(size, values)
