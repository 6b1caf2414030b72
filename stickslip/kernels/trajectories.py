"""The doors to trajectories: sampled states, and what follows from them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from stickslip.compiled.decorators import door, jit
from stickslip.kernels.observers import sampling
from stickslip.kernels.problem import (
    adaptive_period,
    fixed_period,
    log_state,
    phi_state,
    same_state,
)
from stickslip.kernels.rows import FIRST_STEP, Settings, parameters_of, period_of
from stickslip.model import drive, friction
from stickslip.model.rhs import State, relative_velocity, starting_state, stress_and_force
from stickslip.numerics.adaptive import OK
from stickslip.parameters import Parameters


def _make_trajectory(period_map: Any, state: Any, log_state: Any) -> Any:
    """The sampling of one trajectory with one method; `state`, `log_state` as in `_make_point`."""

    @jit
    def trajectory(
        p: Parameters, settings: Settings, start: State, per_period: int, samples: np.ndarray
    ) -> int:
        last = samples.shape[0] - 1
        y, h, steps, status = state(start), FIRST_STEP * period_of(p), 0, OK
        for first in range(0, last, per_period):
            record = sampling(samples[first : first + per_period], period_of(p) / per_period)
            y, h, used, status = period_map(p, settings, y, h, settings.max_steps - steps, record)
            steps += used
            if status != OK:
                return status
        samples[last, 0], samples[last, 1], samples[last, 2] = y[0], y[1], y[2]
        for row in samples:
            row[2] = math.exp(log_state((row[0], row[1], row[2]))[2])
        return status

    return trajectory


_adaptive_trajectory = _make_trajectory(adaptive_period, same_state, same_state)
_fixed_trajectory = _make_trajectory(fixed_period, phi_state, log_state)


@door
def adaptive_trajectory(
    point: np.ndarray, settings: Settings, start: np.ndarray, per_period: int, samples: np.ndarray
) -> int:
    """A sampled trajectory by the adaptive method; returns the status as an integer.

    `point` (20,) parameters; `start` (3,) the state (x, v, ln phi) at phase 0; `samples`
    (periods*per_period + 1, 3) receives (x, v, phi) at equal times.
    """
    return _adaptive_trajectory(
        parameters_of(point), settings, (start[0], start[1], start[2]), per_period, samples
    )


@door
def fixed_trajectory(
    point: np.ndarray, settings: Settings, start: np.ndarray, per_period: int, samples: np.ndarray
) -> int:
    """A sampled trajectory by Euler-Cromer; as `adaptive_trajectory`."""
    return _fixed_trajectory(
        parameters_of(point), settings, (start[0], start[1], start[2]), per_period, samples
    )


@door
def trajectory_observables(
    point: np.ndarray, times: np.ndarray, samples: np.ndarray, observables: np.ndarray
) -> None:
    """What follows from the states (x, v, phi) of a trajectory.

    `times` (n,), `samples` (n, 3); `observables` (n, 6) receives X, V, elastic strain, elastic
    stress, viscous stress, friction force.
    """
    p = parameters_of(point)
    for i in range(times.shape[0]):
        t = times[i]
        u = relative_velocity(p, t, samples[i, 1])
        row = observables[i]
        row[0] = drive.upper_displacement(t, p.drive_amplitude, p.angular_frequency)
        row[1] = drive.upper_velocity(t, p.drive_amplitude, p.angular_frequency)
        row[2] = friction.elastic_strain(u, p.strain_relaxation_time, p.film_thickness)
        row[3], row[5] = stress_and_force(p, u, samples[i, 2])
        row[4] = friction.viscous_stress(
            u, p.film_thickness, p.viscosity_coefficient, p.rheological_index
        )


@door
def starting_log_state(point: np.ndarray, state: np.ndarray) -> None:
    """Write the start (x, v, ln phi) of the parameters `point` (20,) into `state` (3,)."""
    state[0], state[1], state[2] = starting_state(parameters_of(point))
