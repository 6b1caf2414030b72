"""Stationarity by plain iteration: cycles of every length, slow convergence, noise."""

import math
from typing import Any, NamedTuple

import numpy as np
import pytest
from stickslip.numerics.periodic.stationarity import (
    LONGEST_CYCLE,
    NOT_STATIONARY,
    closing_cycle,
    make_settle,
    remaining_distance,
)

from stickslip.compiled.decorators import inline
from stickslip.numerics.adaptive import DIVERGED, OK, STEP_LIMIT

TOL = 1e-6
RING = 257


def ring(sequence: np.ndarray, newest: int) -> np.ndarray:
    """The ring of remembered states after period `newest` of a sequence (n, 3)."""
    states = np.full((RING, 3), np.nan)
    for i in range(max(0, newest - RING + 1), newest + 1):
        states[i % RING] = sequence[i]
    return states


def closes(sequence: np.ndarray, newest: int | None = None, tolerance: float = TOL) -> int:
    newest = len(sequence) - 1 if newest is None else newest
    return closing_cycle(ring(sequence, newest), newest, tolerance)


def geometric(ratio: float, length: int, direction=(1.0, 0.4, 0.1), limit=0.3) -> np.ndarray:
    """A sequence at the distance ratio^n from its limit."""
    return limit + ratio ** np.arange(length)[:, None] * np.array(direction)


def first_verdict(sequence: np.ndarray) -> tuple[int, int]:
    """Period and cycle of the first two equal verdicts in a row."""
    previous = 0
    for newest in range(1, len(sequence)):
        cycle = closes(sequence, newest)
        if cycle and cycle == previous:
            return newest, cycle
        previous = cycle
    return -1, 0


# --- closing_cycle -------------------------------------------------------------------------------


def test_a_small_last_difference_of_a_slow_sequence_does_not_close_the_orbit() -> None:
    sequence = geometric(0.986, 1400)
    newest = math.ceil(math.log(0.9 * TOL / (1 - 0.986)) / math.log(0.986)) + 1
    step = abs(sequence[newest] - sequence[newest - 1]).max()
    assert step < TOL
    assert abs(sequence[newest] - 0.3).max() > 50 * TOL
    assert closes(sequence, newest) == 0


@pytest.mark.parametrize("ratio", [0.0, 0.1, 0.5, 0.9, 0.986, 0.99, 0.999])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_geometric_sequence_closes_within_the_tolerance_and_not_much_later(
    ratio: float, sign: int
) -> None:
    length = 20_000 if ratio == 0.999 else 2000
    sequence = geometric(sign * ratio, length)
    newest, cycle = first_verdict(sequence)
    left = abs(sequence[newest] - 0.3).max()
    assert cycle == 1
    assert left <= TOL * 1.01
    # Alternating differences overestimate the distance, lag 1 at most by 1/(1 - ratio).
    assert left >= 1e-3 * TOL * ratio**4


@pytest.mark.parametrize("cycle", range(1, LONGEST_CYCLE + 1))
@pytest.mark.parametrize("ratio", [0.0, 0.3, 0.8, 0.95])
def test_an_orbit_that_closes_after_n_periods_is_recognised_as_such(
    cycle: int, ratio: float
) -> None:
    rng = np.random.default_rng(cycle)
    orbit = rng.normal(size=(cycle, 3))
    length = 1200
    sequence = orbit[np.arange(length) % cycle] + geometric(ratio, length, limit=0.0)
    newest, found = first_verdict(sequence)
    assert found == cycle
    assert abs(sequence[newest] - orbit[newest % cycle]).max() <= TOL * 1.01


def test_an_orbit_that_closes_after_nine_periods_is_not_recognised() -> None:
    orbit = np.random.default_rng(9).normal(size=(9, 3))
    assert first_verdict(orbit[np.arange(600) % 9]) == (-1, 0)


@pytest.mark.parametrize("component", range(3))
def test_each_component_has_to_repeat(component: int) -> None:
    sequence = np.full((60, 3), 0.3)
    sequence[:, component] += 0.1 * np.sqrt(np.arange(60))
    assert closes(sequence) == 0


def test_a_divergent_sequence_never_closes() -> None:
    growing = 1e-9 * 1.02 ** np.arange(600)[:, None] * np.ones(3)
    after_noise = [closes(growing, newest) for newest in range(300, 600)]
    assert set(after_noise) == {0}


