"""Statistics of a minimum: standard errors, correlations, intervals, undetermined parameters.

Next to a jump an amplitude may change with the logarithm of the distance. Its datum can then be
fitted anywhere along the jump, in a well as narrow as 1e-5 of a parameter. Such a datum fixes the
place of the minimum and gives no other information. Intervals therefore come from all other data,
and are measured from the chi2 of all data.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm, t

from sweeps.fitting.least_squares import Fit, Steps, fit_at, minimum, trial_at
from sweeps.fitting.minima import Search
from sweeps.fitting.trials import STEP, Trial
from sweeps.measurements import Floats

LEVEL = 0.95
"""The probability of an interval."""

# Relative to the amplitudes; ten times their roughness. A smaller change does not determine a
# derivative to within a tenth.
_ROUGHNESS = 1e-7
# A larger standard error, in the natural unit or the logarithm, leaves a parameter undetermined.
_LARGE = 1.0
# If all standard errors are smaller than this, valleys are straight.
_SMALL = 0.05
_NEARLY, _MOVES = 0.8, 6  # fraction of the rise that is enough; how often an end may move
_LEAST_RISE = 1e-3  # a smaller rise does not show the distance
_CLOSE, _TRIES = 0.01, 24  # relative error allowed in the rise at an end of the profile; attempts
_JUST_BEYOND = 1.05  # factor that keeps trials at the ends of an interval within it
_PART = 0.1  # a parameter takes part in a direction if its component is larger than this
_LEAST_FALL = 1e-12 - 1.0  # of chi2, as a fraction; it cannot fall below 0
_AT_BOUND = 1e-3  # fraction of the distance between the bounds


class Determination(IntEnum):
    """Whether the data determine a parameter: the values of `parameter_determination`."""

    DETERMINED = 0
    UNDETERMINED = 1
    AT_BOUND = 2


class Statistics(NamedTuple):
    """Standard errors (p,) and correlations (p, p) on the scales of the parameters.

    They are NaN for parameters without a standard error; see `determination` (p,). `intervals`
    (p, 2) hold the true value with the probability `LEVEL`. `jumps` (n,) marks data whose kind of
    motion changes within the intervals; their jumps bound the basin of the minimum.
    """

    errors: Floats
    correlations: Floats
    determination: NDArray[np.int8]
    intervals: Floats
    jumps: NDArray[np.bool_]


def statistics_of(fit: Fit) -> Statistics:
    """Return the statistics of a minimum, from the derivatives there.

    A parameter at a bound counts as fixed there. Data at a jump are left out. In a direction in
    which the data change by no more than the roughness of the amplitudes, all parameters with a
    component are undetermined.
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
    with np.errstate(invalid="ignore", divide="ignore"):  # without noise all errors are 0
        correlations = covariance / np.outer(errors, errors)
    reach = errors * _goal(fit)
    intervals = fit.trial.u[:, None] + np.array([-1.0, 1.0]) * reach[:, None]
    return Statistics(errors, correlations, codes, intervals, fit.left_out)


def widened(search: Search, fit: Fit, known: Statistics) -> tuple[Statistics, Trial]:
    """Return the statistics with intervals as wide as the data allow, and the best trial.

    Standard errors hold only if chi2 is a parabola. At the ends of the interval of each parameter
    the others are refitted, and the end moves outwards if chi2 has not risen enough. Intervals
    include all other trials that fit about as well, or that are so numerous that the truth may lie
    among them. The standard error follows from the longer side. A trial better than the minimum
    belongs to another minimum.
    """
    goal, intervals = _goal(fit), known.intervals.copy()
    sides = _sides(fit, known, fit.left_out) if math.isfinite(goal) else []
    sides = [side for side in sides if side.error <= _LARGE]
    curved = bool(np.any(known.errors > _SMALL))
    ends = search.side_by_side([_end(side, goal, curved) for side in sides])
    for side, (distance, _) in zip(sides, ends, strict=True):
        intervals[side.number, side.end] = side.at(distance)
    worse = [seen for seen in search.sweep if _rise(fit, seen, fit.left_out) >= goal]
    probable = [trial.u for trial in as_probable(fit, known, worse, len(search.sweep))]
    found = _reaching(search, fit, known._replace(intervals=intervals), probable)
    best = min([fit.trial, *(trial for _, trial in ends)], key=lambda trial: trial.cost)
    return found._replace(jumps=jumps_within(search, fit, found)), best


