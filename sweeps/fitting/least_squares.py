"""Least squares from a starting place, in steps, so that several fits run side by side.

A fit is a generator. It yields a question, which holds the next places to try, and receives the
trials there. `Search.side_by_side` computes the questions of many fits in one call of the lanes.
"""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from sweeps.fitting.trials import Model, Trial
from sweeps.measurements import Floats

# The first radius is one unit of the scale, whatever the size of the logarithm.
_RADIUS = 1.0
# A step is too long if its gain is less than the first fraction of the expected gain, and too short
# if it is more than the second; the radius changes by the two factors.
_POOR, _GOOD, _SHORTER, _LONGER = 0.25, 0.75, 0.25, 2.0
# A fit ends when a step gains less than this fraction of chi2, or is shorter than this. Smaller
# changes come from the roughness of the amplitudes.
_LEAST_GAIN, _LEAST_STEP = 1e-6, 1e-7
_RANK = 1e-6  # singular values below this fraction of the largest count as 0
_LAST_STEPS, _SMALL_STEP = 2, 0.1

EVALUATIONS = 40
"""The largest number of steps of a fit."""

IMPROVED = 1e-6
"""The smallest improvement, as a fraction of chi2; less may be roughness."""


class Question(NamedTuple):
    """Places (m, p) to try, and the rows (m, rows) wanted there, None for all."""

    places: Floats
    rows: NDArray[np.bool_] | None = None


_Result = TypeVar("_Result")
Steps: TypeAlias = Generator[Question, list[Trial], _Result]
"""A calculation that asks for trials as it proceeds."""


@dataclass(frozen=True)
class Fit:
    """A minimum: the trial there, the derivatives (n, p), and which data are next to a jump (n,).

    `scale` is the variance of the residuals: chi2/dof, but at least 1 if errors are known.
    """

    model: Model
    trial: Trial
    slopes: Floats
    at_jump: NDArray[np.bool_]

    @property
    def left_out(self) -> NDArray[np.bool_]:
        """Which data (n,) the statistics ignore, because they have an orbit at a jump."""
        left_out: NDArray[np.bool_] = self.at_jump & self.trial.is_settled[self.model.data.row]
        return left_out

    @property
    def dof(self) -> int:
        """The degrees of freedom: data with a value, minus parameters."""
        return int(self.trial.known.sum()) - len(self.trial.u)

    @property
    def reduced(self) -> float:
        """chi2/dof; NaN without degrees of freedom."""
        return self.trial.chi2 / self.dof if self.dof > 0 else math.nan

    @property
    def scale(self) -> float:
        """The estimated variance of a residual."""
        if self.model.data.relative:
            return self.reduced
        return max(1.0, self.reduced) if self.dof > 0 else 1.0


def trial_at(place: Floats) -> Steps[Trial]:
    """Return the trial at a place (p,)."""
    (trial,) = yield Question(place[None])
    return trial


def fit_at(model: Model, trial: Trial) -> Steps[Fit]:
    """Return a trial, with the derivatives there, as a fit."""
    beside = yield Question(*model.beside(trial))
    return Fit(model, trial, *model.slopes(trial, beside))


def minimum(
    fit: Fit,
    evaluations: int = EVALUATIONS,
    *,
    fixed: int | None = None,
    left_out: NDArray[np.bool_] | None = None,
) -> Steps[Fit]:
    """Return the minimum reached from a fit, in a valley or at the edge of a jump.

    It takes Gauss-Newton steps within the bounds, no longer than the radius in which the linear
    model has proved right (Levenberg and Marquardt). One parameter may be fixed. Some data may be
    left out. Data without a value at the start are ignored as long as they have none.
    """
    gaps = ~fit.trial.known
    ignored = np.zeros_like(gaps) if left_out is None else left_out
    varied = np.arange(len(fit.trial.u)) != fixed
    radius = _RADIUS

    def misfits_of(trial: Trial) -> Floats:
        return np.where(ignored | gaps & ~trial.known, 0.0, trial.residuals)

    misfits = misfits_of(fit.trial)
    for _ in range(evaluations):
        slopes = np.where(ignored[:, None], 0.0, fit.slopes)
        step = _step(fit, slopes, misfits, varied, radius)
        length, cost = float(np.linalg.norm(step)), float(misfits @ misfits)
        expected = cost - float(np.sum((misfits + slopes @ step) ** 2))
        if length < _LEAST_STEP or expected <= _LEAST_GAIN * cost:
            break
        trial = yield from trial_at(fit.model.inside(fit.trial.u + step))
        moved = misfits_of(trial)
        gain = cost - float(moved @ moved)
        if gain < _POOR * expected:
            radius = _SHORTER * length
        elif gain > _GOOD * expected:
            radius = max(radius, _LONGER * length)
        if gain > 0.0:
            fit, misfits = (yield from fit_at(fit.model, trial)), moved
    return fit


def _step(
    fit: Fit, slopes: Floats, misfits: Floats, varied: NDArray[np.bool_], radius: float
) -> Floats:
    """Return the step (p,) that minimizes linear misfits (n,) within a radius and the bounds.

    A parameter that would leave its bounds stops there, and the others get a new step.
    """
    low, high = fit.model.bounds - fit.trial.u
    free, step = varied.copy(), np.zeros(len(varied))
    while free.any():
        step[free] = _shortened(slopes[:, free], misfits + slopes[:, ~free] @ step[~free], radius)
        beyond = free & ((step < low) | (step > high))
        if not beyond.any():
            break
        step[beyond] = np.clip(step, low, high)[beyond]
        free &= ~beyond
    return step


def _shortened(slopes: Floats, misfits: Floats, radius: float) -> Floats:
    """Return the Gauss-Newton step (p,), damped if it is longer than a radius."""
    left, sizes, axes = np.linalg.svd(slopes, full_matrices=False)
    known = sizes > _RANK * sizes.max(initial=0.0)
    sizes, axes = sizes[known], axes[known]
    pulls = sizes * (left[:, known].T @ misfits)

    def damped(damping: float) -> Floats:
        return np.asarray(-(pulls / (sizes**2 + damping)) @ axes)

    def excess(damping: float) -> float:
        return float(np.linalg.norm(damped(damping))) - radius

    if excess(0.0) <= 0.0:
        return damped(0.0)
    return damped(brentq(excess, 0.0, float(np.linalg.norm(pulls)) / radius))


def settled(fit: Fit, least: float) -> Steps[Fit]:
    """Return a minimum after a few more Gauss-Newton steps, as long as they stay within it.

    Because chi2 is rough (by up to `least` for an exact fit), a fit ends some 1e-3 standard errors
    from its minimum, at a different place for each start. The derivative of chi2 is smooth.
    """
    for _ in range(_LAST_STEPS):
        step = -np.linalg.pinv(fit.slopes, rcond=_RANK) @ fit.trial.residuals
        place = fit.trial.u + step
        if not (np.all(np.abs(step) < _SMALL_STEP) and fit.model.are_inside(place[None])[0]):
            break
        trial = yield from trial_at(place)
        allowed = fit.trial.cost * (1.0 + IMPROVED) + least
        if trial.signature != fit.trial.signature or trial.cost > allowed:
            break
        fit = yield from fit_at(fit.model, trial)
    return fit