def test_a_drift_at_constant_speed_never_closes() -> None:
    sequence = 0.5 * TOL * np.arange(600)[:, None] * np.ones(3)
    assert {closes(sequence, newest) for newest in range(1, 600)} == {0}


def test_a_cycle_whose_points_differ_by_less_than_is_distinct_is_a_fixed_point() -> None:
    sequence = np.zeros((100, 3))
    sequence[::2, 0] = 5 * TOL
    assert closes(sequence) == 1
    sequence[::2, 0] = 50 * TOL
    assert closes(sequence) == 2


@pytest.mark.parametrize("level", [0.0, 1e-5, 1e-4, 1e-3])
def test_a_sequence_at_its_noise_floor_closes(level: float) -> None:
    rng = np.random.default_rng(3)
    sequence = 0.3 + level * TOL * rng.normal(size=(300, 3))
    newest, cycle = first_verdict(sequence)
    assert cycle == 1
    assert newest <= 10


def test_noise_above_the_tolerance_never_closes() -> None:
    sequence = 0.3 + 20 * TOL * np.random.default_rng(4).normal(size=(400, 3))
    assert first_verdict(sequence) == (-1, 0)


@pytest.mark.parametrize("ratio", [0.5, 0.9])
def test_weak_noise_does_not_close_a_sequence_much_too_early(ratio: float) -> None:
    for seed in range(20):
        rng = np.random.default_rng(seed)
        clean = geometric(ratio, 400)
        noise = 1e-3 * TOL * rng.normal(size=clean.shape)
        newest, cycle = first_verdict(clean + noise)
        assert cycle == 1
        assert abs(clean[newest] - 0.3).max() < 1.5 * TOL


@pytest.mark.parametrize(("ratio", "level"), [(0.99, 1e-2), (0.995, 1e-2)])
def test_noise_does_not_close_a_slow_sequence_much_too_early(ratio: float, level: float) -> None:
    clean = geometric(ratio, 4000)
    left = []
    for seed in range(3):
        noise = level * TOL * np.random.default_rng(seed).normal(size=clean.shape)
        newest, _ = first_verdict(clean + noise)
        left.append(abs(clean[newest] - 0.3).max())
    assert max(left) < 3 * TOL


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("component", [0, 1, 2])
def test_a_state_that_is_not_finite_never_closes(component: int, bad: float) -> None:
    sequence = np.full((50, 3), 0.3)
    assert closes(sequence) == 1
    sequence[-1, component] = bad
    assert closes(sequence) == 0
    sequence[:, component] = bad
    assert closes(sequence) == 0


def test_a_fast_transient_does_not_hide_a_slow_one() -> None:
    sequence = geometric(0.3, 3000, (1.0, 0.5, 0.0)) + geometric(0.98, 3000, (1e-3, 0.0, 0.0))
    newest, cycle = first_verdict(sequence)
    assert cycle == 1
    assert abs(sequence[newest] - 0.6).max() <= TOL * 1.01


def test_a_slow_transient_in_another_component_is_not_hidden() -> None:
    sequence = geometric(0.5, 3000, (1.0, 0.0, 0.0)) + geometric(0.98, 3000, (0.0, 0.0, 1e-3))
    newest, cycle = first_verdict(sequence)
    assert cycle == 1
    assert abs(sequence[newest] - 0.6).max() <= TOL * 1.01


def test_the_remaining_distance_of_a_geometric_sequence_is_exact_at_every_lag() -> None:
    sequence = geometric(0.9, 200)
    states = ring(sequence, 150)
    true = abs(sequence[150] - 0.3).max()
    for lag in (1, 2, 4, 8):
        assert remaining_distance(states, 150, lag) == pytest.approx(true, rel=1e-6)


def test_the_remaining_distance_of_a_growing_sequence_is_infinite() -> None:
    assert remaining_distance(ring(geometric(1.1, 50), 40), 40, 1) == math.inf


# --- settle --------------------------------------------------------------------------------------


class Map(NamedTuple):
    """A linear map of (x, v, w) to its limit, with a cycle on top and a period that fails."""

    slow: float = 0.9
    fast: float = 0.2
    film: float = 0.1
    cycle: float = 1.0
    fails_at: float = -1.0
    status: int = OK


