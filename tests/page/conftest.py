"""A result to open, for the tests of pages."""

from __future__ import annotations

import pytest
import xarray as xr

from sweeps import run

MAP = {
    "title": "A map",
    "sweep": {
        "temperature": {"linspace": [210, 290], "num": 9},
        "spring_stiffness": {"geomspace": [500, 8000], "num": 9},
    },
    "integrator": {"rtol": 1e-4},
    "stationary": {"rtol": 1e-4},
}


@pytest.fixture(scope="session")
def result() -> xr.Dataset:
    """Compute 9 x 9 points of the paper's fluid."""
    return run(MAP, workers=1)
