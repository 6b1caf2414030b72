"""A hundred thousand drive periods by the adaptive method, in which nothing should drift."""

from __future__ import annotations

from typing import Any

import numpy as np
from inside import amplitudes_of
from inside.lanes import end_states, period_records
from shared.points import orbits, parameter

from stickslip.options import Options
from stickslip.parameters import Parameters

SCENES = {
    "omega = 38": Parameters(angular_frequency=38.0),
    "locked": Parameters(viscosity_coefficient=2e5, spring_stiffness=200.0, temperature=240.0),
}
_MOST_STEPS = 10**12


def run(quick: bool) -> dict[str, Any]:
    """Compare amplitudes and energy balance before and after a hundred thousand periods."""
    periods, options = 200 if quick else 100_000, Options(max_steps=_MOST_STEPS)
    before = orbits(np.array(list(SCENES.values())), max_steps=_MOST_STEPS)
    settled = _from_states(before.points, before.finals)
    states, steps, statuses = end_states(settled, periods, options)
    after = orbits(_from_states(before.points, states), max_steps=_MOST_STEPS)
    late, early = (
        amplitudes_of(period_records(points, options.rtol)) for points in (after.points, settled)
    )
    drifts = late / early - 1.0
    columns = {
        "scene": list(SCENES),
        "status": statuses.tolist(),
        "steps": steps.tolist(),
        "drift_stress": drifts[:, 0].tolist(),
        "drift_force": drifts[:, 1].tolist(),
        "stated": before.amplitude_error.tolist(),
        "balance_before": before.power_balance_error.tolist(),
        "balance_after": after.power_balance_error.tolist(),
    }
    rows = zip(*columns.values(), strict=True)
    return {"periods": periods, "scenes": [dict(zip(columns, row, strict=True)) for row in rows]}


def _from_states(points: np.ndarray, states: np.ndarray) -> np.ndarray:
    """Return the points with the states (n, 3), (x, v, ln phi), as their starts."""
    moved = points.copy()
    parameter(moved, "initial_displacement")[:] = states[:, 0]
    parameter(moved, "initial_velocity")[:] = states[:, 1]
    parameter(moved, "initial_order_parameter")[:] = np.exp(states[:, 2])
    return moved
