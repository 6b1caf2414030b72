"""The smallest kernel of the package in a fresh interpreter: it is compiled in half a second."""

from __future__ import annotations

from pathlib import Path

from support.package import PACKAGE, run_python

# Its ln(phi) comes from model/noise.py.
SMALL_KERNEL = """
import numpy as np
from stickslip.kernels.trajectories import start_kernel
from stickslip.options import DEFAULTS
from stickslip.parameters import Parameters
state = np.empty(3)
start_kernel(DEFAULTS.physics)(np.array(Parameters()), state)
stats = start_kernel(DEFAULTS.physics).stats
print(state[2], sum(stats.cache_hits.values()), sum(stats.cache_misses.values()))
"""
LOG_PHI = -26.2318641


def run_small_kernel(cache: Path, package: Path = PACKAGE) -> tuple[float, int, int, str]:
    """ln(phi), hits and misses of the cache, and what was warned."""
    out, err = run_python(SMALL_KERNEL, cache, package)
    value, hits, misses = out.split()
    return float(value), int(hits), int(misses), err
