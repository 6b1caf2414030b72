"""A hundred thousand drive periods by the adaptive method, in which nothing should drift."""

from __future__ import annotations

from typing import Any

import numpy as np
from inside.lanes import end_states, first_period

from stickslip.options import Options
from stickslip.orbit import compute_orbits, orbit_of_row
from stickslip.parameters import Parameters

SCENES = {
    "omega = 38": Parameters(angular_frequency=38.0),
    "locked": Parameters(viscosity_coefficient=2e5, spring_stiffness=200.0, temperature=240.0),
}


def run(quick: bool) -> dict[str, Any]:
    """Compare amplitudes and energy balance before and after a hundred thousand periods."""
    periods, options = 200 if quick else 100_000, Options(max_steps=10**12)
    points = np.array(list(SCENES.values()))
    orbits = [orbit_of_row(*rows) for rows in zip(*compute_orbits(points, options), strict=True)]
    settled = _from_states(points, np.array([orbit.state for orbit in orbits]))
    states, steps, statuses = end_states(settled, periods, options)
    after = _from_states(points, states)
    _, before_amplitudes = first_period(settled, options)
    _, amplitudes = first_period(after, options)
    later = [orbit_of_row(*rows) for rows in zip(*compute_orbits(after, options), strict=True)]
    return {
        "periods": periods,
        "scenes": [
            {
                "scene": name,
                "status": int(statuses[i]),
                "steps": int(steps[i]),
                "drift_stress": float(amplitudes[i, 0] / before_amplitudes[i, 0] - 1.0),
                "drift_force": float(amplitudes[i, 1] / before_amplitudes[i, 1] - 1.0),
                "stated": orbits[i].amplitude_error,
                "balance_before": orbits[i].power_balance_error,
                "balance_after": later[i].power_balance_error,
            }
            for i, name in enumerate(SCENES)
        ],
    }


def _from_states(points: np.ndarray, states: np.ndarray) -> np.ndarray:
    """Return the points with the states (n, 3), (x, v, ln phi), as their starts."""
    return np.array(
        [
            Parameters(*row)._replace(
                initial_displacement=x,
                initial_velocity=v,
                initial_order_parameter=float(np.exp(psi)),
            )
            for row, (x, v, psi) in zip(points, states.tolist(), strict=True)
        ]
    )
