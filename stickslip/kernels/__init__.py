"""The compiled doors: the only place where the model and the numerical methods meet.

A door takes plain arrays and a Settings tuple, works through many points without the interpreter
and leaves a status for each; it raises nothing. `NUMERICS_VERSION` must be raised whenever a
change alters any number that a door returns; the golden tests notice when it was forgotten.
"""

from __future__ import annotations

from stickslip.kernels.adaptive.driver import compile_lanes, lane_end_states, lane_orbits
from stickslip.kernels.euler_cromer.search import fixed_lane_orbits
from stickslip.kernels.orbits import adaptive_orbits, fixed_orbits
from stickslip.kernels.rows import FINAL_COLUMNS, RESULT_COLUMNS, Settings
from stickslip.kernels.trajectories import (
    adaptive_trajectory,
    fixed_trajectory,
    starting_log_state,
    trajectory_observables,
)

__all__ = [
    "FINAL_COLUMNS",
    "NUMERICS_VERSION",
    "RESULT_COLUMNS",
    "Settings",
    "adaptive_orbits",
    "adaptive_trajectory",
    "compile_lanes",
    "fixed_lane_orbits",
    "fixed_orbits",
    "fixed_trajectory",
    "lane_end_states",
    "lane_orbits",
    "starting_log_state",
    "trajectory_observables",
]

NUMERICS_VERSION = 2
