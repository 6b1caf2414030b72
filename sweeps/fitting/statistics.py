"""What a minimum says about its parameters: standard errors, correlations, what is not known.

Next to a jump an amplitude may change with the logarithm of the distance, so that its datum is met
anywhere along the jump, in a well of 1e-5 of a parameter. Such a datum chooses the place of the
minimum and says nothing else: intervals are those of all others, above the chi2 of all.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable, Sequence
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2, f, t

from sweeps.fitting.refinement import Fit, Minimizer, Search
from sweeps.fitting.together import Together
from sweeps.fitting.trials import STEP, Trial
from sweeps.measurements import Floats

LEVEL = 0.95
"""Probability of an interval."""

# Relative to the amplitudes: ten times what they are rough by. A derivative that could be made of
# less is not known to a tenth.
_ROUGHNESS = 1e-7
# Of a parameter's natural unit, or of its logarithm: one with a larger standard error is not known.
_LARGE = 1.0
# Where all standard errors are smaller, valleys are straight.
_SMALL = 0.05
_NEARLY, _MOVES = 0.8, 6  # part of a rise that is enough; how often an end is moved
_JUST_BEYOND = 1.05  # of an interval: trials at its ends lie within
_PART = 0.1  # of a direction that changes nothing: what a parameter must have to be in it
_AT_BOUND = 1e-3  # of the distance of the bounds


class Determination(IntEnum):
    """What the data say of a parameter; the values are those of `parameter_determination`."""

    DETERMINED = 0
    UNDETERMINED = 1
    AT_BOUND = 2


class Statistics(NamedTuple):
    """Standard errors (p,) and correlations (p, p) on the scales of the parameters.

    NaN where `determination` (p,) says that there are none; `intervals` (p, 2) hold the true value
    with the probability `LEVEL`. `jumps` (n,) are data that change their kind of motion within
    them: they bound the basin of the minimum.
    """

    errors: Floats
    correlations: Floats
    determination: NDArray[np.int8]
    intervals: Floats
    jumps: NDArray[np.bool_]


def statistics_of(fit: Fit) -> Statistics:
    """Return the statistics of a minimum, by the derivatives there.

    A parameter at a bound counts as fixed there. Data at a jump are left out. Directions in which
    the data change by no more than the roughness of the amplitudes leave out all parameters that
    have a part in them.
    """
    count = len(fit.trial.u)
    codes = np.full(count, Determination.DETERMINED, dtype=np.int8)
    codes[_at_bound(fit)] = Determination.AT_BOUND
    inner = np.flatnonzero(codes == Determination.DETERMINED)
    covariance = np.full((count, count), np.nan)
    if len(inner):
        _, sizes, axes = np.linalg.svd(np.where(fit.left_out[:, None], 0.0, fit.slopes)[:, inner])
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
    reach = errors * _goal(fit)
    intervals = fit.trial.u[:, None] + np.array([-1.0, 1.0]) * reach[:, None]
    return Statistics(errors, correlations, codes, intervals, fit.left_out)


def widened(search: Search, fit: Fit, known: Statistics) -> tuple[Statistics, Trial]:
    """Return the statistics with intervals as long as the data let them be, and the best trial.

    Standard errors hold only if chi2 is a parabola. For each parameter the others are fitted anew
    at the ends of its interval, and it is moved on where chi2 has not risen as it should. Intervals
    reach over all other trials that fit about as well, or that are so many that the truth may lie
    among them. The standard error becomes that of the longer side. A trial that is better than the
    minimum is another minimum.
    """
    goal = _goal(fit)
    loose = [
        number
        for number, error in enumerate(known.errors)
        if 0.0 < error <= _LARGE and math.isfinite(goal)
    ]
    sides = [(number, sign) for number in loose for sign in (-1.0, 1.0)]
    together = Together(search.answers)
    ends = together.run(lambda side: _end(fit, known, side, goal, together.ask), sides)
    intervals = known.intervals.copy()
    for (number, sign), (distance, _) in zip(sides, ends, strict=True):
        intervals[number, int(sign > 0)] = fit.trial.u[number] + sign * distance
    worse = [seen for seen in search.sweep if _rise(fit, seen) >= goal]
    probable = [trial.u for trial in as_probable(fit, known, worse, len(search.sweep))]
    found = _reaching(search, fit, known._replace(intervals=intervals), probable)
    best = min([fit.trial, *(trial for _, trial in ends)], key=lambda trial: trial.cost)
    return found._replace(jumps=jumps_within(search, fit, found)), best


def covering(search: Search, fit: Fit, known: Statistics, draws: Sequence[Trial]) -> Statistics:
    """Return the statistics with intervals that hold `LEVEL` of trials drawn by likelihood."""
    tails = [0.5 - LEVEL / 2.0, 0.5 + LEVEL / 2.0]
    found = _reaching(search, fit, known, np.quantile([draw.u for draw in draws], tails, axis=0))
    others = np.mean([~fit.trial.is_like(draw)[fit.model.data.row] for draw in draws], axis=0)
    return found._replace(jumps=known.jumps | fit.left_out | (others > tails[0]))


def _reaching(search: Search, fit: Fit, known: Statistics, places: Iterable[Floats]) -> Statistics:
    """Return the statistics with intervals that reach to places, and to all that fits as well."""
    goal, intervals = _goal(fit), known.intervals.copy()
    as_good = (seen.u for seen in search.seen if _rise(fit, seen) < goal)
    for place in (*as_good, *places):
        intervals[:, 0] = np.minimum(intervals[:, 0], place)
        intervals[:, 1] = np.maximum(intervals[:, 1], place)
    longest = np.abs(intervals - fit.trial.u[:, None]).max(axis=1)
    errors = np.where(known.errors > 0.0, np.fmax(known.errors, longest / goal), known.errors)
    codes = np.where(errors > _LARGE, Determination.UNDETERMINED, known.determination)
    return known._replace(errors=errors, intervals=intervals, determination=codes.astype(np.int8))


def jumps_within(search: Search, fit: Fit, known: Statistics) -> NDArray[np.bool_]:
    """Tell which data (n,) change their kind of motion in trials within the ellipsoid of errors."""
    inner = (known.errors > 0.0) & np.isfinite(known.errors)
    errors, jumps = known.errors[inner], fit.left_out
    inverse = np.linalg.pinv(known.correlations[np.ix_(inner, inner)])
    for seen in search.seen if inner.any() else ():
        off = (seen.u - fit.trial.u)[inner] / errors
        if off @ inverse @ off <= (_JUST_BEYOND * _goal(fit)) ** 2:
            jumps = jumps | ~fit.trial.is_like(seen)[fit.model.data.row] & seen.known
    return jumps


def _goal(fit: Fit) -> float:
    """Return the root of the rise of chi2 that ends an interval, in units of its scale."""
    return float(t.ppf(0.5 + LEVEL / 2.0, fit.dof)) if fit.dof > 0 else math.nan


def _end(
    fit: Fit, known: Statistics, side: tuple[int, float], goal: float, ask: Any
) -> tuple[float, Trial]:
    """Return how far an interval reaches to a side, and the best trial on the way.

    `goal` is the root of the rise of chi2 that ends it, in units of its scale.
    """
    (number, sign), free = side, fit.model.free[side[0]]
    minimizer = Minimizer(fit.model, ask, left_out=fit.left_out)
    curved = bool(np.any(known.errors > _SMALL))
    ahead = sign * known.correlations[:, number] * known.errors / known.errors[number]
    ahead = np.nan_to_num(ahead)
    ahead[number] = sign
    room = free.upper - fit.trial.u[number] if sign > 0 else fit.trial.u[number] - free.lower
    distance, best, place, before = goal * known.errors[number], fit.trial, fit.trial.u, 0.0
    for _ in range(_MOVES):
        if distance >= room:
            return math.inf, best
        place = fit.model.inside(place + (distance - before) * ahead)
        place[number] = fit.trial.u[number] + sign * distance
        trial = minimizer.trial(place)
        if curved or _rise(fit, trial) < _NEARLY * goal:
            trial = minimizer.fit(place, number)
        best = min(best, trial, key=lambda each: each.cost)
        rise = _rise(fit, trial)
        if rise >= _NEARLY * goal:
            return distance * max(1.0, goal / rise), best
        place, before = trial.u.copy(), distance
        distance *= min(2.0, goal / max(rise, 1e-3))
    return math.inf, best


def as_probable(fit: Fit, known: Statistics, worse: Sequence[Trial], count: int) -> list[Trial]:
    """Return trials of an even sweep of `count` among which the truth may lie: none, or most.

    A narrow minimum may fit the noise better than a wide plateau with the truth in it. Each trial
    stands for its share of the box, and a minimum for its ellipsoid, both weighted by likelihood;
    what is left out has together a probability of no more than 1 - `LEVEL`.
    """
    if not worse or not 0.0 < fit.scale < math.inf:
        return []
    inner = known.errors > 0.0
    shape = known.correlations[np.ix_(inner, inner)]
    ellipsoid = math.sqrt(max(0.0, float(np.linalg.det(2.0 * math.pi * shape))))
    ellipsoid *= float(np.prod(known.errors[inner] / fit.model.wide[inner]))
    likelihood = np.exp([log_likelihood(fit, trial) for trial in worse]) / count
    order = np.argsort(likelihood)
    whole = min(1.0, ellipsoid) + likelihood.sum()
    left = np.cumsum(likelihood[order]) <= (1.0 - LEVEL) * whole
    return [worse[number] for number in order[~left]]


def log_likelihood(fit: Fit, trial: Trial) -> float:
    """Return the logarithm of the likelihood of a trial, relative to that of the minimum.

    Where errors are only known from the residuals, for any common factor of theirs.
    """
    above = trial.cost - fit.trial.cost
    if fit.model.data.relative:
        return -float(fit.trial.known.sum()) / 2.0 * math.log1p(above / fit.trial.chi2)
    return -above / (2.0 * fit.scale)


def _rise(fit: Fit, trial: Trial) -> float:
    """Return how far a trial is above the minimum, in standard errors, by data not at a jump."""
    above = max(0.0, float(np.sum(trial.residuals[~fit.left_out] ** 2)) - fit.trial.cost)
    return math.sqrt(above / fit.scale) if fit.scale != 0.0 else math.inf


def _at_bound(fit: Fit) -> NDArray[np.bool_]:
    low, high = fit.model.bounds
    near = _AT_BOUND * (high - low)
    at_bound: NDArray[np.bool_] = (fit.trial.u < low + near) | (fit.trial.u > high - near)
    return at_bound


def _least_slope(fit: Fit) -> float:
    """Return the derivative of all data together that roughness alone could give."""
    sizes = np.nan_to_num(fit.trial.fitted) / fit.model.data.error
    roughness = _ROUGHNESS * max(1.0, fit.model.options.rtol / 1e-6)
    return float(roughness / STEP * np.linalg.norm(sizes))


def profile_intervals(search: Search, fit: Fit, known: Statistics) -> Floats:
    """Return intervals (p, 2) of the profile likelihood, on the scales of the parameters.

    For each parameter all others are fitted anew; the data are less probable, at the level `LEVEL`,
    beyond its interval. By lmfit's `conf_interval`. An end is NaN where it is out of bounds, both
    are for parameters without a standard error.
    """
    found = np.full((len(fit.trial.u), 2), np.nan)
    free = fit.model.free
    names = [each.name for each, error in zip(free, known.errors, strict=True) if error > 0.0]
    if not names:  # or all are exact
        return found
    import lmfit

    together = Together(search.answers)

    def ends(name: str) -> list[float]:
        around, result = Minimizer(fit.model, together.ask).at(fit.trial.u, known.errors)
        found = lmfit.conf_interval(around, result, [name], [LEVEL], prob_func=_probability_of(fit))
        return [value for _, value in found[name]]

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # of bounds: an end is NaN then
        for name, values in zip(names, together.run(ends, names), strict=True):
            found[[each.name for each in free].index(name)] = [values[0], values[-1]]
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
