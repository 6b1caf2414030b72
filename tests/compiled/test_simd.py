"""The loop over lanes visits every lane once, with vector instructions."""

import numpy as np
import pytest

from stickslip.compiled.decorators import inline, jit
from stickslip.compiled.simd import LANES, VECTOR, for_lanes


@inline
def body(lane: int, x: np.ndarray, y: np.ndarray) -> None:
    value = x[lane]
    y[lane] += value * value + 1.0 if value > 0.0 else value


@jit
def loop(count: int, x: np.ndarray, y: np.ndarray) -> None:
    for_lanes(count, body, (x, y))


@pytest.mark.parametrize("times", [1, 2, 5])
def test_every_lane_is_visited_once_and_nothing_else(times: int) -> None:
    count = times * LANES
    x, y = np.random.default_rng(0).normal(size=count + 3), np.zeros(count + 3)
    loop(count, x, y)
    np.testing.assert_allclose(y[:count], np.where(x > 0, x * x + 1.0, x)[:count], rtol=1e-15)
    assert np.all(y[count:] == 0.0)


def test_the_loop_is_compiled_to_vectors_two_at_a_time() -> None:
    assert LANES == 2 * VECTOR
    loop(LANES, np.zeros(LANES), np.zeros(LANES))
    (text,) = loop.alone.inspect_llvm().values()
    assert text.count(f"load <{VECTOR} x double>") >= 4  # x and y, two vectors of each
