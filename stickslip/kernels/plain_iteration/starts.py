"""Starts of periods of fixed steps: the number of steps, the states, and finals."""

from __future__ import annotations

import math

import numpy as np

from stickslip.compiled.decorators import kernel
from stickslip.kernels.points import FIRST_STEP, parameters_of
from stickslip.model import drive
from stickslip.model.rhs import starting_state


@kernel
def write_steps(points: np.ndarray, dt: float, steps: np.ndarray) -> None:
    """Write the number of steps per period, which divide it evenly, each of at most `dt`."""
    for i in range(points.shape[0]):
        steps[i] = math.ceil(drive.period(parameters_of(points[i])) / dt)


@kernel
def write_starts(points: np.ndarray, states: np.ndarray) -> None:
    """Write the starts (x, v, phi) of points (n, parameters), in SI units, into `states` (n, 3)."""
    for i in range(points.shape[0]):
        x, v, psi = starting_state(parameters_of(points[i]))
        states[i, 0], states[i, 1], states[i, 2] = x, v, math.exp(psi)


def finals_of(points: np.ndarray, states: np.ndarray) -> np.ndarray:
    """Return states (n, 3), (x, v, phi), as finals (n, columns): (x, v, ln phi), the next step."""
    finals = np.empty((len(points), states.shape[1] + 1))
    _write_finals(points, states, finals)
    return finals


@kernel
def _write_finals(points: np.ndarray, states: np.ndarray, finals: np.ndarray) -> None:
    for i in range(finals.shape[0]):
        finals[i, 0], finals[i, 1] = states[i, 0], states[i, 1]
        finals[i, 2] = math.log(states[i, 2])
        finals[i, 3] = FIRST_STEP * drive.period(parameters_of(points[i]))


def states_of(finals: np.ndarray) -> np.ndarray:
    """Return the states (x, v, phi), shape (n, 3), of finals (n, columns)."""
    return np.column_stack([finals[:, 0], finals[:, 1], np.exp(finals[:, 2])])
