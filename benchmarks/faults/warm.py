"""Imported by the server of child processes: they begin with all modules and compiled code."""

import numpy as np

import sweeps.figures  # noqa: F401
from stickslip.options import Options
from stickslip.orbit import compute_orbits
from stickslip.parameters import Parameters

for _temperature, _gamma in ((200.0, 0.0), (310.0, 0.0), (200.0, -2 / 3)):
    compute_orbits(
        np.array([Parameters(temperature=_temperature, rheological_index=_gamma)]),
        Options(rtol=1e-4, stationary_rtol=1e-4),
    )
