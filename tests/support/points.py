"""Points of the paper's figures and of other motions, and their orbits."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np

from stickslip import Parameters
from stickslip.options import Options
from stickslip.orbit import compute_orbits
from stickslip.variables import RESULT_COLUMNS

GAMMAS = (-2 / 3, 0.0, 2 / 3)
"""The three lubricants of Figs. 7 to 9."""

LOCKED = (0.0, 2 / 3)
"""The lubricants whose block moves with the drive."""

FIG_7 = ("temperature", tuple(np.linspace(150.0, 320.0, 86).tolist()))
FIG_8 = ("viscosity_coefficient", tuple(np.linspace(1e4, 2e5, 39).tolist()))
FIG_9 = ("spring_stiffness", tuple(np.linspace(100.0, 1e4, 100).tolist()))

SUBHARMONIC = {
    "temperature": 172.92, "viscosity_coefficient": 22891.7, "spring_stiffness": 5491.4,
    "angular_frequency": 55.225,
}  # fmt: skip

TWO_SOLIDS = {
    "cubic_coefficient": 230.0, "quartic_coefficient": 1475.83, "quintic_coefficient": 3258.33,
    "sextic_coefficient": 2395.83,
}  # fmt: skip
"""The balance of these films turns at the order parameters 0.12, 0.4 and 0.5."""

MISSED_STICKS = {
    "angular_frequency": 200.0, "drive_amplitude": 4e-8, "spring_stiffness": 6e4,
    "block_mass": 0.02, "rheological_index": 0.0, "viscosity_coefficient": 1000.0,
    "noise_intensity": 1e-8, "initial_order_parameter": 0.6,
}  # fmt: skip
"""Stochastic noise makes this film miss a stick now and then; few fixed steps make a period."""


def row(**changes: float) -> np.ndarray:
    """Return the parameters of Fig. 3 with some changes, as kernels take them."""
    return np.array(Parameters(**changes))


def rows(axis: str, values: Iterable[float], **changes: float) -> np.ndarray:
    """Return the points along an axis."""
    return np.array([Parameters(**{axis: value}, **changes) for value in values])


def orbits(points: np.ndarray, **options: Any) -> SimpleNamespace:
    """Return the result columns by name; `.row` and `.final` hold the whole arrays."""
    results, finals = compute_orbits(points, Options(**options))
    columns = dict(zip(RESULT_COLUMNS, results.T, strict=True))
    return SimpleNamespace(**columns, row=results, final=finals)


def refuse_nothing(points: np.ndarray, options: Options) -> np.ndarray:
    """Return infinite steps, in place of a driver's `largest_step`, so that it refuses nothing."""
    return np.full(len(points), np.inf)


@cache
def curve(figure: tuple[str, tuple[float, ...]], gamma: float) -> SimpleNamespace:
    """Return a curve of Fig. 7, 8 or 9 at the default settings; `.x` has its axis."""
    axis, values = figure
    computed = orbits(rows(axis, values, rheological_index=gamma))
    computed.x = np.array(values)
    return computed


def error_scales(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the smallest scales of stress (over A) and force, 1 % of max(2K, M omega^2)|X_m|.

    They are sums over the harmonics of the drive.
    """
    named = dict(zip(Parameters._fields, np.atleast_2d(points).T, strict=True))
    force = np.zeros(len(np.atleast_2d(points)))
    for n, part in ((1, 1.0), (3, named["third_harmonic"]), (5, named["fifth_harmonic"])):
        inertia = named["block_mass"] * (n * named["angular_frequency"]) ** 2
        stiffness = np.maximum(2 * named["spring_stiffness"], inertia)
        force += 0.01 * stiffness * np.abs(part * named["drive_amplitude"])
    return force / named["contact_area"], force


def amplitude_errors(
    computed: SimpleNamespace, points: np.ndarray, stress: np.ndarray, force: np.ndarray
) -> np.ndarray:
    """Return the larger error of the two amplitudes, as `amplitude_error` defines it."""
    stress_scale, force_scale = error_scales(points)
    return np.maximum(
        np.abs(computed.elastic_stress_amplitude - stress) / np.maximum(stress, stress_scale),
        np.abs(computed.friction_force_amplitude - force) / np.maximum(force, force_scale),
    )
