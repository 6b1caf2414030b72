"""Settling as a matter of maps: what is found, how fast, and that jumps never change the answer.

A map S stands for half a drive period with the signs turned; no drive is needed to judge it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pytest

from stickslip.numerics.periodic import search as settling

TOL = 1e-6
State = tuple[float, float, float]
Map = Callable[[State, float], State]

START: State = (0.9, -0.3, 0.02)
LIMIT = np.array([0.3, -0.2, 0.005])


class Search(NamedTuple):
    z: np.ndarray
    verdict: int
    cycle: int
    ratio: float
    halves: int
    verdicts: list[int]
    raw: State

    def count(self, verdict: int) -> int:
        return self.verdicts.count(verdict)


def search(
    S: Map, z: State = START, accelerate: bool = True, rtol: float = 1e-6, budget: int = 20_000
) -> Search:
    """The search of a drive, without a drive."""
    memory = np.zeros(settling.MEMORY)
    settling.start(memory, z, accelerate, True)
    noise, verdicts = rtol, []
    while True:
        z = S(z, noise)
        verdict, dx, dv = settling.judge(memory, z, TOL, noise, budget)
        verdicts.append(verdict)
        z = z[0] + dx, z[1] + dv, z[2]
        if verdict == settling.FINER:
            noise *= 0.1
        elif verdict == settling.RESTORE:
            z, noise = settling.stored(memory), rtol
        elif verdict == settling.EXHAUSTED:
            return Search(np.array(z), verdict, 0, math.nan, len(verdicts), verdicts, z)
        elif verdict == settling.SETTLED:
            (cycle, ratio), (dx, dv) = settling.found(memory), settling.last_correction(memory)
            end = np.array([z[0] + dx, z[1] + dv, z[2]])
            return Search(end, verdict, cycle, ratio, len(verdicts), verdicts, z)


def linear(slow: float, fast: float = 0.05, film: float = 0.1) -> Map:
    """To LIMIT, slowly along (1, 0.4), fast across it; the film on its own."""

    def S(z: State, noise: float) -> State:
        x, v, w = np.array(z) - LIMIT
        along, across = slow * x, fast * (v - 0.4 * x)
        return LIMIT[0] + along, LIMIT[1] + 0.4 * along + across, LIMIT[2] + film * w

    return S


# --- linear maps ---------------------------------------------------------------------------------

RATIOS = [-0.998, -0.99, -0.96, -0.9, -0.5, -0.1, 0.0, 0.1, 0.5, 0.8, 0.95, 0.99, 0.995]


@pytest.mark.parametrize("accelerate", [False, True])
@pytest.mark.parametrize("ratio", RATIOS)
def test_a_linear_map_is_followed_to_its_limit(ratio: float, accelerate: bool) -> None:
    found = search(linear(ratio), accelerate=accelerate)
    assert (found.verdict, found.cycle) == (settling.SETTLED, 1)
    assert np.abs(np.array(found.raw) - LIMIT).max() <= 1.01 * TOL
    assert abs(found.ratio) < 1.0
    if accelerate:  # with the last correction
        assert np.abs(found.z - LIMIT).max() <= 0.1 * TOL


@pytest.mark.parametrize(("ratio", "most"), [(-0.998, 20), (-0.99, 20), (-0.9, 20), (0.8, 40)])
def test_jumps_save_most_of_the_way(ratio: float, most: int) -> None:
    plain, quick = search(linear(ratio), accelerate=False), search(linear(ratio))
    assert quick.halves <= most
    assert quick.halves < 0.7 * plain.halves
    assert quick.count(settling.RESTORE) == 0


def test_ratios_near_1_are_left_to_plain_iteration() -> None:
    plain, quick = search(linear(0.995), accelerate=False), search(linear(0.995))
    assert quick.count(settling.JUMP) == 0
    assert quick.halves <= plain.halves


@pytest.mark.parametrize("ratio", RATIOS)
def test_without_acceleration_nothing_is_added(ratio: float) -> None:
    S, found = linear(ratio), search(linear(ratio), accelerate=False)
    assert set(found.verdicts) <= {settling.GO_ON, settling.FINER, settling.SETTLED}
    z: State = START
    for _ in range(found.halves):
        z = S(z, 0.0)
    assert found.raw == z


def test_a_long_jump_is_not_risked() -> None:
    near, far = linear(0.8), linear(0.8)
    assert settling.JUMP in search(near, (1.0, 0.0, 0.0)).verdicts[:5]
    assert settling.JUMP not in search(far, (100.0, 0.0, 0.0)).verdicts[:5]


@pytest.mark.parametrize("film", [0.9, 0.97, -0.97])
def test_where_the_film_is_the_slow_part_the_limit_is_the_same(film: float) -> None:
    start = (0.9, -0.3, 0.5)
    plain, quick = (search(linear(-0.9, film=film), start, a) for a in (False, True))
    assert quick.cycle == plain.cycle == 1
    assert quick.z[:2] == pytest.approx(LIMIT[:2], abs=1.01 * TOL)
    assert quick.halves <= 1.1 * plain.halves + 10


@pytest.mark.xfail(reason="only the contraction of x and v is measured", strict=True)
@pytest.mark.parametrize("film", [0.9, 0.97])
def test_where_the_film_is_the_slow_part_it_comes_to_its_limit_too(film: float) -> None:
    found = search(linear(-0.9, film=film), (0.9, -0.3, 0.5))
    assert found.z[2] == pytest.approx(LIMIT[2], abs=2 * TOL)


def test_a_spiral_is_followed_to_its_limit() -> None:
    turn = 0.95 * np.array([[math.cos(0.5), -math.sin(0.5)], [math.sin(0.5), math.cos(0.5)]])

    def S(z: State, noise: float) -> State:
        x, v = LIMIT[:2] + turn @ (np.array(z[:2]) - LIMIT[:2])
        return x, v, LIMIT[2]

    for accelerate in (False, True):
        found = search(S, accelerate=accelerate)
        assert (found.verdict, found.cycle) == (settling.SETTLED, 1)
        assert found.z == pytest.approx(LIMIT, abs=10 * TOL)


# --- cycles --------------------------------------------------------------------------------------


def cyclic(length: int, ratio: float) -> tuple[Map, np.ndarray]:
    """A map with an attracting cycle of points far apart."""
    angles = 2 * np.pi * np.arange(length) / length
    points = 0.5 * np.array([np.cos(angles), np.sin(angles), 0.1 * np.cos(angles)]).T

    def S(z: State, noise: float) -> State:
        nearest = int(np.argmin(np.linalg.norm(points[:, :2] - np.array(z[:2]), axis=1)))
        x, v, w = points[(nearest + 1) % length] + ratio * (np.array(z) - points[nearest])
        return float(x), float(v), float(w)

    return S, points


@pytest.mark.parametrize("accelerate", [False, True])
@pytest.mark.parametrize("ratio", [0.3, 0.9, -0.9])
@pytest.mark.parametrize("length", [1, 2, 3, 4, 5, 6, 8, 12, 16])
def test_a_cycle_is_found_at_its_length(length: int, ratio: float, accelerate: bool) -> None:
    S, points = cyclic(length, ratio)
    start = points[0] + [0.02, -0.03, 0.001]
    found = search(S, tuple(start.tolist()), accelerate)
    assert (found.verdict, found.cycle) == (settling.SETTLED, length)
    assert np.abs(points - found.z).max(axis=1).min() <= 1.01 * TOL
    if length % 2 == 0:
        # An orbit that is not symmetric is handed over as itself, not as its mirror image.
        assert np.abs(points[::2] - found.z).max(axis=1).min() <= 1.01 * TOL


def test_a_cycle_of_17_is_not_recognised() -> None:
    S, points = cyclic(17, 0.3)
    found = search(S, tuple(points[0].tolist()), budget=1500)
    assert (found.verdict, found.halves) == (settling.EXHAUSTED, 1500)


# --- maps on which jumps must be undone ----------------------------------------------------------


def pitchfork(growth: float) -> Map:
    """The symmetric orbit x = 0 repels by -growth; from outside it seems to be the limit."""

    def S(z: State, noise: float) -> State:
        x, v, _ = z
        return -x * (growth - x * x), -0.5 * x + 0.02 * (v + 0.5 * x), 1e-4 * x * x

    return S


@pytest.mark.parametrize("growth", [1.02, 1.05, 1.1, 1.2, 1.4])
@pytest.mark.parametrize("x", [1.0, -1.0, 0.6, -0.3, 0.02])
def test_jumps_towards_an_unstable_symmetric_orbit_are_undone(growth: float, x: float) -> None:
    plain, quick = (search(pitchfork(growth), (x, 0.0, 0.0), a) for a in (False, True))
    arm = math.copysign(math.sqrt(growth - 1), x)
    assert plain.z[0] == pytest.approx(arm, abs=3 * TOL)
    assert quick.cycle == plain.cycle == 2
    assert quick.z == pytest.approx(plain.z, abs=3 * TOL)


def test_there_are_jumps_to_be_undone() -> None:
    found = [search(pitchfork(growth), (1.0, 0.0, 0.0)) for growth in (1.02, 1.05, 1.1)]
    assert sum(one.count(settling.RESTORE) for one in found) > 0
    assert sum(one.count(settling.JUMP) + one.count(settling.FINER) for one in found) > 0


def test_a_jump_across_a_border_of_basins_is_not_taken() -> None:
    # Slow along the start's side, with another attractor behind the limit of the slow motion.
    def S(z: State, noise: float) -> State:
        x, v, w = z
        rate = 0.95 if x > 0.5 else 0.4
        limit = 0.4 if x > 0.5 else 0.1
        return limit + rate * (x - limit), 0.02 * v, w

    plain, quick = (search(S, (1.2, 0.0, 0.0), a) for a in (False, True))
    assert quick.z == pytest.approx(plain.z, abs=3 * TOL)


# --- noise ---------------------------------------------------------------------------------------


def noisy(S: Map, level: float, seed: int) -> Map:
    """With noise of so many tolerances of the integrator in x and v."""
    rng = np.random.default_rng(seed)

    def with_noise(z: State, noise: float) -> State:
        x, v, w = S(z, noise)
        dx, dv = level * noise * rng.uniform(-1.0, 1.0, 2)
        return x + dx, v + dv, w

    return with_noise


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("ratio", [-0.99, -0.96, -0.5, 0.0, 0.5, 0.9])
@pytest.mark.parametrize("level", [0.1, 1.0])
def test_noise_neither_hides_nor_fakes_the_limit(ratio: float, level: float, seed: int) -> None:
    found = search(noisy(linear(ratio), level, seed), budget=4000)
    assert (found.verdict, found.cycle) == (settling.SETTLED, 1)
    # The tolerance, and the noise that a slow map adds up, at a tenth of the first tolerance.
    assert np.abs(found.z - LIMIT)[:2].max() <= 3 * TOL + 0.1 * level * 1e-6 / (1 - abs(ratio))


def test_a_map_whose_noise_keeps_it_from_settling_gets_finer_tolerances() -> None:
    found = search(noisy(linear(0.6), 60.0, 1), accelerate=False, budget=4000)
    assert found.verdict == settling.SETTLED
    assert 2 <= found.count(settling.FINER) <= 3
    assert found.z[:2] == pytest.approx(LIMIT[:2], abs=3 * TOL)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("growth", [1.05, 1.1, 1.3])
@pytest.mark.parametrize("x", [1.0, -0.7])
def test_noise_on_an_unstable_symmetric_orbit_does_not_decide_between_the_arms(
    growth: float, x: float, seed: int
) -> None:
    found = search(noisy(pitchfork(growth), 10.0, seed), (x, 0.0, 0.0), budget=4000)
    assert found.cycle == 2
    arm = math.copysign(math.sqrt(growth - 1), x)
    assert found.z[0] == pytest.approx(arm, abs=1e-4)


def test_noise_that_does_not_fall_with_the_tolerance_is_not_pursued_for_ever() -> None:
    rng = np.random.default_rng(2)

    def S(z: State, noise: float) -> State:
        dx, dv = 20 * TOL * rng.uniform(-1.0, 1.0, 2)
        x, v, w = linear(0.6)(z, noise)
        return x + dx, v + dv, w

    found = search(S, accelerate=False, budget=2000)
    assert (found.verdict, found.count(settling.FINER)) == (settling.EXHAUSTED, 3)


def test_the_tolerance_is_cut_three_times_at_most() -> None:
    found = search(noisy(linear(0.6), 1e5, 1), budget=2000)
    assert found.verdict == settling.EXHAUSTED
    assert found.count(settling.FINER) <= 3 * (1 + found.count(settling.RESTORE))


# --- budgets and failures ------------------------------------------------------------------------


@pytest.mark.parametrize("budget", [1, 2, 3, 7, 50])
def test_the_budget_is_kept(budget: int) -> None:
    found = search(linear(0.999), budget=budget)
    assert (found.verdict, found.halves) == (settling.EXHAUSTED, budget)


def test_a_verdict_counts_only_when_it_is_repeated() -> None:
    found = search(linear(0.0, fast=0.0, film=0.0))
    assert 5 <= found.halves <= 10


@pytest.mark.parametrize("bad", [math.nan, math.inf])
@pytest.mark.parametrize("component", range(3))
def test_a_state_that_is_not_finite_never_settles(component: int, bad: float) -> None:
    def S(z: State, noise: float) -> State:
        state = list(linear(-0.9)(z, noise))
        state[component] = bad
        return tuple(state)  # type: ignore[return-value]

    for accelerate in (False, True):
        found = search(S, budget=100, accelerate=accelerate)
        assert found.verdict == settling.EXHAUSTED
        assert found.count(settling.JUMP) == 0 or component == 2


def test_a_growing_sequence_never_settles() -> None:
    found = search(linear(1.01), (LIMIT[0] + 1e-6, LIMIT[1], LIMIT[2]), budget=3000)
    assert found.verdict == settling.EXHAUSTED


def test_a_drift_never_settles() -> None:
    def S(z: State, noise: float) -> State:
        return z[0] + 0.5 * TOL, z[1], z[2]

    for accelerate in (False, True):
        assert search(S, budget=1000, accelerate=accelerate).verdict == settling.EXHAUSTED


def test_memories_do_not_remember_an_earlier_search() -> None:
    memory, other = np.zeros(settling.MEMORY), np.full(settling.MEMORY, 7.0)
    for row in (memory, other):
        settling.start(row, START, True, True)
    S, z = linear(-0.97), START
    for _ in range(12):
        z = S(z, 1e-6)
        verdicts = [settling.judge(row, z, TOL, 1e-6, 100) for row in (memory, other)]
        assert verdicts[0] == verdicts[1]
        z = z[0] + verdicts[0][1], z[1] + verdicts[0][2], z[2]
