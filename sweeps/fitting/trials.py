"""Trials: what the model gives for the data, for many sets of free parameters in one call."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.dispatch.workers import Workers
from stickslip.options import METHODS, Options
from stickslip.orbit import failed_row
from stickslip.parameters import Parameters
from stickslip.points import orbit_rows
from stickslip.status import Status
from stickslip.variables import ENERGY_COEFFICIENTS, RESULT_COLUMNS, RESULTS, unbounded
from sweeps.exits import ExpectedError
from sweeps.fitting.parameters import FreeParameter
from sweeps.measurements import Floats, Measurements

_STATUS = RESULT_COLUMNS.index("status")
_ERROR = RESULT_COLUMNS.index("amplitude_error")
_KIND = [RESULT_COLUMNS.index(n) for n in ("regime", "melting_count", "orbit_periods", "status")]
_ENERGY = [Parameters._fields.index(name) for name in ENERGY_COEFFICIENTS]

STEP = 1e-3
"""Step of derivatives on the scale of a free parameter: 1e5 times the roughness of amplitudes."""

_FAR = 30.0  # measured values so many times those of all trials are in another unit
_STANDARD_ERRORS = 3.0  # that an amplitude_error of a mean holds
# By how much more than a model that gives 0 everywhere a trial misses a datum without a value.
_LOST = 100.0


class Budget(NamedTuple):
    """Drive periods, and steps, that an orbit may take; a typical one takes 10 and 3000."""

    periods: int
    steps: int

    def of(self, options: Options) -> Options:
        """Return options within the budget."""
        steps = self.steps if options.max_steps is None else min(self.steps, options.max_steps)
        if METHODS[options.method].own_option == "dt":
            steps = options.settings().max_steps  # it knows in advance how many it takes
        periods = min(self.periods, options.max_periods)
        return replace(options, max_periods=periods, max_steps=steps)


@dataclass(frozen=True)
class Trial:
    """What the model gives with one set of free parameters.

    `residuals` (n,) are those of the data, in standard errors, all finite; `fitted` (n,) the values
    of the model, NaN where it has none; `results` (rows, columns) those of the rows.

    Trials are compared by their `cost`. Data without a value have residuals so large that a trial
    without them costs more than any that has all: it is not known to be better. Its `chi2`, without
    them, is the least that it can be once they are found.
    """

    u: Floats
    fitted: Floats
    residuals: Floats
    results: Floats

    @property
    def known(self) -> NDArray[np.bool_]:
        """Which data (n,) have a value."""
        return np.isfinite(self.fitted)

    @property
    def is_whole(self) -> bool:
        """Whether all data have a value."""
        return bool(self.known.all())

    @property
    def part(self) -> float:
        """The part of the data that have a value."""
        return float(self.known.mean())

    @property
    def chi2(self) -> float:
        """The sum of squared residuals of the data that have a value."""
        return float(np.sum(self.residuals[self.known] ** 2))

    @property
    def cost(self) -> float:
        """The sum of all squared residuals."""
        return float(self.residuals @ self.residuals)

    @property
    def is_settled(self) -> NDArray[np.bool_]:
        """Which rows (rows,) have a periodic orbit, which no larger budget changes."""
        settled: NDArray[np.bool_] = self.results[:, _STATUS] == Status.OK
        return settled

    @property
    def kinds(self) -> NDArray[np.float64]:
        """Regime, counts and status (rows, 4), which differ beyond a jump."""
        return self.results[:, _KIND]

    def is_like(self, other: Trial) -> NDArray[np.bool_]:
        """Tell which rows (rows,) have the kind of motion that they have in another trial."""
        alike: NDArray[np.bool_] = (self.kinds == other.kinds).all(axis=1)
        return alike

    @property
    def signature(self) -> bytes:
        """The kinds of all rows in a form that can be compared."""
        return self.kinds.tobytes()


class OtherUnitError(ExpectedError, ValueError):
    """Measurements that no trial comes near: most likely in another unit, or of another sign."""


def refuse_other_units(data: Measurements, trials: Sequence[Trial]) -> None:
    """Raise OtherUnitError if a variable has values far from those of the model in all trials."""
    fitted = np.array([trial.fitted for trial in trials])
    with np.errstate(divide="ignore", invalid="ignore"):
        off = data.value / fitted
    off[~np.isfinite(off)] = np.nan
    for name in dict.fromkeys(data.variable):
        own = off[:, np.array(data.variable) == name]
        ratios = np.nanmedian(own[~np.isnan(own).all(axis=1)], axis=1)  # one of each trial
        ratios = ratios[ratios != 0.0]
        if not len(ratios):
            continue
        if (ratios < 0.0).all():
            raise OtherUnitError(
                f"{name}: the measured values have the opposite sign to the model's in all trials; "
                "the amplitude of a force, which is positive, is F_max"
            )
        nearest = min(ratios[ratios > 0.0], key=lambda ratio: abs(math.log(ratio)))
        if not 1.0 / _FAR <= nearest <= _FAR:
            raise OtherUnitError(
                f"{name}: the measured values are some {nearest:.2g} times the model's even in "
                f"the nearest of {len(trials)} trials: are they in {RESULTS[name].units}? are "
                "frequency, stiffness, area those of your machine (--set, or a config)?"
            )


@dataclass(frozen=True)
class Model:
    """The model at the rows of measurements, with some parameters free.

    It is computed by `workers`, left out those that `orbit_rows` takes.
    """

    data: Measurements
    free: Sequence[FreeParameter]
    fixed: Parameters
    options: Options
    workers: Workers | None = None

    def trials(
        self, places: Floats, budget: Budget | None, wanted: NDArray[np.bool_] | None = None
    ) -> list[Trial]:
        """Return the trials at places (m, p), computed together.

        Orbits are searched for within a budget and no longer, None for that of the options; if
        `wanted` (m, rows), only there.
        """
        results = self._results(places, budget, wanted)
        return [self._trial(u, rows) for u, rows in zip(places, results, strict=True)]

    def completed(self, trials: Sequence[Trial], budget: Budget | None) -> list[Trial]:
        """Return trials with what does not repeat in them computed anew, within a larger budget."""
        missing = np.array([~trial.is_settled for trial in trials])
        if not missing.any():
            return list(trials)
        again = self._results(np.array([trial.u for trial in trials]), budget, missing)
        return [
            self._trial(trial.u, np.where(rows[:, None], found, trial.results))
            for trial, rows, found in zip(trials, missing, again, strict=True)
        ]

    def beside(self, trial: Trial) -> tuple[Floats, NDArray[np.bool_]]:
        """Return the places (2 p, p) whose trials give derivatives, and the rows wanted there.

        They are a step above, then a step below. A row that does not repeat has no derivative:
        mostly it is chaos, which costs more than all others.
        """
        steps = STEP * np.concatenate([np.eye(len(self.free)), -np.eye(len(self.free))])
        return trial.u + steps, np.tile(trial.is_settled, (len(steps), 1))

    def slopes(self, trial: Trial, beside: Sequence[Trial]) -> tuple[Floats, NDArray[np.bool_]]:
        """Return derivatives (n, p) of the residuals, and which data (n,) are next to a jump.

        By differences over steps to both sides, or to the one on which the motion stays of its
        kind: a derivative across a jump is none. Where both are beyond a jump, it is 0.
        """
        count, row = len(self.free), self.data.row
        ok: NDArray[np.bool_] = trial.is_settled[row]
        slopes, at_jump = np.zeros((len(ok), count)), np.zeros(len(ok), dtype=bool)
        for number, (above, below) in enumerate(zip(beside[:count], beside[count:], strict=True)):
            same = [trial.is_like(side)[row] & ok for side in (above, below)]
            high = np.where(same[0], above.fitted, trial.fitted)
            low = np.where(same[1], below.fitted, trial.fitted)
            width = STEP * np.sum(same, axis=0)
            known = width > 0.0
            slopes[known, number] = (high - low)[known] / (width * self.data.error)[known]
            at_jump |= ~(same[0] & same[1])
        return slopes, at_jump

    @cached_property
    def bounds(self) -> tuple[Floats, Floats]:
        """The lowest and the highest places (p,)."""
        low, high = np.array([(free.lower, free.upper) for free in self.free]).T
        return low, high

    @cached_property
    def wide(self) -> Floats:
        """The extents (p,) of the box in which the search begins."""
        return np.array([free.box[1] - free.box[0] for free in self.free])

    def inside(self, places: Floats) -> Floats:
        """Return places (..., p), moved to the bounds of the free parameters if beyond."""
        return np.asarray(np.clip(places, *self.bounds))

    def are_inside(self, places: Floats) -> NDArray[np.bool_]:
        """Tell which places (m, p) lie within the bounds."""
        low, high = self.bounds
        return np.asarray(((low < places) & (places < high)).all(axis=1))

    def points(self, places: Floats) -> Floats:
        """Return the points (m, rows, parameters) of places (m, p)."""
        points = np.tile(np.array(self.fixed), (len(places), self.data.rows, 1))
        for name, values in self.data.parameters.items():
            points[:, :, Parameters._fields.index(name)] = values
        for number, free in enumerate(self.free):
            column = Parameters._fields.index(free.name)
            points[:, :, column] = free.value(places[:, number])[:, None]
        return points

    def _results(
        self, places: Floats, budget: Budget | None, wanted: NDArray[np.bool_] | None
    ) -> Floats:
        """Return the result rows (m, rows, columns) at places."""
        points = self.points(places)
        flat = points.reshape(-1, points.shape[-1])
        options = budget.of(self.options) if budget else self.options
        results = np.tile(failed_row(Status.FAILED), (len(flat), 1))
        valid = np.repeat([self._is_valid(u) for u in places], self.data.rows)
        valid &= np.array([unbounded(*row) is None for row in flat[:, _ENERGY]], dtype=bool)
        if wanted is not None:
            valid &= wanted.ravel()
        if valid.any():
            # Of rows that differ in nothing one is computed.
            different, places_of = np.unique(flat[valid], axis=0, return_inverse=True)
            found = orbit_rows(different, options, self.workers)
            results[valid] = found[places_of.ravel()]
        return results.reshape(*points.shape[:2], -1)

    def _is_valid(self, u: Floats) -> bool:
        return all(free.is_valid(float(each)) for free, each in zip(self.free, u, strict=True))

    def _trial(self, u: Floats, results: Floats) -> Trial:
        data, columns = self.data, [RESULT_COLUMNS.index(name) for name in self.data.variable]
        fitted = results[data.row, columns]
        residuals = (fitted - data.value) / data.error
        means = results[data.row, _STATUS] == Status.APERIODIC
        # A mean with an error fits no better than that lets it: its mean square is what counts.
        error = results[data.row, _ERROR] / _STANDARD_ERRORS * np.abs(fitted) / data.error
        residuals[means] = np.copysign(np.hypot(residuals, error), residuals)[means]
        fitted = np.where(np.isfinite(residuals), fitted, np.nan)
        residuals[np.isnan(fitted)] = self.lost
        return Trial(u, fitted, residuals, results)

    @cached_property
    def lost(self) -> float:
        """The residual of a datum without a value, more than any that a fit could end with.

        All values are known to be of the order of the model's, or they are refused.
        """
        return _LOST * math.sqrt(self.squares)

    @cached_property
    def squares(self) -> float:
        """The chi2 of a model that gives 0 everywhere."""
        return float(np.sum((self.data.value / self.data.error) ** 2))
