"""The work of the drive on blocks that a pseudoplastic film locks: a loss that nearly cancels.

It is of parts in 1e5 of what flows to and fro, and less. Stated against true errors, of it and of
the first harmonic of the force, against the same program at 1e-11. And of films from everywhere.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from shared.points import Log, Orbits, at, box, error_bars, orbits, parameter

from stability.stated import everywhere
from stickslip.regime import Regime

_EXACT, _RESOLVED = 1e-11, 1e-10
_TOLERANCES = (1e-4, 1e-6, 1e-8)
_QUANTITIES = ("dissipated_energy", "friction_force_in_phase", "friction_force_out_of_phase")


_strongly_viscous = box(
    4303,
    gamma=(-0.9, -0.3),
    k=Log(1e4, 1e6),
    K=Log(300, 3000),
    X_m=Log(4e-8, 8e-7),
    T=(150, 280),
    omega=Log(3, 60),
)


def run(quick: bool) -> dict[str, Any]:
    """Measure errors of locked and other films."""
    locked, others = _locked(20 if quick else 300), everywhere(20 if quick else 400)
    return {"locked": _answer(locked), "everywhere": _answer(others)}


def _locked(count: int) -> np.ndarray:
    points = _strongly_viscous(2 * count)
    parameter(points, "initial_displacement")[:] = parameter(points, "drive_amplitude")
    parameter(points, "initial_order_parameter")[:] = 0.6
    found = orbits(points)
    return points[found.ok & (found.regime == Regime.LOCKED)][:count]


def _answer(points: np.ndarray) -> dict[str, Any]:
    limits, answers = {"max_periods": 1000, "max_error": 1.0}, {}
    exact = orbits(points, **limits, **at(_EXACT))
    for rtol in _TOLERANCES:
        found = orbits(points, **limits, **at(rtol))
        same = found.same_counts(exact)
        pair = found[same], exact[same]
        answers[f"{rtol:g}"] = {name: _compared(*pair, name) for name in _QUANTITIES}
    return answers


def _compared(found: Orbits, exact: Orbits, name: str) -> dict[str, Any]:
    """Return the errors of a quantity relative to it, and how the stated ones bound them."""
    value, known = getattr(found, name), getattr(exact, name)
    stated = getattr(found, f"{name}_error")
    true, stated = np.abs(value - known) / np.abs(known), stated / np.abs(known)
    return {
        **error_bars(found.points, true, stated, _RESOLVED),
        "wrong_sign": int(np.sum(value * known < 0.0)),
    }
