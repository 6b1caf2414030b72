"""Distributions of parameters, for the samples of a box and the priors of a fit."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from stickslip.parameters import ParameterError
from stickslip.variables import PARAMETERS

Floats: TypeAlias = NDArray[np.float64]

LARGEST_OUTSIDE = 1e-3
"""The largest probability that a distribution may give to values outside a parameter's range."""

_ROUNDING = 1e-6  # rounding may move a variance of 0 this far below 0


class DistributionError(ValueError):
    """An invalid distribution; the message is the end of a sentence."""


class Range(NamedTuple):
    """A uniform distribution of a parameter, or of its logarithm, between two values."""

    low: float
    high: float
    logarithmic: bool = False

    def __str__(self) -> str:
        return f"{'log ' if self.logarithmic else ''}[{self.low:.17g}, {self.high:.17g}]"

    def values(self, unit: Floats) -> Floats:
        """Return quantiles at points in [0, 1)."""
        if self.logarithmic:
            return self.low * (self.high / self.low) ** unit
        return self.low + (self.high - self.low) * unit

    def log_density(self, values: Floats) -> Floats:
        """Return the logarithm of the density at values."""
        inside = (self.low <= values) & (values <= self.high)
        with np.errstate(divide="ignore", invalid="ignore"):
            if self.logarithmic:
                density = -np.log(values * math.log(self.high / self.low))
            else:
                density = np.full_like(values, -math.log(self.high - self.low))
        return np.where(inside, density, -math.inf)


class Normal(NamedTuple):
    """A normal distribution, truncated to the range from `low` to `high` of the parameter.

    A lognormal one is the normal distribution of the logarithm; `middle` is then the median.
    """

    middle: float
    deviation: float
    logarithmic: bool = False
    low: float = -math.inf
    high: float = math.inf

    def __str__(self) -> str:
        name = "lognormal" if self.logarithmic else "normal"
        return f"{name} [{self.middle:.17g}, {self.deviation:.17g}]"

    @property
    def outside(self) -> float:
        """The probability of values below `low` or above `high`, which are cut off."""
        below, above = self._ends()
        return below + (1.0 - above)

    def values(self, unit: Floats) -> Floats:
        """Return quantiles at points in [0, 1)."""
        from scipy.special import ndtri

        below, above = self._ends()
        # Never 0 or 1, whose quantiles are infinite: a Sobol sequence begins at 0.
        within = np.clip(below + (above - below) * unit, 1e-16, 1.0 - 1e-16)
        steps = self.deviation * ndtri(within)
        return self.middle * np.exp(steps) if self.logarithmic else self.middle + steps

    def log_density(self, values: Floats) -> Floats:
        """Return the logarithm of the density at values, up to a constant."""
        inside = (self.low <= values) & (values <= self.high)
        with np.errstate(divide="ignore", invalid="ignore"):
            off = np.log(values / self.middle) if self.logarithmic else values - self.middle
            density = -0.5 * (off / self.deviation) ** 2
            density -= np.log(np.abs(values)) if self.logarithmic else 0.0
        return np.where(inside, density, -math.inf)

    def _ends(self) -> tuple[float, float]:
        """Return the probabilities below `low` and below `high`."""
        from scipy.special import ndtr

        def below(end: float) -> float:
            if not self.logarithmic:
                return float(ndtr((end - self.middle) / self.deviation))
            ratio = end / self.middle
            return float(ndtr(math.log(ratio) / self.deviation)) if ratio > 0.0 else 0.0

        return below(self.low), below(self.high)


