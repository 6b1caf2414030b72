"""The lower block: its slopes and its loss agree with its force, for any force in the model."""

from __future__ import annotations

import numpy as np
import pytest
from support.parameters import random_parameters

from stickslip.model import block
from stickslip.parameters import Parameters


def drawn(seed: int) -> tuple[Parameters, float, float]:
    """Parameters, displacement [m] and velocity [m/s]."""
    rng = np.random.default_rng(seed)
    return random_parameters(rng, 0.0), rng.uniform(-1e-6, 1e-6), rng.uniform(-1e-5, 1e-5)


STATES = [drawn(seed) for seed in range(5)]


@pytest.mark.parametrize(("p", "x", "v"), STATES)
def test_the_slopes_are_those_of_the_force(p: Parameters, x: float, v: float) -> None:
    in_x = (block.own_force(p, x + 1e-7, v) - block.own_force(p, x - 1e-7, v)) / 2e-7
    in_v = (block.own_force(p, x, v + 1e-6) - block.own_force(p, x, v - 1e-6)) / 2e-6
    assert block.own_slopes(p, x, v) == pytest.approx((in_x, in_v), rel=1e-6, abs=1e-9)


@pytest.mark.parametrize(("p", "x", "v"), STATES)
def test_the_work_of_the_forces_is_stored_or_lost(p: Parameters, x: float, v: float) -> None:
    F, step = 1e-3, 1e-6
    a = block.acceleration(p, x, v, F)
    after = block.energy(p, x + step * v, v + step * a)
    before = block.energy(p, x - step * v, v - step * a)
    gained = (after - before) / (2 * step)
    assert gained == pytest.approx(F * v - block.own_loss(p, x, v), rel=1e-6, abs=1e-12)


@pytest.mark.parametrize(("p", "x", "v"), STATES)
def test_the_mirror_image_of_a_motion_feels_the_mirror_image(
    p: Parameters, x: float, v: float
) -> None:
    assert block.own_force(p, -x, -v) == -block.own_force(p, x, v)
    assert block.own_loss(p, -x, -v) == block.own_loss(p, x, v) >= 0.0
    assert block.energy(p, -x, -v) == block.energy(p, x, v)
