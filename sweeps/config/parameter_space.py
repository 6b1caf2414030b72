"""The points of a sweep: which parameters are fixed, which are swept, which are linked in cases."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import pairwise, product
from typing import TypeAlias

from stickslip.variables import (
    BY_SYMBOL,
    ENERGY_COEFFICIENTS,
    PARAMETERS,
    STARTING,
    ParameterVariable,
    canonical_name,
    unbounded,
)
from sweeps.config.axes import Axis, parse_axis
from sweeps.config.diagnostics import UNREADABLE, Located, quoted
from sweeps.config.numbers import finite, whole
from sweeps.human import did_you_mean

MAX_POINTS = 1_000_000_000
# The sections of a config in which parameters stand.
PARAMETER_SECTIONS = ("model", "sweep", "cases")
# Relative; closer neighbours on an axis differ by rounding rather than by intention.
_NEAR_DUPLICATE = 1e-9
# The paper's k lies above, its K below; both on the wrong side look exchanged.
_K_BORDER = 1e4
# So many times the paper's value, or less than that part of it, is the value of another unit.
_FAR = 1e4
# Kelvin; below it a temperature was meant in degrees Celsius.
_COLD = 70.0
# Parameters whose sizes say nothing: of any power of ten, or of another unit for each fluid.
_OF_ANY_SIZE = ("viscosity_coefficient", "noise_intensity", "rheological_index", *STARTING)

# Parameters as a section gives them: the full name, and the value under the key that was written.
_Given: TypeAlias = list[tuple[str, Located]]


@dataclass(frozen=True)
class ParameterSpace:
    """Parameters by full name: fixed values, axes of the product, and values linked in cases."""

    model: dict[str, float]
    sweep: dict[str, tuple[float, ...]]
    cases: dict[str, tuple[float, ...]]

    @property
    def names(self) -> set[str]:
        """The parameters with a value of their own."""
        return {*self.model, *self.sweep, *self.cases}

    def values(self, name: str) -> tuple[float, ...]:
        """All values that the parameter takes."""
        default: float = PARAMETERS[name].default
        return self.sweep.get(name) or self.cases.get(name) or (self.model.get(name, default),)

    def combinations(self, names: Collection[str]) -> set[tuple[float, ...]]:
        """The values that these parameters take together at any point."""
        linked = [name for name in names if name in self.cases]
        free = [name for name in names if name not in linked]
        together = zip(*(self.cases[name] for name in linked), strict=True) if linked else [()]
        found = set()
        for values in product(set(together), *(set(self.values(name)) for name in free)):
            by_name = dict(zip((*linked, *free), (*values[0], *values[1:]), strict=True))
            found.add(tuple(by_name[name] for name in names))
        return found


def read_parameter_space(root: Located, case: Located | None) -> ParameterSpace:
    """The parameter space of a config, reduced to one case where `case` picks it.

    What is refused is noted and left out, so that the rest is judged all the same.
    """
    model, sweep, cases = (_given(root, section) for section in PARAMETER_SECTIONS)
    _refuse_repeats([*model, *sweep, *cases])
    axes = {name: parse_axis(node) for name, node in sweep}
    linked = {name: parse_axis(node) for name, node in cases}
    fit = _sizes_fit(root, axes, linked)
    values = {n: axis.values() if axis and fit else () for n, axis in {**linked, **axes}.items()}
    for name, node in sweep:
        _judge_neighbours(node, values[name])
    space = ParameterSpace(
        model={
            name: v[0]
            for name, node in model
            if (v := valid_values(name, node, _fixed(name, node)))
        },
        sweep={name: v for name, node in sweep if (v := valid_values(name, node, values[name]))},
        cases={name: v for name, node in cases if (v := valid_values(name, node, values[name]))},
    )
    _refuse_repeated_cases(root, space)
    _warn_of_exchange(root, space)
    _warn_of_magnitudes(root, space)
    return _one_case(space, case)


def refuse_frozen_start(root: Located, space: ParameterSpace, treatment: str) -> None:
    """Refuse a point that starts at phi = 0 without noise: its film would stay liquid for ever."""
    start, noise = "initial_order_parameter", "noise_intensity"
    if _is_refused(root, space, start) or not _starts_at_zero(space, treatment, start, noise):
        return
    message = (
        "initial_order_parameter (phi_0) is 0 without noise: phi = 0 is an exact zero of the "
        "equation, so the film could never solidify; start at a small value such as 0.01, or keep "
        "`noise: {treatment: typical-path}` with noise_intensity above 0"
    )
    node = _where_given(root, start) or (_where_given(root, noise) if treatment != "none" else None)
    if node:
        node.refuse(message)
    else:
        root.refuse(message, "noise", "treatment")


def refuse_unbounded_films(root: Located, space: ParameterSpace) -> None:
    """Refuse points whose order parameter would grow without bound."""
    if any(_is_refused(root, space, name) for name in ENERGY_COEFFICIENTS):
        return
    for values in space.combinations(ENERGY_COEFFICIENTS):
        if growth := unbounded(*values):
            nodes = (_where_given(root, name) for name in ENERGY_COEFFICIENTS)
            node = next(filter(None, nodes))  # the defaults are bounded
            node.refuse(f"{growth}: the order parameter would grow without bound")
            return


def _starts_at_zero(space: ParameterSpace, treatment: str, start: str, noise: str) -> bool:
    if treatment == "none":
        return 0 in space.values(start)
    if start in space.cases and noise in space.cases:
        return (0, 0) in zip(space.cases[start], space.cases[noise], strict=False)
    return 0 in space.values(start) and 0 in space.values(noise)


def _given(root: Located, section: str) -> _Given:
    """The parameters that a section names; unknown names are refused."""
    node = root.value.get(section)
    return given_parameters(node) if node else []


def given_parameters(node: Located, others: Collection[str] = ()) -> _Given:
    """The parameters that stand below a key, besides others; unknown names are refused."""
    if node.value is None or node.value is UNREADABLE:
        return []
    if not isinstance(node.value, dict):
        node.refuse(f"must hold lines `parameter: value`, not {quoted(node.value)}")
    for key in node.children():
        if canonical_name(key) is None and key not in others:
            hint = did_you_mean(key, [*PARAMETERS, *BY_SYMBOL, *others])
            hint = "; is it the rest of 3,000? write 3000" if key.isdigit() else hint
            node.refuse(f"unknown parameter{hint}", key)
    return [
        (name, child) for key, child in node.children().items() if (name := canonical_name(key))
    ]


def _refuse_repeats(given: Iterable[tuple[str, Located]]) -> None:
    first: dict[str, Located] = {}
    for name, node in given:
        other = first.setdefault(name, node)
        if other is not node:
            where = f" in line {other.line}" if other.line else ""
            node.refuse(f"gives {name} a second time, after {other.key}{where}; keep one")


def _fixed(name: str, node: Located) -> tuple[float, ...]:
    if isinstance(node.value, (list, dict)):
        node.refuse(f"must be a single number; an axis belongs under `sweep`: sweep.{name}")
        return ()
    value = node.read(finite)
    return () if value is None else (value,)


def _valid(
    given: _Given, values_of: Callable[[str, Located], tuple[float, ...]]
) -> Iterator[tuple[str, tuple[float, ...]]]:
    """The parameters whose values are all valid, with these."""
    for name, node in given:
        if values := valid_values(name, node, values_of(name, node)):
            yield name, values


def valid_values(name: str, node: Located, values: tuple[float, ...]) -> tuple[float, ...]:
    """The values if all lie in the parameter's range; each that was written out is judged."""
    judge = PARAMETERS[name].complaint
    complaints = {i: c for i, value in enumerate(values) if (c := judge(value))}
    if isinstance(node.value, list):
        for i, complaint in complaints.items():
            node.refuse(complaint, i)
    elif complaints:
        more = f" (and {len(complaints) - 1} more of its values)" if len(complaints) > 1 else ""
        node.refuse(next(iter(complaints.values())) + more)
    return () if complaints else values