class Joint(NamedTuple):
    """The joint normal distribution of several parameters, as a fit finds it.

    `deviations` (p,) and `correlations` (p, p) belong to the values, or to their logarithms where
    `logarithmic`; `middle` is then a median.
    """

    names: tuple[str, ...]
    middle: Floats
    deviations: Floats
    correlations: Floats
    logarithmic: tuple[bool, ...]

    @property
    def outside(self) -> dict[str, float]:
        """The probability, for each parameter, of a value outside its range."""
        found = {}
        for i, name in enumerate(self.names):
            ends = np.array([PARAMETERS[name].lower, PARAMETERS[name].upper])
            middle = float(self.middle[i])
            if self.logarithmic[i] and middle < 0.0:  # the logarithm of -value
                middle, ends = -middle, -ends[::-1]
            own = Normal(middle, float(self.deviations[i]), self.logarithmic[i], *ends.tolist())
            found[name] = own.outside
        return found

    def values(self, unit: Floats) -> Floats:
        """Return the values (n, p) at points (n, p) in [0, 1); raises DistributionError."""
        from scipy.special import ndtri

        variances, directions = np.linalg.eigh(self.correlations)
        if not variances[0] > -_ROUNDING:
            raise DistributionError("has correlations that no distribution can have")
        root = directions * np.sqrt(np.clip(variances, 0.0, None))
        steps = (ndtri(np.clip(unit, 1e-16, 1.0 - 1e-16)) @ root.T) * self.deviations
        factors = np.exp(np.where(self.logarithmic, steps, 0.0))
        return np.where(self.logarithmic, self.middle * factors, self.middle + steps)

    def are_possible(self, values: Floats) -> NDArray[np.bool_]:
        """Return whether all parameters are within their ranges, for each set (n, p)."""
        ends = np.array([(PARAMETERS[name].lower, PARAMETERS[name].upper) for name in self.names])
        return np.all((ends[:, 0] <= values) & (values <= ends[:, 1]), axis=1)


Distribution: TypeAlias = Range | Normal

FORMS = "[low, high], {log: [low, high]}, {normal: [mean, deviation]}, or " + (
    "{lognormal: [median, deviation of the logarithm]}"
)
"""The notation of distributions."""


def distribution(kind: str, first: float, second: float) -> Distribution:
    """Return a distribution by its name, `uniform`, `log`, `normal` or `lognormal`.

    Raises DistributionError for any other name, and for invalid numbers.
    """
    logarithmic = kind in ("log", "lognormal")
    if kind in ("normal", "lognormal"):
        if not math.isfinite(first):
            middle = "median" if logarithmic else "mean"
            raise DistributionError(f"the {middle} must be a finite number, not {first:g}")
        if not 0.0 < second < math.inf:
            raise DistributionError(f"the deviation must be a number above 0, not {second:g}")
        if logarithmic and not first > 0.0:
            raise DistributionError(f"the median must be above 0, not {first:g}")
        return Normal(first, second, logarithmic)
    if kind not in ("uniform", "log"):
        raise DistributionError(f"must be {FORMS}")
    if not first < second:
        raise DistributionError(f"must rise from low to high, not from {first:g} to {second:g}")
    if logarithmic and not first > 0.0:
        raise DistributionError(
            f"needs two values above 0 for a logarithm, not {first:g} and {second:g}"
        )
    return Range(first, second, logarithmic)


def as_written(written: Any) -> tuple[str, Any]:
    """Split a distribution as a user wrote it into its name and its numbers."""
    if isinstance(written, Range):
        return ("log" if written.logarithmic else "uniform"), written[:2]
    if isinstance(written, Normal):
        return ("lognormal" if written.logarithmic else "normal"), written[:2]
    if isinstance(written, Mapping) and len(written) == 1:
        ((kind, numbers),) = written.items()
        return str(kind), numbers
    return "uniform", written


def distribution_of(name: str, written: Any) -> Distribution:
    """Return the distribution that a user wrote for a parameter; raises DistributionError."""
    kind, numbers = as_written(written)
    try:
        first, second = map(float, numbers)
    except (TypeError, ValueError):
        raise DistributionError(f"must be {FORMS}, not {written!r}") from None
    return of_parameter(distribution(kind, first, second), name)


def of_parameter(drawn: Distribution, name: str) -> Distribution:
    """Return a distribution truncated to the range of a parameter.

    Raises ParameterError if an end of a `Range` is outside, and DistributionError if too much of a
    `Normal` is.
    """
    variable = PARAMETERS[name]
    if isinstance(drawn, Range):
        for end in drawn[:2]:
            if complaint := variable.complaint(end):
                raise ParameterError(f"{name} {complaint}")
        return drawn
    drawn = drawn._replace(low=variable.lower, high=variable.upper)
    refuse_outside(name, drawn.outside)
    return drawn


def refuse_outside(name: str, probability: float) -> None:
    """Raise DistributionError if values outside the range of a parameter are too probable."""
    if probability > LARGEST_OUTSIDE:
        raise DistributionError(
            f"has values that {name} cannot have, with a probability of {probability:.2g} "
            f"(allowed: {LARGEST_OUTSIDE:g}); take a smaller deviation, a lognormal distribution, "
            "or a range"
        )