def covering(search: Search, fit: Fit, known: Statistics, draws: Sequence[Trial]) -> Statistics:
    """Return the statistics with intervals that hold `LEVEL` of the trials drawn by likelihood."""
    tails = [0.5 - LEVEL / 2.0, 0.5 + LEVEL / 2.0]
    found = _reaching(search, fit, known, np.quantile([draw.u for draw in draws], tails, axis=0))
    others = np.mean([~fit.trial.is_like(draw)[fit.model.data.row] for draw in draws], axis=0)
    return found._replace(jumps=known.jumps | fit.left_out | (others > tails[0]))


def _reaching(search: Search, fit: Fit, known: Statistics, places: Iterable[Floats]) -> Statistics:
    """Return the statistics with intervals that include places, and all trials that fit as well."""
    goal, intervals = _goal(fit), known.intervals.copy()
    as_good = (seen.u for seen in search.seen if _rise(fit, seen, fit.left_out) < goal)
    for place in (*as_good, *places):
        intervals[:, 0] = np.minimum(intervals[:, 0], place)
        intervals[:, 1] = np.maximum(intervals[:, 1], place)
    longest = np.abs(intervals - fit.trial.u[:, None]).max(axis=1)
    errors = np.where(known.errors > 0.0, np.fmax(known.errors, longest / goal), known.errors)
    codes = np.where(errors > _LARGE, Determination.UNDETERMINED, known.determination)
    return known._replace(errors=errors, intervals=intervals, determination=codes.astype(np.int8))


def jumps_within(search: Search, fit: Fit, known: Statistics) -> NDArray[np.bool_]:
    """Return which data (n,) change their kind of motion within the ellipsoid of errors."""
    inner = (known.errors > 0.0) & np.isfinite(known.errors)
    errors, jumps = known.errors[inner], fit.left_out
    inverse = np.linalg.pinv(known.correlations[np.ix_(inner, inner)])
    for seen in search.seen if inner.any() else ():
        off = (seen.u - fit.trial.u)[inner] / errors
        if off @ inverse @ off <= (_JUST_BEYOND * _goal(fit)) ** 2:
            jumps = jumps | ~fit.trial.is_like(seen)[fit.model.data.row] & seen.known
    return jumps


def _goal(fit: Fit) -> float:
    """Return the root of the rise of chi2 that ends an interval, in units of its scale.

    With as many parameters as data, only errors that were given show how large the scatter is.
    """
    if fit.dof > 0:
        return float(t.ppf(0.5 + LEVEL / 2.0, fit.dof))
    return math.nan if fit.model.data.relative else float(norm.ppf(0.5 + LEVEL / 2.0))


@dataclass(frozen=True)
class _Side:
    """A side of a minimum along one parameter, where all other parameters are refitted.

    `error` is the standard error of the parameter, `direction` (p,) the change of all parameters
    per unit of this one, by their correlations.
    """

    fit: Fit
    number: int
    sign: float
    error: float
    direction: Floats
    left_out: NDArray[np.bool_]

    @property
    def end(self) -> int:
        """The index of this side in an interval, and in the bounds."""
        return int(self.sign > 0)

    @property
    def room(self) -> float:
        """The distance to the bound."""
        return float(abs(self.fit.model.bounds[self.end][self.number] - self.at(0.0)))

    def at(self, distance: float) -> float:
        """Return the parameter at a distance from the minimum."""
        return float(self.fit.trial.u[self.number] + self.sign * distance)

    def rise(self, trial: Trial) -> float:
        """Return the rise of a trial above the minimum, in standard errors."""
        return _rise(self.fit, trial, self.left_out)

    def trial(self, distance: float, near: Trial, enough: float = math.inf) -> Steps[Trial]:
        """Return the best trial at a distance, or the first one if its rise is `enough`."""
        model = self.fit.model
        further = self.sign * (self.at(distance) - near.u[self.number])
        place = model.inside(near.u + further * self.direction)
        place[self.number] = self.at(distance)
        trial = yield from trial_at(place)
        if self.rise(trial) >= enough:
            return trial
        start = yield from fit_at(model, trial)
        return (yield from minimum(start, fixed=self.number, left_out=self.left_out)).trial


def _sides(fit: Fit, known: Statistics, left_out: NDArray[np.bool_]) -> list[_Side]:
    """Return both sides of each parameter that has a standard error."""
    sides = []
    for number in np.flatnonzero(known.errors > 0.0).tolist():
        error = float(known.errors[number])
        direction = np.nan_to_num(known.correlations[:, number] * known.errors / error)
        sides += [
            _Side(fit, number, sign, error, sign * direction, left_out) for sign in (-1.0, 1.0)
        ]
    return sides


