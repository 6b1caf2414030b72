"""The points of a sweep: which parameters are fixed, which are swept, which are linked in cases."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from itertools import pairwise

from stickslip.variables import BY_SYMBOL, PARAMETERS, canonical_name
from sweeps.config.axes import Axis, finite, parse_axis
from sweeps.config.diagnostics import Findings, Origin, did_you_mean, shown
from sweeps.config.located import UNREADABLE, Entry
from sweeps.config.numbers import whole

MAX_POINTS = 1_000_000_000
SECTIONS = ("model", "sweep", "cases")
# Relative; closer neighbours on an axis differ by rounding rather than by intention.
_NEAR_DUPLICATE = 1e-9
# The paper's k lies above, its K below; both on the wrong side look exchanged.
_K_BORDER = 1e4


@dataclass(frozen=True)
class Space:
    """Parameters by full name: fixed values, axes of the product, and values linked in cases.

    `refused` names the parameters that the config gives, but whose values are not known because
    they were refused.
    """

    model: dict[str, float]
    sweep: dict[str, tuple[float, ...]]
    cases: dict[str, tuple[float, ...]]
    refused: frozenset[str] = frozenset()

    def values(self, name: str) -> tuple[float, ...]:
        """All values that the parameter takes."""
        default: float = PARAMETERS[name].default
        return self.sweep.get(name) or self.cases.get(name) or (self.model.get(name, default),)


@dataclass(frozen=True)
class _Given:
    """A parameter as the config gives it, under its full name or its symbol."""

    name: str
    key: str
    entry: Entry


def read_space(root: Entry, case: Entry | None, findings: Findings) -> Space:
    """The space of a config, reduced to one case where `case` picks it.

    What is refused is noted and left out, so that the rest is judged all the same.
    """
    model, sweep, cases = (_given(root, section, findings) for section in SECTIONS)
    _refuse_repeats([*model, *sweep, *cases], findings)
    axes = {given.name: parse_axis(given.entry, given.key, findings) for given in sweep}
    linked = {given.name: parse_axis(given.entry, given.key, findings) for given in cases}
    if not _sizes_fit(root, axes, linked, findings):
        axes, linked = dict.fromkeys(axes), dict.fromkeys(linked)
    fixed = {given.name: _fixed(given, findings) for given in model}
    swept = {given.name: _swept(given, axes[given.name], findings) for given in sweep}
    tied = {given.name: _linked(given, linked[given.name], findings) for given in cases}
    space = Space(
        model={name: value for name, value in fixed.items() if value is not None},
        sweep={name: values for name, values in swept.items() if values},
        cases={name: values for name, values in tied.items() if values},
    )
    _refuse_repeated_cases(root, space, findings)
    _warn_of_exchange(root, space, findings)
    return _one_case(replace(space, refused=_refused(root, space)), case, findings)


def refuse_frozen_start(
    root: Entry, space: Space, treatment: str, where: Origin, findings: Findings
) -> None:
    """Refuse a point that starts at phi = 0 without noise: its film would stay liquid for ever."""
    start, noise = "initial_order_parameter", "noise_intensity"
    if start in space.refused or not _starts_at_zero(space, treatment, start, noise):
        return
    key, origin = (
        _where_given(root, start)
        or (_where_given(root, noise) if treatment != "none" else None)
        or ("noise.treatment", where)
    )
    findings.refuse(
        origin,
        key,
        "initial_order_parameter (phi_0) is 0 without noise: phi = 0 is an exact zero of the "
        "equation, so the film could never solidify; start at a small value such as 0.01, or keep "
        "`noise: {treatment: typical-path}` with noise_intensity above 0",
    )


def _starts_at_zero(space: Space, treatment: str, start: str, noise: str) -> bool:
    if treatment == "none":
        return 0 in space.values(start)
    if start in space.cases and noise in space.cases:
        return (0, 0) in zip(space.cases[start], space.cases[noise], strict=False)
    return 0 in space.values(start) and 0 in space.values(noise)


def _given(root: Entry, section: str, findings: Findings) -> list[_Given]:
    """The parameters that a section names; unknown names are refused."""
    entry = root.value.get(section)
    if entry is None or entry.value is None or entry.value is UNREADABLE:
        return []
    if not isinstance(entry.value, dict):
        message = f"must hold lines `parameter: value`, not {shown(entry.value)}"
        findings.refuse(entry.origin, section, message)
        return []
    for key, child in entry.value.items():
        if canonical_name(key) is None:
            hint = did_you_mean(key, [*PARAMETERS, *BY_SYMBOL])
            hint = "; is it the rest of 3,000? write 3000" if key.isdigit() else hint
            findings.refuse(child.origin, f"{section}.{key}", f"unknown parameter{hint}")
    named = ((canonical_name(key), key, child) for key, child in entry.value.items())
    return [_Given(name, f"{section}.{key}", child) for name, key, child in named if name]


def _refuse_repeats(all_given: Iterable[_Given], findings: Findings) -> None:
    first: dict[str, _Given] = {}
    for given in all_given:
        other = first.setdefault(given.name, given)
        if other is not given:
            line = other.entry.origin.line
            where = f" in line {line}" if line else ""
            message = f"gives {given.name} a second time, after {other.key}{where}; keep one"
            findings.refuse(given.entry.origin, given.key, message)


def _fixed(given: _Given, findings: Findings) -> float | None:
    if isinstance(given.entry.value, (list, dict)):
        message = f"must be a single number; an axis belongs under `sweep`: sweep.{given.name}"
        findings.refuse(given.entry.origin, given.key, message)
        return None
    value = finite(given.entry, given.key, findings)
    return None if value is None or not _valid(given, (value,), findings) else value


def _valid(given: _Given, values: tuple[float, ...], findings: Findings) -> bool:
    """Whether all values lie in the parameter's range; each that was written out is judged."""
    judge = PARAMETERS[given.name].complaint
    complaints = {i: c for i, value in enumerate(values) if (c := judge(value))}
    items = given.entry.value
    if isinstance(items, list):
        for i, complaint in complaints.items():
            findings.refuse(items[i].origin, f"{given.key}[{i}]", complaint)
    elif complaints:
        more = f" (and {len(complaints) - 1} more of its values)" if len(complaints) > 1 else ""
        findings.refuse(given.entry.origin, given.key, next(iter(complaints.values())) + more)
    return not complaints


