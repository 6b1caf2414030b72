"""Whether a sequence has reached its cycle: cycles of every length, slow convergence, noise."""

import math

import numpy as np
import pytest
from support.maps import TOL, new_memory

from stickslip.numerics.periodic.convergence import (
    REMEMBERED,
    SOONEST_CYCLE,
    UNKNOWN,
    closing_cycle,
    distance,
    reach,
    stalled,
)


class Judge:
    """Verdicts on sequences (n, 3), from the memory of a search without jumps."""

    def __init__(self, per_period: int) -> None:
        self._memory = new_memory((0.0, 0.0, 0.0), per_period, accelerate=False)
        self.longest_cycle = int(self._memory["longest_cycle"])

    def remembers(self, sequence: np.ndarray, newest: int):
        """The memory after application `newest`, without the oldest states."""
        states = self._memory["states"]
        known = np.arange(max(0, newest + 1 - REMEMBERED), newest + 1)
        states[:] = np.nan
        states[known % REMEMBERED] = sequence[known]
        return self._memory

    def closes(
        self, sequence: np.ndarray, newest: int | None = None, tolerance: float = TOL
    ) -> int:
        newest = len(sequence) - 1 if newest is None else newest
        return closing_cycle(self.remembers(sequence, newest), newest, tolerance)

    def first_verdict(self, sequence: np.ndarray) -> tuple[int, int]:
        """The application and the cycle of the first two equal verdicts in a row."""
        memory, previous = self.remembers(sequence, 0), 0
        for newest in range(1, len(sequence)):
            memory["states"][newest % REMEMBERED] = sequence[newest]
            cycle = closing_cycle(memory, newest, TOL)
            if cycle and cycle == previous:
                return newest, cycle
            previous = cycle
        return -1, 0


@pytest.fixture(scope="module", params=[1, 2], ids=["maps of a period", "maps of half a period"])
def judge(request: pytest.FixtureRequest) -> Judge:
    return Judge(request.param)


def geometric(ratio: float, length: int, direction=(1.0, 0.4, 0.1), limit=0.3) -> np.ndarray:
    """A sequence at the distance ratio^n from its limit."""
    return limit + ratio ** np.arange(length)[:, None] * np.array(direction)


# --- closing_cycle -------------------------------------------------------------------------------


def test_a_small_last_difference_of_a_slow_sequence_does_not_close_the_orbit(judge: Judge) -> None:
    sequence = geometric(0.986, 1400)
    newest = math.ceil(math.log(0.9 * TOL / (1 - 0.986)) / math.log(0.986)) + 1
    step = abs(sequence[newest] - sequence[newest - 1]).max()
    assert step < TOL
    assert abs(sequence[newest] - 0.3).max() > 50 * TOL
    assert judge.closes(sequence, newest) == 0


@pytest.mark.parametrize("ratio", [0.0, 0.1, 0.5, 0.9, 0.986, 0.99, 0.999])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_geometric_sequence_closes_within_the_tolerance_and_not_much_later(
    judge: Judge, ratio: float, sign: int
) -> None:
    length = 20_000 if ratio == 0.999 else 2000
    sequence = geometric(sign * ratio, length)
    newest, cycle = judge.first_verdict(sequence)
    left = abs(sequence[newest] - 0.3).max()
    assert cycle == 1
    assert left <= TOL * 1.01
    # Alternating differences overestimate the distance, lag 1 at most by 1/(1 - ratio).
    assert left >= 1e-3 * TOL * ratio**4


@pytest.mark.parametrize("cycle", range(1, SOONEST_CYCLE + 1))
@pytest.mark.parametrize("ratio", [0.0, 0.3, 0.8, 0.95])
def test_an_orbit_that_closes_after_n_applications_is_recognised_as_such(
    judge: Judge, cycle: int, ratio: float
) -> None:
    if cycle > judge.longest_cycle:
        return  # see the next test
    rng = np.random.default_rng(cycle)
    orbit = rng.normal(size=(cycle, 3))
    length = 1200
    sequence = orbit[np.arange(length) % cycle] + geometric(ratio, length, limit=0.0)
    newest, found = judge.first_verdict(sequence)
    assert found == cycle
    assert abs(sequence[newest] - orbit[newest % cycle]).max() <= TOL * 1.01


def test_a_cycle_beyond_the_longest_is_not_recognised(judge: Judge) -> None:
    cycle = judge.longest_cycle + 1
    orbit = np.random.default_rng(9).normal(size=(cycle, 3))
    assert judge.first_verdict(orbit[np.arange(1200) % cycle]) == (-1, 0)


@pytest.mark.parametrize("component", range(3))
def test_each_component_has_to_repeat(judge: Judge, component: int) -> None:
    sequence = np.full((60, 3), 0.3)
    sequence[:, component] += 0.1 * np.sqrt(np.arange(60))
    assert judge.closes(sequence) == 0


def test_a_cycle_with_indistinct_points_is_a_fixed_point(
    judge: Judge,
) -> None:
    sequence = np.zeros((100, 3))
    sequence[::2, 0] = 5 * TOL
    assert judge.closes(sequence) == 1
    sequence[::2, 0] = 50 * TOL
    assert judge.closes(sequence) == 2


@pytest.mark.parametrize("level", [0.0, 1e-5, 1e-4, 1e-3])
def test_a_sequence_at_its_noise_floor_closes(judge: Judge, level: float) -> None:
    rng = np.random.default_rng(3)
    sequence = 0.3 + level * TOL * rng.normal(size=(300, 3))
    newest, cycle = judge.first_verdict(sequence)
    assert cycle == 1
    assert newest <= 10