def _judge_neighbours(node: Located, values: tuple[float, ...]) -> None:
    pairs = list(pairwise(sorted(values)))
    repeated = dict.fromkeys(a for a, b in pairs if a == b)
    near = [(a, b) for a, b in pairs if b - a <= _NEAR_DUPLICATE * max(abs(a), abs(b))]
    if repeated:
        listed = ", ".join(map(repr, list(repeated)[:5])) + (", …" if len(repeated) > 5 else "")
        node.refuse(f"has values that occur more than once: {listed}")
    elif near:
        message = "has neighbours that differ by less than 1e-9 of their value: {!r} and {!r}"
        node.warn(message.format(*near[0]))


def _sizes_fit(root: Located, axes: dict[str, Axis | None], linked: dict[str, Axis | None]) -> bool:
    """Whether the grid may be laid out; judged before any axis is."""
    lengths = {name: axis.size for name, axis in linked.items() if axis}
    if unequal := unequal_lengths("linked", lengths):
        root.refuse(unequal, "cases")
    sizes = [axis.size for axis in axes.values() if axis]
    points = math.prod(sizes) * max(lengths.values(), default=1)
    if points > MAX_POINTS:
        message = f"{points} points are more than {MAX_POINTS}; take fewer values or axes"
        root.refuse(message, "sweep" if axes else "cases")
    return points <= MAX_POINTS


