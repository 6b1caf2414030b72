"""Compilation of the common kernels before the test workers start, which would each compile them.

Two processes take about equally long. They start no others, because a process that has
compiled one kernel needs a quarter of the time for a similar one. One compiles the adaptive method
for the paper's fluids, for a general power, and for films with all terms of energy and drive. The
other begins with an elastic strain that relaxes, which shares no large kernel with them, goes on to
stochastic films, and leaves Euler-Cromer to the end, since it finds its stationary orbits by the
adaptive kernels of the first.
"""

from __future__ import annotations

import subprocess
import sys

_ALONE = """
from stickslip.dispatch import compilation
compilation.usable_cores = lambda: 1
"""
_PAPER = """
from stickslip import Parameters, simulate, stationary_orbits
stationary_orbits({"T": 300.0, "gamma": [-2 / 3]}, rtol=1e-4)
stationary_orbits({"T": 300.0, "gamma": [0.0, -0.55, 2 / 3]}, rtol=1e-4)
simulate(Parameters(), periods=1)
film = {"T": 300.0, "gamma": 0.4, "d": 300.0, "e": 500.0, "a_3": 0.1}
stationary_orbits(film, rtol=1e-4)
"""
_OTHERS = """
from stickslip import Parameters, simulate, stationary_orbits
stationary_orbits({"T": 300.0}, strain="relaxing", rtol=1e-4)
simulate(Parameters(), periods=1, noise="stochastic")
film = {"T": 300.0, "gamma": [-2 / 3, 0.0]}
stationary_orbits(film, noise="stochastic", realizations=2, window=20, rtol=1e-4)
stationary_orbits(
    {"T": 300.0, "gamma": [-2 / 3, 0.0, -0.55]}, method="euler-cromer", dt=2e-5, max_periods=3
)
"""


def compile_kernels() -> None:
    """Compile kernels into the cache; a failure is shown, and shows again in the tests."""
    scripts = [_ALONE + script for script in (_PAPER, _OTHERS)]
    running = [subprocess.Popen([sys.executable, "-c", script]) for script in scripts]
    for process in running:
        process.wait()
