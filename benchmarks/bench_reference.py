"""Three stationary orbits to twelve digits, by the adaptive method and by Taylor series.

The adaptive method runs at its tightest tolerance. The series (`reference/taylor.py`, which shares
no code with the package) begin on the orbit it has found and must come back to it, three times;
they run at two orders and tolerances, whose difference shows what they resolve.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from reference import EXTREMES, film_of, half_period
from shared.measuring import measure

from stickslip import Parameters, simulate, stationary_orbit

TIGHTEST = 1.01e-13
SERIES = ((20, 1e-16), (26, 1e-17))
"""Orders, and bounds of the last terms."""
PERIODS, MOST_STEPS = 3, 10_000_000

ORBITS: dict[str, tuple[dict[str, float], str]] = {
    "stick-slip": ({}, "adiabatic"),
    "asymmetric": ({"angular_frequency": 15.0}, "adiabatic"),
    "relaxing": (
        {
            "strain_relaxation_time": 1e-6,
            "film_thickness": 1e-7,
            "viscosity_coefficient": 2.3e5,
        },
        "relaxing",
    ),
}
"""What differs from the parameters of Fig. 3, and the treatment of the strain."""


def orbits(quick: bool) -> dict[str, Any]:
    """Compute each orbit with both solvers."""
    return {name: _both(*what, quick=quick) for name, what in ORBITS.items()}


def _both(changes: dict[str, float], strain: str, *, quick: bool) -> dict[str, Any]:
    p = Parameters(**changes)
    orbit = stationary_orbit(p, rtol=TIGHTEST, strain=strain)
    motion = simulate(p, periods=1, start="stationary", samples=2, rtol=TIGHTEST, strain=strain)
    begin = motion.isel(sample=0) if "sample" in motion.dims else motion.isel(elapsed_time=0)
    names = ("lower_displacement", "lower_velocity", "order_parameter", "elastic_strain")
    own = {name: float(begin[name]) for name in names}
    own |= {name: getattr(orbit, name) for name in (*EXTREMES, "dissipated_energy")}
    settings = SERIES[:1] if quick else SERIES
    found = [
        _by_series(p, own, strain, *each, periods=1 if quick else PERIODS) for each in settings
    ]
    return {
        "changes": changes,
        "strain": strain,
        "kind": orbit.regime.name.lower(),
        "meltings": orbit.melting_count,
        "own": own,
        "stated_error": orbit.amplitude_error,
        "series": found,
        "difference": _differences(own, found[-1]["values"]),
        "between_series": _differences(found[0]["values"], found[-1]["values"]),
    }


def _by_series(
    p: Parameters, own: dict[str, float], strain: str, order: int, bound: float, *, periods: int
) -> dict[str, Any]:
    """Return the numbers of the last of so many periods, and how far from its start it ends."""
    film = film_of(p, relaxing=strain == "relaxing")
    X_m, V_m = p.drive_amplitude, p.drive_amplitude * p.angular_frequency
    unit = V_m * p.strain_relaxation_time / p.film_thickness
    state = np.array([
        0.0, own["lower_displacement"] / X_m, -own["lower_velocity"] / V_m,
        math.log(own["order_parameter"]), own["elastic_strain"] / unit, 0.0,
    ])  # fmt: skip
    for _ in range(periods):
        before = state
        state, one, steps = half_period(film, before, order, bound, MOST_STEPS)
        state, other, more = half_period(film, state, order, bound, MOST_STEPS)
    # The second half was computed as the mirror image.
    extremes = np.array([
        max(one[0], -other[1]), min(one[1], -other[0]),
        max(one[2], -other[3]), min(one[3], -other[2]),
    ])  # fmt: skip
    values = dict(zip(EXTREMES, extremes.tolist(), strict=True))
    values["dissipated_energy"] = float(one[4] + other[4]) * film.force_unit * X_m
    values["lower_displacement"] = float(state[1]) * X_m
    values["lower_velocity"] = -float(state[2]) * V_m
    values["order_parameter"] = math.exp(state[3])
    values["elastic_strain"] = float(state[4]) * unit
    return {
        "order": order,
        "bound": bound,
        "steps": steps + more,
        "values": values,
        "returns_within": float(np.abs(state - before).max()),
    }


def _differences(one: dict[str, float], other: dict[str, float]) -> dict[str, float]:
    """Return relative differences."""
    return {name: abs(one[name] / value - 1.0) for name, value in other.items()}


if __name__ == "__main__":
    measure("reference", __doc__, {"orbits": orbits})
