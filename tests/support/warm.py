"""Compiles what most tests call, once, before workers begin that would each compile it.

Both scripts run at a time: one compiles the adaptive method for the paper's fluids and for a
general power, the other Euler-Cromer.
"""

from __future__ import annotations

import subprocess
import sys

_ADAPTIVE = """
from stickslip import Parameters, simulate, stationary_orbits
stationary_orbits({"T": 300.0, "gamma": [-2 / 3, 0.0, 2 / 3, -0.55]}, rtol=1e-4)
simulate(Parameters(), periods=1)
"""
_EULER_CROMER = """
from stickslip import stationary_orbits
stationary_orbits({"T": 300.0}, method="euler-cromer", dt=2e-5, stationary_rtol=1e-4)
"""


def compile_kernels() -> None:
    """Leave kernels in the cache; what fails here fails again in the tests that need it."""
    running = [
        subprocess.Popen([sys.executable, "-c", script], stderr=subprocess.DEVNULL)
        for script in (_ADAPTIVE, _EULER_CROMER)
    ]
    for process in running:
        process.wait()