def _swept(given: _Given, axis: Axis | None, findings: Findings) -> tuple[float, ...] | None:
    values = axis.values() if axis else ()
    _judge_neighbours(given, values, findings)
    return values if _valid(given, values, findings) else None


def _judge_neighbours(given: _Given, values: tuple[float, ...], findings: Findings) -> None:
    pairs = list(pairwise(sorted(values)))
    repeated = dict.fromkeys(a for a, b in pairs if a == b)
    if repeated:
        listed = ", ".join(map(repr, list(repeated)[:5])) + (", …" if len(repeated) > 5 else "")
        message = f"has values that occur more than once: {listed}"
        findings.refuse(given.entry.origin, given.key, message)
        return
    near = [(a, b) for a, b in pairs if b - a <= _NEAR_DUPLICATE * max(abs(a), abs(b))]
    if near:
        message = "has neighbours that differ by less than 1e-9 of their value: {!r} and {!r}"
        findings.warn(given.entry.origin, given.key, message.format(*near[0]))


def _linked(given: _Given, axis: Axis | None, findings: Findings) -> tuple[float, ...] | None:
    values = axis.values() if axis else ()
    return values if _valid(given, values, findings) else None


def _sizes_fit(
    root: Entry,
    axes: dict[str, Axis | None],
    linked: dict[str, Axis | None],
    findings: Findings,
) -> bool:
    """Whether the grid may be laid out; judged before any axis is."""
    lengths = {name: axis.size for name, axis in linked.items() if axis}
    if len(set(lengths.values())) > 1:
        listed = ", ".join(f"{name} {size}" for name, size in lengths.items())
        message = f"linked parameters need equally many values, but have: {listed}"
        findings.refuse(root.value["cases"].origin, "cases", message)
    sizes = [axis.size for axis in axes.values() if axis]
    points = math.prod(sizes) * max(lengths.values(), default=1)
    if points > MAX_POINTS:
        section = "sweep" if axes else "cases"
        message = f"{points} points are more than {MAX_POINTS}; take fewer values or axes"
        findings.refuse(root.value[section].origin, section, message)
    return points <= MAX_POINTS


def _refuse_repeated_cases(root: Entry, space: Space, findings: Findings) -> None:
    first: dict[tuple[float, ...], int] = {}
    for index, values in enumerate(zip(*space.cases.values(), strict=False)):
        other = first.setdefault(values, index)
        if other != index:
            message = f"case {index} repeats case {other} (counted from 0)"
            findings.refuse(root.value["cases"].origin, "cases", message)
            return


def _warn_of_exchange(root: Entry, space: Space, findings: Findings) -> None:
    k, K = space.values("viscosity_coefficient"), space.values("spring_stiffness")
    if max(k) <= _K_BORDER <= min(K) and min(k) < _K_BORDER < max(K):
        key, where = _where_given(root, "spring_stiffness") or ("", root.origin)
        message = (
            f"K = {K[0]:g} N/m with k = {k[0]:g} Pa s: both are far from their usual magnitude "
            "(K about 3000, k about 5e4), as if k and K were exchanged"
        )
        findings.warn(where, key, message)


def _refused(root: Entry, space: Space) -> frozenset[str]:
    """The parameters without a known value: all of them where a whole section is unreadable."""
    known = {*space.model, *space.sweep, *space.cases}
    names: set[str] = set()
    for section in SECTIONS:
        value = root.value[section].value if section in root.value else None
        if isinstance(value, dict):
            names |= {name for key in value if (name := canonical_name(key))}
        elif value is not None:
            names |= set(PARAMETERS)
    return frozenset(names - known)


def _one_case(space: Space, case: Entry | None, findings: Findings) -> Space:
    """The space with the linked parameters fixed at the values of one case."""
    if case is None:
        return space
    count = min(map(len, space.cases.values()), default=0)
    try:
        index = whole(case.value)
    except ValueError as error:
        findings.refuse(case.origin, "case", str(error))
        return space
    if not 0 <= index < count:
        message = f"must be 0 ... {count - 1}" if count else "there are no `cases` to pick from"
        findings.refuse(case.origin, "case", message)
        return space
    picked = {name: values[index] for name, values in space.cases.items()}
    return replace(space, model={**space.model, **picked}, cases={})


def _where_given(root: Entry, name: str) -> tuple[str, Origin] | None:
    for section in SECTIONS:
        entry = root.value.get(section)
        for key in entry.value if entry and isinstance(entry.value, dict) else ():
            if canonical_name(key) == name:
                return f"{section}.{key}", entry.value[key].origin
    return None
