"""The ensembles of stochastic films agree with independent computations."""

from typing import Any

import numpy as np
import pytest
from support.marks import one_then
from support.points import MISSED_STICKS, orbits, row

from stickslip import Parameters, Status, simulate
from stickslip.kernels.adaptive import driver
from stickslip.kernels.streams import streams_of
from stickslip.measure.accumulate import STRESS_MAX
from stickslip.options import Options


def ensemble(point: np.ndarray, **options: Any) -> Any:
    return orbits(point[None], noise="stochastic", **options)


def largest_stresses(point: np.ndarray, options: Options, periods: int) -> np.ndarray:
    """Return the largest elastic stress [Pa] of single periods, (periods, realizations)."""
    paths = options.realizations
    walk = driver.stochastic_walk(
        np.repeat(point[None], paths, axis=0),
        np.repeat(orbits(point[None]).final, paths, axis=0),
        streams_of(point[None], options),
        options,
    )
    return np.array([walk.next_period()[:, STRESS_MAX] for _ in range(periods + 5)])[5:]


@pytest.mark.stress
def test_an_independent_euler_maruyama_run_agrees() -> None:
    # benchmarks/shared/euler_maruyama.py at commit e5f42fa, over 130 drive periods at 2 ns, gives a
    # mean of 1.7262 +- 0.0025 MPa (one standard error) and 0.0286 MPa from period to period.
    singles = largest_stresses(
        row(angular_frequency=15.0), Options(noise="stochastic", realizations=16), 20
    )
    mean, error = singles.mean(), singles.std() / np.sqrt(singles.size)
    assert error < 0.003e6
    assert abs(mean - 1.7262e6) < 3.0 * np.hypot(error, 0.0025e6)
    assert singles.std() == pytest.approx(0.0286e6, rel=0.25)


def test_noise_hardly_matters_if_the_film_freezes_at_each_stop() -> None:
    found = ensemble(row(), realizations=4, window=20)
    typical = orbits(row()[None])
    assert found.melting_count == 4 * 20 * 4
    stress = typical.elastic_stress_amplitude
    assert found.elastic_stress_amplitude_spread < 1e-7 * stress
    assert found.elastic_stress_amplitude == pytest.approx(stress, rel=1e-7)


@pytest.mark.stress
def test_both_methods_find_the_same_statistics() -> None:
    point = row(**MISSED_STICKS)
    adaptive = ensemble(point, realizations=200, window=20)
    fixed = ensemble(point, realizations=32, window=20, method="euler-cromer", dt=1.3e-8)
    assert adaptive.status == fixed.status == Status.OK
    for name in ("elastic_stress", "friction_force"):
        ours, theirs = (getattr(found, f"{name}_amplitude") for found in (adaptive, fixed))
        assert abs(theirs / ours - 1.0) < adaptive.amplitude_error + fixed.amplitude_error
        spreads = [getattr(found, f"{name}_amplitude_spread") for found in (adaptive, fixed)]
        assert spreads[1] == pytest.approx(spreads[0], rel=0.3)
    rates = [adaptive.melting_count / 200, fixed.melting_count / 32]
    assert rates[1] == pytest.approx(rates[0], rel=0.05)
    # Noise makes the film miss sticks, the typical path misses none.
    assert rates[0] < 0.99 * 2 * 20
    assert orbits(point[None]).melting_count == 2


def test_a_looser_tolerance_finds_the_same_statistics() -> None:
    point = row(**MISSED_STICKS)
    tight, loose = (ensemble(point, realizations=200, window=20, rtol=r) for r in (1e-6, 1e-3))
    difference = abs(loose.elastic_stress_amplitude / tight.elastic_stress_amplitude - 1.0)
    assert difference < loose.amplitude_error + tight.amplitude_error


@pytest.mark.parametrize(
    "options",
    one_then("stress", [{}, {"strain": "relaxing"}, {"method": "euler-cromer", "dt": 1e-7}]),
    ids=["adaptive", "relaxing", "euler-cromer"],
)
def test_a_liquid_film_fluctuates_like_its_linear_process(options: dict[str, Any]) -> None:
    # At rest above T_c this is an Ornstein-Uhlenbeck process of variance D/rate; strain adds to it.
    p = Parameters(
        temperature=400.0, drive_amplitude=1e-15, noise_intensity=1e-10, angular_frequency=2e3
    )
    ds = simulate(
        p, periods=20, noise="stochastic", realizations=20, samples_per_period=20, rtol=1e-4,
        **options,
    )  # fmt: skip
    rate = p.kinetic_coefficient * 2.0 * p.thermal_coefficient * (400.0 - 290.0)
    square = float((ds.order_parameter[:, 20:] ** 2).mean())
    count = ds.order_parameter[:, 20:].size
    assert square == pytest.approx(1e-10 / rate, rel=4.0 * np.sqrt(2.0 / count), abs=0.0)
