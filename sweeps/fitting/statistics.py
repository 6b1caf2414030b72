"""What a minimum says about its parameters: standard errors, correlations, what is not known."""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2, f, t

from sweeps.exits import ExpectedError
from sweeps.fitting.data import Floats
from sweeps.fitting.refinement import Fit, Minimizer, Search
from sweeps.fitting.trials import STEP

LEVEL = 0.95
"""Probability of an interval."""

# Relative to the amplitudes; below, a change is roughness and no derivative.
_ROUGHNESS = 1e-8
# Of a parameter's natural unit, or of its logarithm: one with a larger standard error is not known.
_LARGE = 1.0
_PART = 0.1  # of a direction that changes nothing: what a parameter must have to be in it
_AT_BOUND = 1e-3  # of the distance of the bounds


class Determination(IntEnum):
    """What the data say of a parameter; the values are those of `parameter_determination`."""

    DETERMINED = 0
    UNDETERMINED = 1
    AT_BOUND = 2


@dataclass(frozen=True)
class Statistics:
    """Standard errors (p,) and correlations (p, p) on the scales of the parameters.

    NaN where `determination` (p,) says that there are none; `intervals` (p, 2) hold the true value
    with the probability `LEVEL`.
    """

    errors: Floats
    correlations: Floats
    determination: NDArray[np.int8]
    intervals: Floats


def statistics_of(fit: Fit) -> Statistics:
    """Return the statistics of a minimum, by the derivatives there.

    A parameter at a bound counts as fixed there. Directions in which the data change by no more
    than the roughness of the amplitudes leave out all parameters that have a part in them.
    """
    count = len(fit.trial.u)
    codes = np.full(count, Determination.DETERMINED, dtype=np.int8)
    codes[_at_bound(fit)] = Determination.AT_BOUND
    inner = np.flatnonzero(codes == Determination.DETERMINED)
    covariance = np.full((count, count), np.nan)
    if len(inner):
        _, sizes, axes = np.linalg.svd(fit.slopes[:, inner])
        sizes = np.pad(sizes, (0, len(inner) - len(sizes)))
        empty = sizes <= _least_slope(fit)
        lost = (np.abs(axes[empty]) > _PART).any(axis=0)
        codes[inner[lost]] = Determination.UNDETERMINED
        weights = np.where(empty, 0.0, 1.0 / np.where(empty, 1.0, sizes)) * math.sqrt(fit.scale)
        known = inner[~lost]
        parts = (axes.T * weights)[~lost]
        covariance[np.ix_(known, known)] = parts @ parts.T
    errors = np.sqrt(np.diag(covariance))
    codes[errors > _LARGE] = Determination.UNDETERMINED
    with np.errstate(invalid="ignore", divide="ignore"):  # without noise all are 0
        correlations = covariance / np.outer(errors, errors)
    reach = errors * (t.ppf(0.5 + LEVEL / 2.0, fit.dof) if fit.dof > 0 else math.nan)
    intervals = fit.trial.u[:, None] + np.array([-1.0, 1.0]) * reach[:, None]
    return Statistics(errors, correlations, codes, intervals)


def _at_bound(fit: Fit) -> NDArray[np.bool_]:
    low, high = np.array([(each.lower, each.upper) for each in fit.model.free]).T
    near = _AT_BOUND * (high - low)
    at_bound: NDArray[np.bool_] = (fit.trial.u < low + near) | (fit.trial.u > high - near)
    return at_bound


def _least_slope(fit: Fit) -> float:
    """Return the derivative of all data together that roughness alone could give."""
    sizes = np.nan_to_num(fit.trial.fitted) / fit.model.data.error
    roughness = _ROUGHNESS * max(1.0, fit.model.options.rtol / 1e-6)
    return float(roughness / STEP * np.linalg.norm(sizes))


class ProfileError(ExpectedError, ValueError):
    """No profile can be computed; the message says why."""


def profile_intervals(search: Search, fit: Fit, known: Statistics) -> Floats:
    """Return intervals (p, 2) of the profile likelihood, on the scales of the parameters.

    For each parameter all others are fitted anew; the data are less probable, at the level `LEVEL`,
    beyond its interval. By lmfit's `conf_interval`. An end is NaN where it is out of bounds, both
    are for parameters without a standard error.
    """
    found = np.full((len(fit.trial.u), 2), np.nan)
    free = fit.model.free
    if len(free) < 2:
        raise ProfileError("a profile needs two free parameters or more: others are fitted anew")
    if fit.dof < 1:
        raise ProfileError("a profile needs more data than free parameters")
    if fit.scale == 0.0:
        raise ProfileError("data without any scatter have no profile")
    names = [each.name for each, error in zip(free, known.errors, strict=True) if error > 0.0]
    if not names:
        return found
    import lmfit

    minimizer = Minimizer(fit.model, lambda question: search.answers([question])[0])
    around, result = minimizer.at(fit.trial.u, known.errors)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # of bounds: an end is NaN then
        ends = lmfit.conf_interval(around, result, names, [LEVEL], prob_func=_probability_of(fit))
    for number, each in enumerate(free):
        if each.name in ends:
            values = [value for _, value in ends[each.name]]
            found[number] = [values[0], values[-1]]
    found[~np.isfinite(found)] = np.nan
    return found


def _probability_of(fit: Fit) -> Any:
    """Return the probability that a chi2 with a parameter fixed excludes its value.

    By Student's t, squared, where errors are only known from the residuals.
    """

    def probability(_: Any, other: Any) -> float:
        rise = max(0.0, other.chisqr - fit.trial.chi2) / fit.scale
        own = fit.model.data.relative or fit.scale > 1.0
        return float(f.cdf(rise, 1, fit.dof) if own else chi2.cdf(rise, 1))

    return probability
