"""The work of the drive on blocks that a pseudoplastic film locks: a loss that nearly cancels.

It is of parts in 1e5 of what flows to and fro, and less. Stated against true errors, of it and of
the first harmonic of the force, against the same program at 1e-11 and, for blocks that hardly slip,
against the closed form. And of films from everywhere.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from shared.points import Log, Orbits, at, box, error_bars, orbits, parameter, quantile

from stability.locked import balance
from stability.stated import everywhere
from stickslip.parameters import ParameterValues
from stickslip.regime import Regime

_EXACT, _RESOLVED = 1e-11, 1e-10
_TOLERANCES = (1e-4, 1e-6, 1e-8)
_QUANTITIES = ("dissipated_energy", "friction_force_in_phase", "friction_force_out_of_phase")
_HARDLY = 1e-3  # slip over X_m
_SLIPS = 3.0  # relative change of the work by a slip, over the slip


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
    """Measure errors of locked and other films, and of the former against the closed form."""
    locked, others = _locked(20 if quick else 300), everywhere(20 if quick else 400)
    return {"locked": _answer(locked, closed=True), "everywhere": _answer(others, closed=False)}


def _locked(count: int) -> np.ndarray:
    points = _strongly_viscous(2 * count)
    parameter(points, "initial_displacement")[:] = parameter(points, "drive_amplitude")
    parameter(points, "initial_order_parameter")[:] = 0.6
    found = orbits(points)
    return points[found.ok & (found.regime == Regime.LOCKED)][:count]


def _answer(points: np.ndarray, *, closed: bool) -> dict[str, Any]:
    limits, answers = {"max_periods": 1000, "max_error": 1.0}, {}
    exact = orbits(points, **limits, **at(_EXACT))
    for rtol in _TOLERANCES:
        found = orbits(points, **limits, **at(rtol))
        same = found.same_counts(exact)
        answers[f"{rtol:g}"] = {
            name: _compared(found[same], exact[same], name) for name in _QUANTITIES
        }
        if closed:
            answers[f"{rtol:g}"]["closed form"] = _against_closed_form(found)
    return answers


def _compared(found: Orbits, exact: Orbits, name: str) -> dict[str, Any]:
    """Return the errors of a quantity relative to it, and how the stated ones bound them."""
    value, known = getattr(found, name), getattr(exact, name)
    stated = getattr(found, f"{name}_error")
    true, stated = np.abs(value - known) / np.abs(known), stated / np.abs(known)
    return {
        **error_bars(found.points, true, stated, _RESOLVED),
        "stated_median": quantile(stated, 50),
        "stated_95": quantile(stated, 95),
        "wrong_sign": int(np.sum(value * known < 0.0)),
    }


def _against_closed_form(found: Orbits) -> dict[str, Any]:
    """Return how many of the blocks that hardly slip lose more or less than they should."""
    work, slip = _without_slip(found.points)
    few = (slip < _HARDLY) & found.ok
    away = np.abs(found.dissipated_energy - work)
    held = away <= found.dissipated_energy_error + _SLIPS * slip * work
    return {"compared": int(few.sum()), "held": float(np.mean(held[few]))}


def _without_slip(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the work [J] in a period of blocks that move with the drive, and the slip over X_m.

    F is |2K - M omega^2| X_m cos(omega t), and the film, a solid at rest, slips as F makes it.
    """
    p = ParameterValues(*points.T[:, :, None])
    b, c = p.cubic_coefficient, p.quartic_coefficient
    heating = 2.0 * p.thermal_coefficient * (p.temperature - p.critical_temperature)
    phi = (b + np.sqrt(b * b - 4.0 * c * heating)) / (2.0 * c)
    elastic = p.elastic_coefficient * phi**2 * p.strain_relaxation_time
    nodes, weights = np.polynomial.legendre.leggauss(400)
    F = balance(points)[:, None] * np.cos(0.25 * np.pi * (nodes + 1.0))
    low, high = np.full(F.shape, -2000.0), np.full(F.shape, 60.0)  # of ln(u/h)
    for _ in range(80):
        middle = 0.5 * (low + high)
        viscous = p.viscosity_coefficient * np.exp((p.rheological_index + 1.0) * middle)
        above = (elastic * np.exp(middle) + viscous) * p.contact_area > F
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    u, quarter = p.film_thickness * np.exp(middle), 0.25 * np.pi * weights
    omega, X_m = parameter(points, "angular_frequency"), parameter(points, "drive_amplitude")
    return 4.0 * (F * u) @ quarter / omega, 2.0 * u @ quarter / (omega * np.abs(X_m))