class Settings(NamedTuple):
    stationary_rtol: float = TOL
    max_periods: int = 100_000


LIMIT_X, LIMIT_V, LIMIT_W = 0.3, -0.2, 0.05


@inline
def period_map(p, settings, y, memory, budget, record):
    # v contracts fast; the slow direction is (1, 0.5). `memory` counts the periods.
    x, v, w = y[0] - LIMIT_X, y[1] - LIMIT_V, y[2] - LIMIT_W
    phase = memory % p.cycle
    record[0] += 1.0
    if memory == p.fails_at:
        return y, memory, 3, p.status
    if budget < 3:
        return y, memory, budget, STEP_LIMIT
    along, rest = x, v - 0.5 * x
    x, rest, w = p.slow * along, p.fast * rest, p.film * w
    if p.cycle > 1.0:  # the state of a cycle carries its own place in it
        place = 0.01 if phase == 0.0 else (-0.01 / (p.cycle - 1.0))
        return (LIMIT_X + place * (1.0 + phase), LIMIT_V, LIMIT_W + w), memory + 1.0, 3, OK
    return (LIMIT_X + x, LIMIT_V + rest + 0.5 * x, LIMIT_W + w), memory + 1.0, 3, OK


@inline
def scaled(p, y):
    return y


compiled = make_settle(period_map, scaled)


class Search(NamedTuple):
    y: tuple[float, float, float]
    memory: float
    cycle: int
    periods: int
    steps: int
    status: int
    maps: int

    @property
    def distance(self) -> float:
        limit = (LIMIT_X, LIMIT_V, LIMIT_W)
        return max(abs(a - b) for a, b in zip(self.y, limit, strict=True))


def settle(p: Map, y=(0.45, 0.1, 0.3), budget=10**9, **settings: Any) -> Search:
    record = np.zeros(1)
    found = compiled(p, Settings(**settings), y, 0.0, budget, record)
    return Search(*found, maps=int(record[0]))


RATIOS = [0.0, 0.3, 0.6, 0.9, 0.986, 0.999]


@pytest.mark.parametrize("slow", RATIOS)
def test_the_search_never_ends_further_from_the_limit_than_the_tolerance(slow: float) -> None:
    for film in (0.1, 0.9):
        found = settle(Map(slow=slow, film=film))
        assert (found.status, found.cycle) == (OK, 1)
        assert found.distance <= TOL * 1.01
        assert found.maps == found.periods
        assert found.steps == 3 * found.periods


@pytest.mark.parametrize("cycle", [2, 3, 5, 8])
def test_the_search_finds_the_cycle(cycle: int) -> None:
    found = settle(Map(cycle=float(cycle)))
    assert (found.status, found.cycle) == (OK, cycle)
    assert found.periods <= 12 * cycle


def test_a_verdict_counts_only_when_it_is_repeated() -> None:
    found = settle(Map(slow=0.0, fast=0.0, film=0.0))
    assert found.periods == 3  # period 1 moves, 2 and 3 repeat


def test_a_search_that_takes_too_long_is_not_stationary() -> None:
    found = settle(Map(slow=0.9999), max_periods=20)
    assert (found.status, found.cycle, found.periods) == (NOT_STATIONARY, 0, 20)
    assert found.maps == 20


def test_a_map_that_never_repeats_is_not_stationary() -> None:
    found = settle(Map(slow=-1.0, cycle=1.0), max_periods=50)
    assert (found.status, found.cycle) == (OK, 2)
    found = settle(Map(slow=1.001), max_periods=50)
    assert (found.status, found.periods) == (NOT_STATIONARY, 50)


@pytest.mark.parametrize("status", [DIVERGED, STEP_LIMIT])
def test_a_period_that_fails_ends_the_search_with_its_status(status: int) -> None:
    found = settle(Map(fails_at=4.0, status=status))
    assert (found.status, found.cycle, found.periods) == (status, 0, 5)
    assert found.steps == 15


def test_the_budget_is_shared_by_the_periods() -> None:
    found = settle(Map(slow=0.99), budget=31)
    assert found.status == STEP_LIMIT
    assert found.steps == 31
    assert found.periods == 11


def test_a_state_that_is_not_finite_is_never_accepted() -> None:
    found = settle(Map(), y=(math.nan, 0.0, 0.0), max_periods=50)
    assert (found.status, found.cycle) == (NOT_STATIONARY, 0)
