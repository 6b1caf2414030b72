"""The search for the orbit: its result and speed, and that jumps never change the result."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable

import numpy as np
import pytest
from support import maps
from support.maps import LIMIT, START, TOL, State, cyclic, linear, new_memory, noisy, pitchfork

from stickslip.numerics.periodic import search

Find = Callable[..., maps.Search]


@pytest.fixture(params=[1, 2], ids=["maps of a period", "maps of half a period"])
def per_period(request: pytest.FixtureRequest) -> int:
    return request.param


@pytest.fixture
def find(per_period: int) -> Find:
    return functools.partial(maps.find, per_period=per_period)


# --- linear maps ---------------------------------------------------------------------------------


RATIOS = [-0.998, -0.99, -0.96, -0.9, -0.5, -0.1, 0.0, 0.1, 0.5, 0.8, 0.95, 0.99, 0.995]


@pytest.mark.parametrize("accelerate", [False, True])
@pytest.mark.parametrize("ratio", RATIOS)
def test_a_linear_map_is_followed_to_its_limit(find: Find, ratio: float, accelerate: bool) -> None:
    found = find(linear(ratio), accelerate=accelerate)
    assert (found.verdict, found.cycle) == (search.SETTLED, 1)
    assert np.abs(np.array(found.raw) - LIMIT).max() <= 1.01 * TOL
    assert abs(found.ratio) < 1.0
    if accelerate:  # with the last correction
        assert np.abs(found.z - LIMIT).max() <= 0.1 * TOL


@pytest.mark.parametrize("film", [0.1, 0.9])
@pytest.mark.parametrize("ratio", [*RATIOS, 0.986, 0.999])
def test_without_jumps_the_search_never_ends_further_from_the_limit_than_the_tolerance(
    find: Find, ratio: float, film: float
) -> None:
    found = find(linear(ratio, film=film), accelerate=False, refinable=False)
    assert (found.verdict, found.cycle) == (search.SETTLED, 1)
    assert np.abs(np.array(found.raw) - LIMIT).max() <= 1.01 * TOL
    assert set(found.verdicts) == {search.GO_ON, search.SETTLED}


@pytest.mark.parametrize("ratio", RATIOS)
def test_without_acceleration_nothing_is_added(find: Find, ratio: float) -> None:
    S, found = linear(ratio), find(linear(ratio), accelerate=False)
    assert set(found.verdicts) <= {search.GO_ON, search.FINER, search.SETTLED}
    z: State = START
    for _ in range(found.applications):
        z = S(z, 0.0)
    assert found.raw == z


def test_a_spiral_is_followed_to_its_limit(find: Find) -> None:
    for accelerate in (False, True):
        found = find(spiral(0.95, 0.5, 1.0), accelerate=accelerate)
        assert (found.verdict, found.cycle) == (search.SETTLED, 1)
        assert found.z == pytest.approx(LIMIT, abs=10 * TOL)


def spiral(ratio: float, angle: float, thickness: float) -> Callable[[State, float], State]:
    """A map that turns about the limit on ellipses: displacements grow and shrink in turn."""
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    shape = np.diag([1.0, thickness])
    A = ratio * shape @ turn @ np.linalg.inv(shape)

    def S(z: State, noise: float) -> State:
        x, v = LIMIT[:2] + A @ (np.array(z[:2]) - LIMIT[:2])
        return x, v, LIMIT[2]

    return S


@pytest.mark.parametrize("thickness", [1.0, 0.2])
@pytest.mark.parametrize("angle", [0.1, 0.52, 1.03, 2.2, 3.0])
@pytest.mark.parametrize("ratio", [0.99, 0.996, 0.999])
def test_a_slow_spiral_does_not_wander(
    find: Find, ratio: float, angle: float, thickness: float
) -> None:
    found = find(spiral(ratio, angle, thickness), budget=3000)
    assert found.verdict in (search.SETTLED, search.EXHAUSTED)


# --- cycles --------------------------------------------------------------------------------------


@pytest.mark.parametrize("accelerate", [False, True])
@pytest.mark.parametrize("ratio", [0.3, 0.9, -0.9])
@pytest.mark.parametrize("length", [1, 2, 3, 4, 5, 6, 8, 12, 16])
def test_a_cycle_is_found_at_its_length(
    find: Find, per_period: int, length: int, ratio: float, accelerate: bool
) -> None:
    if length > search.LONGEST_CYCLE_IN_PERIODS * per_period:
        return  # see below
    S, points = cyclic(length, ratio)
    start = points[0] + [0.02, -0.03, 0.001]
    found = find(S, tuple(start.tolist()), accelerate)
    assert (found.verdict, found.cycle) == (search.SETTLED, length)
    assert np.abs(points - found.z).max(axis=1).min() <= 1.01 * TOL
    if length % 2 == 0 and per_period == 2:
        # An orbit that is not symmetric is found itself, not its mirror image.
        assert np.abs(points[::2] - found.z).max(axis=1).min() <= 1.01 * TOL


@pytest.mark.parametrize("length", [2, 3, 5, 8])
def test_without_jumps_a_cycle_takes_few_turns(find: Find, length: int) -> None:
    S, points = cyclic(length, 0.1)
    start = tuple((points[0] + [0.02, -0.03, 0.001]).tolist())
    found = find(S, start, accelerate=False, refinable=False)
    assert found.cycle == length
    assert found.applications <= 12 * length


@pytest.mark.parametrize("length", [9, 20, 32])
def test_long_cycles_are_recognised(find: Find, per_period: int, length: int) -> None:
    S, points = cyclic(length * per_period, 0.3)
    found = find(S, tuple(points[0].tolist()), accelerate=False)
    assert (found.verdict, found.cycle) == (search.SETTLED, length * per_period)


@pytest.mark.parametrize("length", [33, 64, 100, 128])
def test_a_late_search_recognises_cycles_of_up_to_128_periods(
    find: Find, per_period: int, length: int
) -> None:
    S, points = cyclic(length * per_period, 0.3)
    found = find(S, tuple(points[0].tolist()), late=True)
    assert (found.verdict, found.cycle) == (search.SETTLED, length * per_period)
    assert found.applications <= 4 * length * per_period


def test_a_late_search_has_a_verdict_on_longer_cycles_too(find: Find, per_period: int) -> None:
    S, points = cyclic(129 * per_period, 0.3)
    found = find(S, tuple(points[0].tolist()), late=True)
    assert found.verdict == search.WANDERING
    assert found.applications <= 600 * per_period


@pytest.mark.parametrize("contracting", [False, True])
@pytest.mark.parametrize(
    ("angle", "contraction", "steps"),
    [(0.7, 1e-7, 80), (math.pi, 1e-9, 12)],
    ids=["a spiral", "an alternation"],
)
def test_a_contraction_below_the_noise_is_followed_if_it_is_known(
    per_period: int, angle: float, contraction: float, steps: int, contracting: bool
) -> None:
    # The noise of 1e-6 hides such a small contraction.
    memory, z = new_memory(START, per_period), np.array(START)
    c, s = math.cos(angle), math.sin(angle)
    turn = (1.0 - contraction) * np.array([[c, s], [-s, c]])
    for _ in range(steps):
        z[:2] = LIMIT[:2] + turn @ (z[:2] - LIMIT[:2])
        search.limit_jumps(memory, np.inf, contracting)
        _verdict, dx, dv = search.judge(memory, tuple(z.tolist()), TOL, 1e-6, 2000)
        z[:2] += dx, dv
    away = np.abs(z[:2] - LIMIT[:2]).max()
    assert away < 1e-4 if contracting else away > 0.1


@pytest.mark.parametrize("every", [6, 20])
def test_a_film_that_freezes_now_and_then_is_on_no_spiral(per_period: int, every: int) -> None:
    memory, z = new_memory(START, per_period), np.array(START)
    turn = 0.89 * np.array([[np.cos(0.7), np.sin(0.7)], [-np.sin(0.7), np.cos(0.7)]])
    for step in range(200):
        z[:2] = START[:2] if step % every == 0 else LIMIT[:2] + turn @ (z[:2] - LIMIT[:2])
        search.limit_jumps(memory, np.inf, True)
        verdict, dx, dv = search.judge(memory, tuple(z.tolist()), TOL, 1e-6, 2000)
        assert (dx, dv) == (0.0, 0.0)
        if verdict == search.SETTLED:
            break
    assert verdict == search.SETTLED
    assert search.found(memory)[0] == every


def test_a_cycle_of_more_than_thirty_two_periods_wanders(find: Find, per_period: int) -> None:
    S, points = cyclic(32 * per_period + 1, 0.3, seed=1)
    found = find(S, tuple(points[0].tolist()), budget=1500)
    assert found.verdict == search.WANDERING
    assert 128 * per_period <= found.applications <= 3 * 128 * per_period


@pytest.mark.parametrize("seed", range(5))
def test_chaos_wanders(find: Find, per_period: int, seed: int) -> None:
    def logistic(z: State, noise: float) -> State:
        return 3.9 * z[0] * (1.0 - z[0]), z[0], 0.0

    start = (0.1 + 0.15 * seed, 0.0, 0.0)
    found = find(logistic, start, budget=2000)
    assert found.verdict == search.WANDERING
    assert found.applications <= 3 * 128 * per_period


@pytest.mark.parametrize(
    ("ratio", "level"),
    [
        *((ratio, 0.0) for ratio in (0.99, -0.99, 0.999, 0.9999, 0.99999)),
        *((ratio, 1.0) for ratio in (0.99, -0.99, 0.999)),
    ],
)
def test_a_slow_approach_does_not_wander(find: Find, ratio: float, level: float) -> None:
    # It continues to the budget and is not taken for another motion.
    found = find(noisy(linear(ratio), level, 5), accelerate=False, budget=3000)
    assert found.verdict in (search.SETTLED, search.EXHAUSTED)


def test_a_sequence_that_alternates_forever_is_a_cycle_of_two(find: Find) -> None:
    found = find(linear(-1.0), accelerate=False, budget=100)
    assert (found.verdict, found.cycle) == (search.SETTLED, 2)


# --- noise ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("ratio", [-0.99, -0.96, -0.5, 0.0, 0.5, 0.9])
@pytest.mark.parametrize("level", [0.1, 1.0])
def test_noise_neither_hides_nor_fakes_the_limit(
    find: Find, ratio: float, level: float, seed: int
) -> None:
    found = find(noisy(linear(ratio), level, seed), budget=4000)
    assert (found.verdict, found.cycle) == (search.SETTLED, 1)
    # The tolerance, and the accumulated noise of a slow map at a tenth of the first tolerance.
    assert np.abs(found.z - LIMIT)[:2].max() <= 3 * TOL + 0.1 * level * 1e-6 / (1 - abs(ratio))


def test_a_map_whose_noise_keeps_it_from_settling_gets_finer_tolerances(find: Find) -> None:
    found = find(noisy(linear(0.6), 60.0, 1), accelerate=False, budget=4000)
    assert found.verdict == search.SETTLED
    assert 2 <= found.count(search.FINER) <= 3
    assert found.z[:2] == pytest.approx(LIMIT[:2], abs=3 * TOL)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("growth", [1.05, 1.1, 1.3])
@pytest.mark.parametrize("x", [1.0, -0.7])
def test_noise_on_an_unstable_symmetric_orbit_does_not_decide_between_the_arms(
    growth: float, x: float, seed: int
) -> None:
    found = maps.find(noisy(pitchfork(growth), 10.0, seed), (x, 0.0, 0.0), budget=4000)
    assert found.cycle == 2
    arm = math.copysign(math.sqrt(growth - 1), x)
    assert found.z[0] == pytest.approx(arm, abs=1e-4)


def test_noise_that_does_not_fall_with_the_tolerance_ends_the_search(
    find: Find,
) -> None:
    rng = np.random.default_rng(2)

    def S(z: State, noise: float) -> State:
        dx, dv = 20 * TOL * rng.uniform(-1.0, 1.0, 2)
        x, v, w = linear(0.6)(z, noise)
        return x + dx, v + dv, w

    found = find(S, accelerate=False, budget=2000)
    assert (found.verdict, found.count(search.FINER)) == (search.WANDERING, 3)


def test_the_tolerance_is_reduced_no_more_than_three_times(find: Find) -> None:
    found = find(noisy(linear(0.6), 1e5, 1), budget=2000)
    assert found.verdict == search.WANDERING  # so much noise looks like chaos
    assert found.count(search.FINER) <= 3 * (1 + found.count(search.RESTORE))


def test_a_map_without_a_tolerance_is_never_asked_for_a_finer_one(find: Find) -> None:
    found = find(noisy(linear(0.6), 60.0, 1), accelerate=False, refinable=False, budget=500)
    assert found.verdict == search.WANDERING  # it neither closes nor comes nearer
    assert found.count(search.FINER) == 0


# --- budgets and failures ------------------------------------------------------------------------


@pytest.mark.parametrize("budget", [1, 2, 3, 7, 50])
def test_the_budget_is_kept(find: Find, budget: int) -> None:
    found = find(linear(0.999), budget=budget)
    assert (found.verdict, found.applications) == (search.EXHAUSTED, budget)


def test_a_verdict_counts_only_when_it_holds_over_two_periods(find: Find, per_period: int) -> None:
    at_once = linear(0.0, fast=0.0, film=0.0)
    plain = find(at_once, accelerate=False, refinable=False)
    assert plain.applications == 1 + 2 * per_period  # the first moves, the others repeat
    assert plain.applications <= find(at_once).applications <= 5 * per_period


@pytest.mark.parametrize("bad", [math.nan, math.inf])
@pytest.mark.parametrize("component", range(3))
def test_a_state_that_is_not_finite_never_settles(find: Find, component: int, bad: float) -> None:
    def S(z: State, noise: float) -> State:
        state = list(linear(-0.9)(z, noise))
        state[component] = bad
        return tuple(state)  # type: ignore[return-value]

    for accelerate in (False, True):
        found = find(S, budget=100, accelerate=accelerate)
        assert found.verdict == search.EXHAUSTED
        assert found.count(search.JUMP) == 0 or component == 2


def test_a_growing_sequence_never_settles(find: Find) -> None:
    found = find(linear(1.01), (LIMIT[0] + 1e-6, LIMIT[1], LIMIT[2]), budget=3000)
    assert found.verdict == search.WANDERING


def test_a_drift_never_settles(find: Find) -> None:
    def S(z: State, noise: float) -> State:
        return z[0] + 0.5 * TOL, z[1], z[2]

    for accelerate in (False, True):
        assert find(S, budget=1000, accelerate=accelerate).verdict == search.WANDERING


# --- the memory ----------------------------------------------------------------------------------


def test_memories_do_not_remember_an_earlier_search(per_period: int) -> None:
    memory, other = (new_memory(START, per_period, filled_with=byte) for byte in (0, 7))
    S, z = linear(-0.97), START
    for _ in range(12):
        z = S(z, 1e-6)
        verdicts = [search.judge(one, z, TOL, 1e-6, 100) for one in (memory, other)]
        assert verdicts[0] == verdicts[1]
        z = z[0] + verdicts[0][1], z[1] + verdicts[0][2], z[2]


def test_parallel_searches_do_not_affect_each_other(per_period: int) -> None:
    memories = np.zeros(3, search.memory_of(3))
    for memory in memories:
        search.start(memory, START, per_period, True, True, False)
    before = memories[[0, 2]].tobytes()
    for _ in range(20):
        search.judge(memories[1], (0.1, 0.2, 0.3), TOL, 1e-6, 100)
    assert memories[[0, 2]].tobytes() == before


def test_the_memory_counts_applications_and_turns_of_the_mirror(per_period: int) -> None:
    memory = new_memory(START, per_period)
    for count in range(1, 8):
        search.judge(memory, START, TOL, 1e-6, 100)
        assert memory["applications"] == count
        assert memory["mirrored"] == (count % 2 if per_period == 2 else 0)


def test_an_asymmetric_orbit_settles_as_itself_and_not_as_its_mirror_image() -> None:
    S, points = cyclic(2, 0.3)
    for begin in (0, 1):
        found = maps.find(S, tuple(points[begin].tolist()))
        assert found.applications % 2 == 0
        np.testing.assert_allclose(found.z, points[begin], atol=TOL)
