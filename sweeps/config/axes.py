"""The values of an axis: a list, or one of the forms linspace, geomspace and arange."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

from sweeps.config.diagnostics import Findings, did_you_mean, shown
from sweeps.config.located import UNREADABLE, Entry
from sweeps.config.numbers import number, whole

# Far above any sweep of this model, far below what would fill the memory.
MAX_VALUES = 1_000_000
# Of a step: decides whether the stop of an arange is one of its values.
_STOP_TOLERANCE = 1e-9

_FORMS = {
    "linspace": "{linspace: [first, last], num: 171}",
    "geomspace": "{geomspace: [first, last], num: 171}",
    "arange": "{arange: [start, stop, step]}",
}
EXAMPLES = "a list such as [200, 250], or " + ", ".join(_FORMS.values())


@dataclass(frozen=True)
class Axis:
    """How many values an axis has, and how to make them: sizes are judged before memory is used."""

    size: int
    values: Callable[[], tuple[float, ...]]


def parse_axis(entry: Entry, key: str, findings: Findings) -> Axis | None:
    """The axis that `entry` describes; None where it is refused."""
    if entry.value is UNREADABLE:
        return None
    if isinstance(entry.value, list):
        return _listed(entry, key, findings)
    if isinstance(entry.value, dict):
        return _formed(entry, key, findings)
    findings.refuse(entry.origin, key, f"must be {EXAMPLES}, not {shown(entry.value)}")
    return None


def _listed(entry: Entry, key: str, findings: Findings) -> Axis | None:
    if not entry.value:
        findings.refuse(entry.origin, key, "has no values; name at least one, or leave it out")
        return None
    values = _numbers(entry, key, findings)
    return None if values is None else _axis(entry, key, findings, len(values), lambda: values)


def _numbers(entry: Entry, key: str, findings: Findings) -> tuple[float, ...] | None:
    """The numbers of a list; None, after all its items are judged, where one is refused."""
    values = [finite(item, f"{key}[{i}]", findings) for i, item in enumerate(entry.value)]
    accepted = tuple(value for value in values if value is not None)
    return accepted if len(accepted) == len(values) else None


def finite(entry: Entry, key: str, findings: Findings) -> float | None:
    """The finite number in `entry`; None where it is refused."""
    if entry.value is UNREADABLE:
        return None
    try:
        value = number(entry.value)
    except ValueError as error:
        findings.refuse(entry.origin, key, str(error))
        return None
    if math.isfinite(value):
        return value
    findings.refuse(entry.origin, key, f"must be a finite number, not {shown(entry.value)}")
    return None


def _formed(entry: Entry, key: str, findings: Findings) -> Axis | None:
    forms = [name for name in _FORMS if name in entry.value]
    if len(forms) != 1:
        unknown = next(iter(entry.value), "")
        hint = did_you_mean(unknown, _FORMS) if not forms else ""
        findings.refuse(entry.origin, key, f"must be {EXAMPLES}{hint}")
        return None
    form = forms[0]
    count = 3 if form == "arange" else 2
    _refuse_other_keys(entry, key, form, findings)
    ends = _ends(entry.value[form], f"{key}.{form}", count, form, findings)
    if form == "arange":
        return None if ends is None else _arange(entry, key, ends, findings)
    num = _num(entry, key, form, findings)
    if form == "geomspace" and ends and not _same_sign(*ends):
        message = f"no logarithmic axis leads from {ends[0]:g} to {ends[1]:g}: both must have the "
        message += "same sign and not be 0 (they are values, not exponents)"
        findings.refuse(entry.value[form].origin, f"{key}.{form}", message)
        return None
    return None if ends is None or num is None else _spaced(entry, key, form, ends, num, findings)


def _refuse_other_keys(entry: Entry, key: str, form: str, findings: Findings) -> None:
    known = {form} if form == "arange" else {form, "num"}
    for name, child in entry.value.items():
        if name not in known:
            message = f"unknown key; write {_FORMS[form]}{did_you_mean(name, known)}"
            findings.refuse(child.origin, f"{key}.{name}", message)


def _ends(
    entry: Entry, key: str, count: int, form: str, findings: Findings
) -> tuple[float, ...] | None:
    if entry.value is UNREADABLE:
        return None
    if not isinstance(entry.value, list) or len(entry.value) != count:
        got = f"{len(entry.value)}" if isinstance(entry.value, list) else shown(entry.value)
        message = f"must be a list of {count} numbers, not {got}; write {_FORMS[form]}"
        findings.refuse(entry.origin, key, message)
        return None
    return _numbers(entry, key, findings)


def _num(entry: Entry, key: str, form: str, findings: Findings) -> int | None:
    if "num" not in entry.value:
        findings.refuse(entry.origin, key, f"`num` is missing; write {_FORMS[form]}")
        return None
    child = entry.value["num"]
    if child.value is UNREADABLE:
        return None
    try:
        num = whole(child.value)
    except ValueError as error:
        findings.refuse(child.origin, f"{key}.num", str(error))
        return None
    if num < 1:
        findings.refuse(child.origin, f"{key}.num", f"must be at least 1, not {num}")
        return None
    return num


def _same_sign(first: float, last: float) -> bool:
    return first != 0 and last != 0 and (first < 0) == (last < 0)


def _spaced(
    entry: Entry, key: str, form: str, ends: tuple[float, ...], num: int, findings: Findings
) -> Axis | None:
    values = _evenly if form == "linspace" else _geometrically
    return _axis(entry, key, findings, num, lambda: values(ends[0], ends[1], num))


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


def _arange(entry: Entry, key: str, ends: tuple[float, ...], findings: Findings) -> Axis | None:
    start, stop, step = ends
    steps = (stop - start) / step if step else math.nan
    if math.isnan(steps) or steps < -_STOP_TOLERANCE:
        message = f"no steps of {step:g} lead from {start:g} to {stop:g}; write {_FORMS['arange']}"
        findings.refuse(entry.value["arange"].origin, f"{key}.arange", message)
        return None
    size = math.floor(steps + _STOP_TOLERANCE) + 1 if steps < MAX_VALUES else MAX_VALUES + 1

    def values() -> tuple[float, ...]:
        made = _steps(_as_written(start), _as_written(step), size)
        return (*made[:-1], stop) if abs(size - 1 - steps) <= _STOP_TOLERANCE else made

    return _axis(entry, key, findings, size, values)


def _axis(
    entry: Entry,
    key: str,
    findings: Findings,
    size: int,
    values: Callable[[], tuple[float, ...]],
) -> Axis | None:
    if size <= MAX_VALUES:
        return Axis(size, values)
    findings.refuse(entry.origin, key, f"has more than {MAX_VALUES} values; take fewer")
    return None
