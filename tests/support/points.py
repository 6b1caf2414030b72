"""Points of the paper's figures, and orbits that are computed once for all tests of a process."""

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
"""Those whose block moves with the drive."""

FIG_7 = ("temperature", tuple(np.linspace(150.0, 320.0, 86).tolist()))
FIG_8 = ("viscosity_coefficient", tuple(np.linspace(1e4, 2e5, 39).tolist()))
FIG_9 = ("spring_stiffness", tuple(np.linspace(100.0, 1e4, 100).tolist()))


def row(**changes: float) -> np.ndarray:
    """The parameters of Fig. 3 with some changes, as kernels take them."""
    return np.array(Parameters(**changes))


def rows(axis: str, values: Iterable[float], **changes: float) -> np.ndarray:
    """The points of an axis."""
    return np.array([Parameters(**{axis: value}, **changes) for value in values])


def orbits(points: np.ndarray, **options: Any) -> SimpleNamespace:
    """The result columns by name, for the options given; `.row` and `.final` hold all of them."""
    results, finals = compute_orbits(points, Options(**options))
    columns = dict(zip(RESULT_COLUMNS, results.T, strict=True))
    return SimpleNamespace(**columns, row=results, final=finals)


def refuse_nothing(points: np.ndarray, options: Options) -> np.ndarray:
    """What to put in the place of a driver's `largest_step` to get past its refusal."""
    return np.full(len(points), np.inf)


@cache
def curve(figure: tuple[str, tuple[float, ...]], gamma: float) -> SimpleNamespace:
    """A curve of Fig. 7, 8 or 9 at the default settings; `.x` has its axis."""
    axis, values = figure
    computed = orbits(rows(axis, values, rheological_index=gamma))
    computed.x = np.array(values)
    return computed


def error_scales(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The least yardsticks of stress (over A) and force: 1 % of max(2K, M omega^2)|X_m|.

    Of each harmonic of the drive, and their sum.
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
    """Worse error of the two amplitudes, counted as `amplitude_error` counts it."""
    stress_scale, force_scale = error_scales(points)
    return np.maximum(
        np.abs(computed.elastic_stress_amplitude - stress) / np.maximum(stress, stress_scale),
        np.abs(computed.friction_force_amplitude - force) / np.maximum(force, force_scale),
    )