def unequal_lengths(kind: str, lengths: dict[str, int]) -> str:
    """What is wrong with parameters that change together; empty where nothing is."""
    if len(set(lengths.values())) < 2:
        return ""
    listed = ", ".join(f"{name} {size}" for name, size in lengths.items())
    return f"{kind} parameters need equally many values, but have: {listed}"


def _refuse_repeated_cases(root: Located, space: ParameterSpace) -> None:
    first: dict[tuple[float, ...], int] = {}
    for index, values in enumerate(zip(*space.cases.values(), strict=False)):
        other = first.setdefault(values, index)
        if other != index:
            root.refuse(f"case {index} repeats case {other} (counted from 0)", "cases")
            return


def _warn_of_exchange(root: Located, space: ParameterSpace) -> None:
    k, K = space.values("viscosity_coefficient"), space.values("spring_stiffness")
    if max(k) <= _K_BORDER <= min(K) and min(k) < _K_BORDER < max(K):
        node = _where_given(root, "spring_stiffness") or root
        node.warn(
            f"K = {K[0]:g} N/m with k = {k[0]:g} Pa s: both are far from their usual magnitude "
            "(K about 3000, k about 5e4), as if k and K were exchanged"
        )


def _warn_of_magnitudes(root: Located, space: ParameterSpace) -> None:
    """Warn of values that look like those of another unit: finite, valid, and meant otherwise."""
    for name in sorted(space.names):
        variable, node = PARAMETERS[name], _where_given(root, name)
        far = [value for value in space.values(name) if _is_far(value, variable)]
        if name in _OF_ANY_SIZE or not far or node is None:
            continue
        if variable.units == "K":
            told = f"{far[0]:g} K is {far[0] - 273.15:.0f} degrees Celsius"
        else:
            usual = "in the paper" if variable.in_paper else "by default"
            told = f"{far[0]:g} {variable.units}, against {variable.default:g} {usual}"
        node.warn(f"{variable.symbol} = {told}: is it in another unit? all values are in SI units")


def _is_far(value: float, variable: ParameterVariable) -> bool:
    """Whether a value looks like that of another unit; 0 does not."""
    if value == 0.0 or variable.default == 0.0:
        return False
    if variable.units == "K":
        return value < _COLD
    return not 1.0 / _FAR <= abs(value / variable.default) <= _FAR


def _is_refused(root: Located, space: ParameterSpace, name: str) -> bool:
    """Whether the values of a parameter are unknown, because it or a whole section is refused."""
    sections = [
        root.value[section].value for section in PARAMETER_SECTIONS if section in root.value
    ]
    readable = all(value is None or isinstance(value, dict) for value in sections)
    return name not in space.names and not (readable and _where_given(root, name) is None)


def _one_case(space: ParameterSpace, case: Located | None) -> ParameterSpace:
    """The space with the linked parameters fixed at the values of one case."""
    index = case.read(whole) if case else None
    if case is None or index is None:
        return space
    count = min(map(len, space.cases.values()), default=0)
    if not 0 <= index < count:
        case.refuse(f"must be 0 ... {count - 1}" if count else "there are no `cases` to pick from")
        return space
    picked = {name: values[index] for name, values in space.cases.items()}
    return replace(space, model={**space.model, **picked}, cases={})


def _where_given(root: Located, name: str) -> Located | None:
    for section in PARAMETER_SECTIONS:
        if key := key_of(root, section, name):
            node: Located = root.value[section].value[key]
            return node
    return None


def key_of(root: Located, section: str, name: str) -> str | None:
    """The key by which a section gives a parameter: its full name or its symbol."""
    keys = root.value[section].children() if section in root.value else ()
    return next((key for key in keys if canonical_name(key) == name), None)
