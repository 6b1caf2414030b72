"""Least squares from a place, step by step, so that several fits are computed side by side.

A fit is a generator: it yields a question, the places that it wants to try next, and is sent their
trials. `Search.side_by_side` puts the questions of many fits into one call of the lanes.
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

# The first step is of a unit, not of the size of a logarithm.
_RADIUS = 1.0
# A step that gains less than the first part of what it should is too long, more than the second
# not long enough; the radius changes by these factors.
_POOR, _GOOD, _SHORTER, _LONGER = 0.25, 0.75, 0.25, 2.0
# A fit ends where a step gains less than this part of chi2, or is shorter than this: below, the
# roughness of the amplitudes would decide.
_LEAST_GAIN, _LEAST_STEP = 1e-6, 1e-7
_RANK = 1e-6  # a singular value below this part of the largest is none
_LAST_STEPS, _SMALL_STEP = 2, 0.1

EVALUATIONS = 40
"""Steps of a fit, at most."""

IMPROVED = 1e-6
"""Part of chi2 that is an improvement; less may be roughness."""


class Question(NamedTuple):
    """Places (m, p) to try, and the rows (m, rows) that are wanted there, None for all."""

    places: Floats
    rows: NDArray[np.bool_] | None = None


_Result = TypeVar("_Result")
Steps: TypeAlias = Generator[Question, list[Trial], _Result]
"""A calculation that asks for trials on its way."""


@dataclass(frozen=True)
class Fit:
    """A minimum: the trial there, the derivatives (n, p), data next to a jump (n,).

    `scale` is the variance of residuals: chi2/dof, or 1 where that is less and errors are known.
    """

    model: Model
    trial: Trial
    slopes: Floats
    at_jump: NDArray[np.bool_]

    @property
    def left_out(self) -> NDArray[np.bool_]:
        """Data (n,) of which the statistics take no account: those with an orbit at a jump."""
        left_out: NDArray[np.bool_] = self.at_jump & self.trial.is_settled[self.model.data.row]
        return left_out

    @property
    def dof(self) -> int:
        """Degrees of freedom: data that have a value, minus parameters."""
        return int(self.trial.known.sum()) - len(self.trial.u)

    @property
    def reduced(self) -> float:
        """chi2/dof; NaN without degrees of freedom."""
        return self.trial.chi2 / self.dof if self.dof > 0 else math.nan

    @property
    def scale(self) -> float:
        """The variance of a residual, as far as it is known."""
        if self.model.data.relative:
            return self.reduced
        return max(1.0, self.reduced) if self.dof > 0 else 1.0


def trial_at(place: Floats) -> Steps[Trial]:
    """Return the trial at a place (p,)."""
    (trial,) = yield Question(place[None])
    return trial


def fit_at(model: Model, trial: Trial) -> Steps[Fit]:
    """Return a trial with the derivatives there."""
    beside = yield Question(*model.beside(trial))
    return Fit(model, trial, *model.slopes(trial, beside))


def minimum(
    fit: Fit,
    evaluations: int = EVALUATIONS,
    *,
    fixed: int | None = None,
    left_out: NDArray[np.bool_] | None = None,
) -> Steps[Fit]:
    """Return the minimum that a fit leads to, in a valley or at the edge of a jump.

    Its steps are those of Gauss and Newton, no longer than the radius in which they have proved
    right (Levenberg and Marquardt), and they stay within the bounds. One parameter may be fixed.
    Some data may be left out; those without a value at the start are, as long as they have none.
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
    """Return the step (p,) that makes linear misfits (n,) least, within a radius and the bounds.

    A parameter that would leave its bounds stops there, and the step of the others is found anew.
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
    """Return the step (p,) of Gauss and Newton, damped where it is longer than a radius."""
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
    """Return a minimum after some steps of Gauss and Newton, where they lead within it.

    The roughness of chi2, below `least` for an exact fit, ends a fit some 1e-3 standard errors from
    its minimum, elsewhere from each start; its derivative is smooth.
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
