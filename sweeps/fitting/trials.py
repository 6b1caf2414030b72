"""Trials: the values of the model at the data, for many sets of free parameters in one call."""

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
"""Step of derivatives on the scale of a free parameter, 1e5 times the roughness of amplitudes."""

_FAR = 30.0  # measured values that differ by this factor from all trials are in another unit
_STANDARD_ERRORS = 3.0  # standard errors in the amplitude_error of a mean
# Misfit of a datum without a value, relative to a model that gives 0 everywhere.
_LOST = 100.0


class Budget(NamedTuple):
    """The most drive periods and steps for an orbit; a typical orbit takes 10 and 3000."""

    periods: int
    steps: int

    def of(self, options: Options) -> Options:
        """Return options within the budget."""
        steps = self.steps if options.max_steps is None else min(self.steps, options.max_steps)
        if METHODS[options.method].own_option == "dt":
            steps = options.settings().max_steps  # a fixed step determines their number
        periods = min(self.periods, options.max_periods)
        return replace(options, max_periods=periods, max_steps=steps)


@dataclass(frozen=True)
class Trial:
    """The results of the model for one set of free parameters.

    `residuals` (n,) of the data are in standard errors and finite. `fitted` (n,) are the values of
    the model, NaN for missing ones. `results` (rows, columns) are the result rows.

    Trials are compared by `cost`. A datum without a value has such a large residual that the trial
    costs more than any trial with all values, since it is not known to be better. Its `chi2`, which
    leaves these data out, is the least possible cost once they have values.
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
        """The fraction of the data that have a value."""
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
        """Which rows (rows,) have a periodic orbit, which a larger budget would not change."""
        settled: NDArray[np.bool_] = self.results[:, _STATUS] == Status.OK
        return settled

    @property
    def kinds(self) -> NDArray[np.float64]:
        """Regime, counts and status (rows, 4), which change at a jump."""
        return self.results[:, _KIND]

    def is_like(self, other: Trial) -> NDArray[np.bool_]:
        """Return which rows (rows,) have the same kind of motion in another trial."""
        alike: NDArray[np.bool_] = (self.kinds == other.kinds).all(axis=1)
        return alike

    @property
    def signature(self) -> bytes:
        """The kinds of all rows in a form that is fast to compare."""
        return self.kinds.tobytes()


class OtherUnitError(ExpectedError, ValueError):
    """Measurements far from all trials, most likely in another unit or of another sign."""


def refuse_other_units(data: Measurements, trials: Sequence[Trial]) -> None:
    """Raise OtherUnitError if the values of a variable are far from the model in all trials."""
    fitted = np.array([trial.fitted for trial in trials])
    with np.errstate(divide="ignore", invalid="ignore"):
        off = data.value / fitted
    off[~np.isfinite(off)] = np.nan
    for name in dict.fromkeys(data.variable):
        own = off[:, np.array(data.variable) == name]
        ratios = np.nanmedian(own[~np.isnan(own).all(axis=1)], axis=1)  # one for each trial
        ratios = ratios[ratios != 0.0]
        if not len(ratios):
            continue
        if (ratios < 0.0).all():
            raise OtherUnitError(
                f"{name}: the measured values have the opposite sign to the model's in all trials; "
                "for the amplitude of a force, which is positive, use F_max"
            )
        nearest = min(ratios[ratios > 0.0], key=lambda ratio: abs(math.log(ratio)))
        if not 1.0 / _FAR <= nearest <= _FAR:
            raise OtherUnitError(
                f"{name}: the measured values are about {nearest:.2g} times the model's even in "
                f"the closest of {len(trials)} trials: are they in {RESULTS[name].units}? do "
                "frequency, stiffness and area match your machine (--set, or a config)?"
            )


@dataclass(frozen=True)
class Model:
    """The model at the rows of measurements, with some free parameters.

    `workers` compute it, by default the workers of `orbit_rows`.
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

        The search for orbits stays within a budget; None means the budget of the options. With
        `wanted` (m, rows) only those rows are computed.
        """
        results = self._results(places, budget, wanted)
        return [self._trial(u, rows) for u, rows in zip(places, results, strict=True)]

    def completed(self, trials: Sequence[Trial], budget: Budget | None) -> list[Trial]:
        """Return trials whose rows without a periodic orbit are computed with a larger budget."""
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

        The places are a step above, then a step below. A row without a periodic orbit has no
        derivative; it is mostly chaotic, and would cost more than all others.
        """
        steps = STEP * np.concatenate([np.eye(len(self.free)), -np.eye(len(self.free))])
        return trial.u + steps, np.tile(trial.is_settled, (len(steps), 1))

    def slopes(self, trial: Trial, beside: Sequence[Trial]) -> tuple[Floats, NDArray[np.bool_]]:
        """Return derivatives (n, p) of the residuals, and which data (n,) are next to a jump.

        They are differences over a step to each side, or only to the side on which the kind of
        motion stays the same, since there is no derivative across a jump. If it changes on both
        sides, the derivative is 0.
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
        """Return places (..., p), moved to the bounds of the free parameters if outside."""
        return np.asarray(np.clip(places, *self.bounds))

    def are_inside(self, places: Floats) -> NDArray[np.bool_]:
        """Return which places (m, p) lie within the bounds."""
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
            # Equal rows are computed once.
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
        # A mean fits no better than its error allows, so its mean square residual counts.
        error = results[data.row, _ERROR] / _STANDARD_ERRORS * np.abs(fitted) / data.error
        residuals[means] = np.copysign(np.hypot(residuals, error), residuals)[means]
        fitted = np.where(np.isfinite(residuals), fitted, np.nan)
        residuals[np.isnan(fitted)] = self.lost
        return Trial(u, fitted, residuals, results)

    @cached_property
    def lost(self) -> float:
        """The residual of a datum without a value, larger than any at the end of a fit.

        Measured values have the order of magnitude of the model's; others are refused.
        """
        return _LOST * math.sqrt(self.squares)

    @cached_property
    def squares(self) -> float:
        """The chi2 of a model that gives 0 everywhere."""
        return float(np.sum((self.data.value / self.data.error) ** 2))
