"""A followed axis jumps where plain iteration along the same axis jumps."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import xarray as xr

from sweeps import run
from sweeps.config.paper import shipped_config

pytestmark = pytest.mark.stress  # plain iteration takes minutes

PLAIN = {"integrator": {"rtol": 1e-9}, "stationary": {"rtol": 1e-8, "accelerate": False}}
STEP = 0.25


def followed(**changes: object) -> xr.Dataset:
    config = {
        "sweep": {"angular_frequency": {"arange": [5, 60, STEP]}},
        "follow": "angular_frequency",
        **changes,
    }
    return run(config)


@cache
def both() -> tuple[xr.Dataset, xr.Dataset]:
    return run(shipped_config("hysteresis")), followed(**PLAIN)


def jumps(ds: xr.Dataset, direction: str) -> np.ndarray:
    """Return the frequencies after which the kind of motion changes."""
    line = ds.sel(direction=direction)
    kinds = np.stack([line.regime, line.orbit_periods, line.melting_count])
    return line.angular_frequency.values[:-1][(np.diff(kinds) != 0).any(axis=0)]


@pytest.mark.parametrize("direction", ["up", "down"])
def test_every_jump_is_within_a_step_of_plain_iteration(direction: str) -> None:
    quick, plain = (jumps(ds, direction) for ds in both())
    assert len(quick) == len(plain) > 0
    np.testing.assert_allclose(quick, plain, rtol=0, atol=STEP)


def test_between_the_jumps_amplitudes_agree_with_plain_iteration() -> None:
    quick, plain = both()
    assert (quick.status == 0).all()
    assert (plain.status == 0).all()
    same = (quick.regime == plain.regime) & (quick.melting_count == plain.melting_count)
    assert same.mean() > 0.99
    stated = quick.amplitude_error + plain.amplitude_error
    full = np.maximum(2 * quick.spring_stiffness, quick.block_mass * quick.angular_frequency**2)
    full = full * abs(quick.drive_amplitude)
    for name, area in (
        ("elastic_stress_amplitude", quick.contact_area),
        ("friction_force_amplitude", 1.0),
    ):
        apart = np.abs(quick[name] - plain[name]) / np.maximum(plain[name], 0.01 * full / area)
        assert float((apart <= stated).where(same, True).mean()) > 0.99
        assert float((apart / stated).where(same).max()) < 10.0