@pytest.mark.parametrize("ratio", [0.5, 0.9])
def test_weak_noise_does_not_close_a_sequence_much_too_early(judge: Judge, ratio: float) -> None:
    for seed in range(20):
        rng = np.random.default_rng(seed)
        clean = geometric(ratio, 400)
        noise = 1e-3 * TOL * rng.normal(size=clean.shape)
        newest, cycle = judge.first_verdict(clean + noise)
        assert cycle == 1
        assert abs(clean[newest] - 0.3).max() < 1.5 * TOL


@pytest.mark.parametrize(("ratio", "level"), [(0.99, 1e-2), (0.995, 1e-2)])
def test_noise_does_not_close_a_slow_sequence_much_too_early(
    judge: Judge, ratio: float, level: float
) -> None:
    clean = geometric(ratio, 4000)
    left = []
    for seed in range(3):
        noise = level * TOL * np.random.default_rng(seed).normal(size=clean.shape)
        newest, _ = judge.first_verdict(clean + noise)
        left.append(abs(clean[newest] - 0.3).max())
    assert max(left) < 3 * TOL


@pytest.mark.parametrize("slow", [(1e-3, 0.0, 0.0), (0.0, 0.0, 1e-3)])
def test_a_fast_transient_hides_no_slow_one_in_any_component(
    judge: Judge, slow: tuple[float, ...]
) -> None:
    sequence = geometric(0.3, 3000, (1.0, 0.5, 0.0)) + geometric(0.98, 3000, slow)
    newest, cycle = judge.first_verdict(sequence)
    assert cycle == 1
    assert abs(sequence[newest] - 0.6).max() <= TOL * 1.01


# --- the remaining distance ----------------------------------------------------------------------


@pytest.mark.parametrize("newest", [2, 5, 40, 150])
def test_the_remaining_distance_of_a_geometric_sequence_is_exact(judge: Judge, newest: int) -> None:
    sequence = geometric(0.9, 200)
    true = abs(sequence[newest] - 0.3).max()
    assert judge.closes(sequence, newest, 1.0001 * true) == 1
    assert judge.closes(sequence, newest, 0.9999 * true) == 0


def test_the_remaining_distance_of_a_growing_sequence_is_infinite(judge: Judge) -> None:
    sequence = geometric(1.1, 50)
    step = abs(sequence[12] - sequence[11]).max()
    assert judge.closes(sequence, 12, 100 * step) == 0


def test_a_measured_ratio_gives_the_remaining_distance(judge: Judge) -> None:
    sequence = geometric(0.9, 200)
    memory, true = judge.remembers(sequence, 100), abs(sequence[100] - 0.3).max()
    memory["plain"], memory["ratios"][:] = 0, 0.99  # says ten times as much as the sequence does
    assert closing_cycle(memory, 100, 2 * true) == 0
    assert closing_cycle(memory, 100, 12 * true) == 1
    memory["plain"] = 1  # without jumps the sequence alone counts
    assert closing_cycle(memory, 100, 2 * true) == 1
    memory["ratios"][:] = UNKNOWN


@pytest.mark.parametrize("ratio", [-0.9, -0.1, 0.1, 0.5, 0.99])
def test_the_reach_is_the_sum_of_all_displacements_to_come(ratio: float) -> None:
    assert reach(ratio) == pytest.approx(sum(ratio**n for n in range(1, 5000)), rel=1e-12)


def test_the_distance_is_the_largest_difference_and_nan_counts(judge: Judge) -> None:
    sequence = np.array([[1.0, 2.0, 3.0], [1.5, 1.0, 3.25], [1.0, math.nan, 3.0]])
    memory = judge.remembers(sequence, 2)
    assert distance(memory, 1, 0) == distance(memory, 0, 1) == 1.0
    assert math.isnan(distance(memory, 2, 0))


# --- a sequence that no longer approaches its limit ----------------------------------------------


def wandering(level: float, length: int = 400) -> np.ndarray:
    """Random jumps about the limit, by up to `level` tolerances."""
    return 0.3 + level * TOL * np.random.default_rng(5).uniform(-1.0, 1.0, (length, 3))


def stalls(judge: Judge, sequence: np.ndarray, newest: int) -> bool:
    return stalled(judge.remembers(sequence, newest), newest, TOL)


def test_a_sequence_that_wanders_near_its_limit_has_stalled(judge: Judge) -> None:
    assert any(stalls(judge, wandering(20.0), newest) for newest in range(300, 310))


def test_a_sequence_that_is_short_or_not_near_its_limit_has_not_stalled(judge: Judge) -> None:
    assert not any(stalls(judge, wandering(20.0), newest) for newest in range(1, 127))
    assert not any(stalls(judge, wandering(1e4), newest) for newest in range(300, 310))


@pytest.mark.parametrize("ratio", [0.9, 0.99])
def test_a_sequence_that_approaches_its_limit_has_not_stalled(judge: Judge, ratio: float) -> None:
    sequence = geometric(ratio, 1000)
    for newest in range(130, 1000, 7):
        moved = abs(sequence[newest] - sequence[newest - 64]).max()
        if moved > 1e-12:  # above the rounding, about which it wanders as well
            assert not stalls(judge, sequence, newest)
