"""Is the stated error a bound, and how far is it from the error? Five boxes of films.

Against the same program at 1e-10, by kind of motion and of film. A film that is locked is also
known in closed form: its force is |2K - M omega^2| |X_m|.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from shared.points import Orbits, amplitude_errors, at, box_points, orbits, parameter

from stability.locked import balance, inertia
from stickslip.regime import Regime

_EXACT, _RESOLVED = 1e-10, 1e-10
_BALANCED = 1e-6  # a force that agrees with the closed form so well is a locked block's
_MELTS_AT_REST = 298.18885  # [K], Eq. 17 with the paper's values
_IN_CLOSED_FORM = "locked, in closed form"

Range = tuple[str, float, float]
Kinds = dict[str, np.ndarray]


class Box(NamedTuple):
    """`points(count)` films, their number, tolerances and budget, and which are of which kind.

    The constants of the estimate were chosen on 2400 films from everywhere drawn with seed 2901:
    those here are others.
    """

    points: Callable[[int], np.ndarray]
    count: int
    tolerances: tuple[float, ...]
    max_periods: int
    kinds: Callable[[Orbits], Kinds]


def everywhere(count: int) -> np.ndarray:
    """Return rows (count, parameters) from far around the paper's values."""
    return box_points(
        count,
        2906,
        temperature=("linear", 100, 400),
        viscosity_coefficient=("log", 1e3, 1e6),
        spring_stiffness=("log", 100, 5e4),
        angular_frequency=("linear", 1, 100),
        rheological_index=("linear", -0.9, 1),
    )


def thin(count: int) -> np.ndarray:
    """Return thin films (count, parameters) that are strongly viscous and driven little."""
    return box_points(
        count,
        2902,
        rheological_index=("linear", -0.9, -0.5),
        viscosity_coefficient=("log", 1e5, 1e7),
        drive_amplitude=("log", 2e-9, 8e-7),
        spring_stiffness=("log", 100, 4000),
        angular_frequency=("log", 5, 60),
        temperature=("log", 150, 300),
    )


def near_resonance(count: int) -> np.ndarray:
    """Return pseudoplastic films (count, parameters) within |2K/(M omega^2) - 1| <= 0.5."""
    points = box_points(
        count,
        2903,
        temperature=("linear", 200, 330),
        viscosity_coefficient=("log", 3e4, 3e5),
        rheological_index=("linear", -0.8, -0.4),
        angular_frequency=("linear", 30, 60),
    )
    away = np.random.default_rng(2903).uniform(-0.5, 0.5, count)
    parameter(points, "spring_stiffness")[:] = 0.5 * inertia(points) * (1.0 + away)
    return points


def wide(count: int, seed: int = 4902, **more: Range) -> np.ndarray:
    """Return films (count, parameters) whose material and geometry vary over decades."""
    return box_points(
        count,
        seed,
        temperature=("linear", 100, 400),
        viscosity_coefficient=("log", 1e3, 1e6),
        spring_stiffness=("log", 100, 5e4),
        angular_frequency=("log", 1, 100),
        rheological_index=("linear", -0.8, 1),
        drive_amplitude=("log", 1e-7, 3e-6),
        block_mass=("log", 0.05, 5),
        film_thickness=("log", 3e-10, 1e-8),
        strain_relaxation_time=("log", 1e-9, 3e-8),
        contact_area=("log", 1e-10, 1e-8),
        thermal_coefficient=("log", 0.3, 3),
        critical_temperature=("linear", 250, 330),
        elastic_coefficient=("log", 1e12, 4e13),
        cubic_coefficient=("log", 70, 1000),
        quartic_coefficient=("log", 300, 3000),
        **more,
    )


def wide_with_harmonics(count: int) -> np.ndarray:
    """Return such films (count, parameters) under a drive with strong harmonics."""
    names = ("third_harmonic", "fifth_harmonic")
    harmonics: dict[str, Range] = dict.fromkeys(names, ("linear", -1, 1))
    return wide(count, 4903, **harmonics)


def _by_motion_and_fluid(exact: Orbits) -> Kinds:
    melts, liquid = exact.melting_count > 0, exact.regime == Regime.LIQUID
    gamma = parameter(exact.points, "rheological_index")
    return {
        "all": np.ones(len(exact), dtype=bool),
        "stick-slip": melts,
        "liquid": liquid,
        "locked": ~melts & ~liquid,
        "gamma<0": gamma < 0.0,
        "gamma>0": gamma > 0.0,
    }


def _by_balance(exact: Orbits) -> Kinds:
    away = np.abs(exact.friction_force_amplitude / balance(exact.points) - 1.0)
    return {_IN_CLOSED_FORM: away <= _BALANCED, "others": ~(away <= _BALANCED)}


def _by_phase(exact: Orbits) -> Kinds:
    melted = parameter(exact.points, "temperature") > _MELTS_AT_REST
    return {"all": melted | ~melted, "above T_c0": melted, "below T_c0": ~melted}


BOXES = {
    "everywhere": Box(everywhere, 2400, (1e-4, 1e-6), 2000, _by_motion_and_fluid),
    "thin": Box(thin, 3000, (1e-4, 1e-6, 1e-8), 2000, _by_balance),
    "wide": Box(wide, 1500, (1e-4, 1e-6), 1000, _by_motion_and_fluid),
    "wide, harmonics": Box(wide_with_harmonics, 1500, (1e-4, 1e-6), 1000, _by_motion_and_fluid),
    "near resonance": Box(near_resonance, 600, (1e-4, 1e-6), 1000, _by_phase),
}


def run(quick: bool) -> dict[str, Any]:
    """Measure statuses and errors of each kind of film, for each box and tolerance."""
    return {name: _answer(box, 40 if quick else box.count) for name, box in BOXES.items()}


def _answer(box: Box, count: int) -> dict[str, Any]:
    exact = orbits(box.points(count), max_periods=box.max_periods, max_error=1.0, **at(_EXACT))
    return {str(rtol): _compared(box, rtol, exact) for rtol in box.tolerances}


def _compared(box: Box, rtol: float, exact: Orbits) -> dict[str, Any]:
    found, kinds = orbits(exact.points, max_periods=box.max_periods, **at(rtol)), box.kinds(exact)
    # Other cycles are another orbit, of which there can be several at a point.
    both, same = found.ok & exact.ok, found.orbit_periods == exact.orbit_periods
    return {
        "statuses": {kind: found[of].statuses() for kind, of in kinds.items()},
        "other_cycle": int((both & ~same).sum()),
        "balance_max": _off_balance(found[kinds[_IN_CLOSED_FORM]]) if box.points is thin else 0.0,
        "kinds": {
            kind: found.error_bars(exact, both & same & of, _RESOLVED) for kind, of in kinds.items()
        },
    }


def _off_balance(locked: Orbits) -> float:
    """Return largest error of the force of locked blocks against the closed form."""
    locked = locked[locked.ok]
    known = np.column_stack([locked.friction_force_amplitude, balance(locked.points)])
    errors = amplitude_errors(locked.points, known[:, [0, 0]], known[:, [1, 1]])
    return float(errors[:, 1].max(initial=0.0))