def _end(side: _Side, goal: float, curved: bool) -> Steps[tuple[float, Trial]]:
    """Return the length of an interval on a side, and the best trial on the way.

    `goal` is the root of the rise of chi2 at its end, in units of its scale.
    """
    distance, best, trial = goal * side.error, side.fit.trial, side.fit.trial
    for _ in range(_MOVES):
        if distance >= side.room:
            break
        trial = yield from side.trial(distance, trial, math.inf if curved else _NEARLY * goal)
        best = min(best, trial, key=lambda each: each.cost)
        rise = side.rise(trial)
        if rise >= _NEARLY * goal:
            return distance * max(1.0, goal / rise), best
        distance *= min(2.0, goal / max(rise, _LEAST_RISE))
    return math.inf, best


def _profile_end(side: _Side, goal: float) -> Steps[float]:
    """Return the distance where the root of the rise of chi2 is `goal`; NaN if out of bounds."""
    distance, trial, inner, outer = goal * side.error, side.fit.trial, 0.0, side.room
    for _ in range(_TRIES):
        if not inner < distance < outer:
            distance = (inner + outer) / 2.0
        trial = yield from side.trial(distance, trial)
        factor = goal / max(side.rise(trial), _LEAST_RISE)
        if abs(factor - 1.0) < _CLOSE:
            return distance * factor
        inner, outer = (distance, outer) if factor > 1.0 else (inner, distance)
        distance *= min(2.0, factor)
    return distance if outer < side.room else math.nan


def as_probable(fit: Fit, known: Statistics, worse: Sequence[Trial], count: int) -> list[Trial]:
    """Return the trials of an even sweep of `count` among which the truth may lie: none, or most.

    A narrow minimum may fit the noise better than a wide plateau that contains the truth. Each
    trial represents its share of the box, and a minimum its ellipsoid, both weighted by likelihood.
    The trials left out together have a probability of no more than 1 - `LEVEL`.
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


def log_likelihood(fit: Fit, trial: Trial, cost: float | None = None) -> float:
    """Return the logarithm of the likelihood of a trial, relative to the minimum.

    If errors are known only from the residuals, it holds for any common factor of the errors.
    `cost` replaces the cost of the trial. If that cost leaves out data that the fit counts, it may
    be 0 or far below the fit's; the logarithm is then large, but finite.
    """
    above = (trial.cost if cost is None else cost) - fit.trial.cost
    if fit.model.data.relative:
        rise = max(above / fit.trial.chi2, _LEAST_FALL)
        return -float(fit.trial.known.sum()) / 2.0 * math.log1p(rise)
    return -above / (2.0 * fit.scale)


def _rise(fit: Fit, trial: Trial, left_out: NDArray[np.bool_]) -> float:
    """Return the rise of a trial above the minimum, in standard errors, without some data."""
    above = max(0.0, float(np.sum(trial.residuals[~left_out] ** 2)) - fit.trial.cost)
    return math.sqrt(above / fit.scale) if fit.scale != 0.0 else math.inf


def _at_bound(fit: Fit) -> NDArray[np.bool_]:
    low, high = fit.model.bounds
    near = _AT_BOUND * (high - low)
    at_bound: NDArray[np.bool_] = (fit.trial.u < low + near) | (fit.trial.u > high - near)
    return at_bound


def _least_slope(fit: Fit) -> float:
    """Return the largest derivative of all data together that roughness alone could give."""
    sizes = np.nan_to_num(fit.trial.fitted) / fit.model.data.error
    roughness = _ROUGHNESS * max(1.0, fit.model.options.rtol / 1e-6)
    return float(roughness / STEP * np.linalg.norm(sizes))


def profile_intervals(search: Search, fit: Fit, known: Statistics) -> Floats:
    """Return intervals (p, 2) of the profile likelihood, on the scales of the parameters.

    For each parameter all others are refitted. Beyond the interval the data are less probable, at
    the level `LEVEL`, by Student's t if errors are known only from the residuals. An end out of
    bounds is NaN, and so are both ends for a parameter without a standard error.
    """
    own = fit.model.data.relative or fit.scale > 1.0
    goal = _goal(fit) if own else float(norm.ppf(0.5 + LEVEL / 2.0))
    sides = _sides(fit, known, np.zeros_like(fit.left_out))
    intervals = np.full((len(fit.trial.u), 2), np.nan)
    ends = search.side_by_side([_profile_end(side, goal) for side in sides])
    for side, distance in zip(sides, ends, strict=True):
        intervals[side.number, side.end] = side.at(distance)
    return intervals
