"""Free parameters, the scales on which they vary, and their bounds."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from stickslip.distributions import Distribution, distribution_of
from stickslip.parameters import Parameters
from stickslip.variables import BY_SYMBOL, PARAMETERS, ParameterVariable, canonical_name
from sweeps.config.numbers import number
from sweeps.exits import ExpectedError
from sweeps.human import did_you_mean
from sweeps.measurements import Floats

Range: TypeAlias = tuple[float, float] | None
Free: TypeAlias = str | Iterable[str] | Mapping[str, Range]

LOGARITHMIC, PLAIN = "logarithmic", "plain"

# Largest distances from the start for the first trials and for all trials, as logarithms of
# factors. Temperatures do not span decades.
_NEAR, _FAR = math.log(30.0), math.log(300.0)
_NEAR_K, _FAR_K = math.log(1.5), math.log(5.0)
# The same for parameters that may be 0 or negative, in their natural unit.
_NEAR_PLAIN, _FAR_PLAIN = 1.0, 2.0
# Distance of trials from a bound that is not a valid value, in the natural unit.
_MARGIN = 0.01


class FreeError(ExpectedError, ValueError):
    """A parameter that cannot be free, or a wrong range or prior; the message says why."""


@dataclass(frozen=True)
class FreeParameter:
    """A free parameter on a scale u, which is its logarithm or its value in its natural unit.

    All trials lie between `lower` and `upper`, and the first ones in the `box`. These and the
    `start` are values of u. `sign` is the sign of the parameter, `unit` its natural unit in SI.
    """

    name: str
    form: str
    sign: float
    unit: float
    start: float
    lower: float
    upper: float
    box: tuple[float, float]

    def value(self, u: Floats | float) -> Floats:
        """Return values of the parameter, in SI units."""
        if self.form == LOGARITHMIC:
            return np.asarray(self.sign * np.exp(u))
        return np.asarray(self.unit * np.asarray(u))

    def slope(self, u: float) -> float:
        """Return |d value/du|, in SI units."""
        return abs(float(self.value(u))) if self.form == LOGARITHMIC else self.unit

    def is_valid(self, u: float) -> bool:
        """Return whether the value at u is valid in the model."""
        return PARAMETERS[self.name].complaint(float(self.value(u))) is None


def free_parameters(free: Free, fixed: Parameters, columns: Iterable[str]) -> list[FreeParameter]:
    """Return the parameters to fit, which start from the values in `fixed`.

    `free` has names or symbols, and possibly the range (lowest, highest) of trials, in SI units.
    `columns` are the parameters in the data.

    Raises FreeError for a parameter that is unknown, a column of the data, or without a valid
    range.
    """
    ranges = [name.strip() for name in free.split(",")] if isinstance(free, str) else free
    if not isinstance(ranges, Mapping):
        ranges = dict.fromkeys(ranges)
    found: dict[str, FreeParameter] = {}
    for given, limits in ranges.items():
        name = canonical_name(given)
        if name is None:
            hint = did_you_mean(given, [*PARAMETERS, *BY_SYMBOL])
            hint = hint or "; `stickslip schema` lists the names"
            raise FreeError(f"there is no parameter {given!r}{hint}")
        if name in columns:
            raise FreeError(f"{name} is free and also a column of the data; leave one out")
        if name in found:
            raise FreeError(f"{name} is listed twice, by name and by symbol; leave one out")
        found[name] = _free(PARAMETERS[name], fixed, limits)
    if not found:
        raise FreeError("no parameter is free: name some, such as k,gamma")
    return list(found.values())


def _free(variable: ParameterVariable, fixed: Parameters, limits: Range) -> FreeParameter:
    start = getattr(fixed, variable.name)
    if limits is not None:
        limits = _range(variable, limits)
        start = start if limits[0] <= start <= limits[1] else None
    if variable.measured_in is None:
        return _logarithmic(variable, start, limits)
    unit = abs(math.prod(getattr(fixed, other) for other in variable.measured_in))
    if not unit:
        others = " and ".join(variable.measured_in)
        raise FreeError(f"{variable.name} varies in units of {others}, which must not be 0")
    if limits is not None:
        low, high = box = (limits[0] / unit, limits[1] / unit)
        middle = (low + high) / 2.0 if start is None else start / unit
        return FreeParameter(variable.name, PLAIN, 1.0, unit, middle, low, high, box)
    lower, upper, middle = variable.lower / unit, variable.upper / unit, start / unit
    margin = _MARGIN if variable.lower_open else 0.0
    low = max(lower + margin, middle - _FAR_PLAIN)
    high = min(upper, middle + _FAR_PLAIN)
    box = (max(low, middle - _NEAR_PLAIN), min(middle + _NEAR_PLAIN, high))
    middle = min(max(middle, low), high)
    return FreeParameter(variable.name, PLAIN, 1.0, unit, middle, low, high, box)


def _logarithmic(variable: ParameterVariable, start: float | None, limits: Range) -> FreeParameter:
    name = variable.name
    if limits is not None:
        sign = math.copysign(1.0, limits[1])
        low, high = sorted(math.log(abs(limit)) for limit in limits)
        middle = (low + high) / 2.0 if start is None else math.log(abs(start))
        return FreeParameter(name, LOGARITHMIC, sign, 1.0, middle, low, high, (low, high))
    if not start:
        raise FreeError(f"{name} starts at 0: give it a nonzero start, or a range, {name}=LOW:HIGH")
    middle, sign = math.log(abs(start)), math.copysign(1.0, start)
    near, far = (_NEAR_K, _FAR_K) if variable.units == "K" else (_NEAR, _FAR)
    box = (middle - near, middle + near)
    return FreeParameter(name, LOGARITHMIC, sign, 1.0, middle, middle - far, middle + far, box)


def _range(variable: ParameterVariable, limits: Any) -> tuple[float, float]:
    try:
        low, high = map(float, limits)
    except (TypeError, ValueError):
        raise FreeError(
            f"the range of {variable.name} must be (lowest, highest), not {limits!r}"
        ) from None
    for limit in (low, high):
        if complaint := variable.complaint(limit):
            raise FreeError(f"the range of {variable.name}: {complaint}")
    if not low < high:
        raise FreeError(f"the range of {variable.name} must rise, not go from {low!r} to {high!r}")
    if variable.measured_in is None and low * high <= 0:
        raise FreeError(
            f"the range of {variable.name} must not contain 0, since its logarithm is fitted"
        )
    return low, high


def _computed(written: Any) -> Any:
    """Return a prior with fractions such as the text `-2/3`, which configs allow, as numbers."""
    if isinstance(written, Mapping):
        return {kind: _computed(numbers) for kind, numbers in written.items()}
    if isinstance(written, (list, tuple)):
        return [number(each) if isinstance(each, str) else each for each in written]
    return written


def priors_of(priors: Mapping[str, Any], free: Iterable[FreeParameter]) -> dict[str, Distribution]:
    """Return the prior distributions by full name of free parameters; raises FreeError."""
    names = [each.name for each in free]
    found: dict[str, Distribution] = {}
    for given, written in priors.items():
        name = canonical_name(given)
        if name not in names:
            raise FreeError(
                f"a prior for {given}, which is not free; free parameters: {', '.join(names)}"
            )
        if name in found:
            raise FreeError(f"two priors for {name}, by name and by symbol; leave one out")
        try:
            found[name] = distribution_of(name, _computed(written))
        except ValueError as error:
            raise FreeError(f"the prior of {name}: {error}") from None
    return found
