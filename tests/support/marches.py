"""Cheap periods of Euler-Cromer, with a short and fast drive of a solid film."""

from __future__ import annotations

import numpy as np

from stickslip import Parameters
from stickslip.kernels.euler_cromer.lanes import March
from stickslip.kernels.plain_iteration.march import write_starts, write_steps
from stickslip.options import DEFAULTS

FAST = {
    "angular_frequency": 2e3,
    "drive_amplitude": 8e-9,
    "initial_order_parameter": 0.6,
    "temperature": 250.0,
    "initial_displacement": 2e-10,
    "initial_velocity": 2e-6,
}
FAST_DT = 5e-9


def fast(**changes: float) -> Parameters:
    return Parameters(**{**FAST, **changes})


def march_of(points: list[Parameters], dt: float | np.ndarray) -> March:
    """Return the march of points at their starts, each with its own step."""
    array, count = np.array(points), len(points)
    steps, starts = np.empty(count, np.int64), np.empty((count, 3))
    for i, step in enumerate(np.broadcast_to(dt, count).tolist()):
        write_steps(array[i : i + 1], step, steps[i : i + 1])
    write_starts(array, starts)
    return March(array, steps, starts, DEFAULTS.physics)


def period(
    points: list[Parameters], dt: float | np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return states (x, v, phi) and records in SI units after a measured period, and statuses."""
    march = march_of(points, dt)
    march.start(np.arange(len(points)))
    march.march(measured=True)
    return march.states(), march.records(), march.tasks.status
