"""Compilation of the common kernels before the test workers start, which would each compile them.

Two scripts run at the same time. One compiles the adaptive method for the paper's fluids and for a
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
    """Compile kernels into the cache; a failure here shows again in the tests that need them."""
    running = [
        subprocess.Popen([sys.executable, "-c", script], stderr=subprocess.DEVNULL)
        for script in (_ADAPTIVE, _EULER_CROMER)
    ]
    for process in running:
        process.wait()
