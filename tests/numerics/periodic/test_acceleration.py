"""Jumps towards the limit save time, are undone if they fail, and never reach a wrong limit."""

from __future__ import annotations

import math

import numpy as np
import pytest
from support.maps import LIMIT, START, TOL, Map, State, find, linear, new_memory, pitchfork

from stickslip.numerics.periodic import acceleration, ratios, search
from stickslip.numerics.periodic.convergence import LONGEST_CYCLE, UNKNOWN

NOISE = 1e-9


def after(S: Map, applications: int, z: State = START, per_period: int = 2):
    """The memory of a search after some applications, without a verdict."""
    memory = new_memory(z, per_period)
    for n in range(1, applications + 1):
        z = S(z, 0.0)
        memory["states"][n], memory["newest"] = z, n
        ratios.note_ratios(memory, NOISE)
    return memory


def on_its_way(film: float = 0.1, w: float = LIMIT[2]):
    """The memory of a search along a line to the limit, with a constant ratio."""
    return after(linear(-0.9, fast=0.0, film=film), 4, (0.9, 0.04, w))


def newest(memory) -> np.ndarray:
    return memory["states"][memory["newest"]]


# --- ratios --------------------------------------------------------------------------------------


@pytest.mark.parametrize("ratio", [-0.97, -0.5, 0.5, 0.9])
def test_the_ratio_of_a_cycle_is_a_power_of_the_ratio_of_one_application(ratio: float) -> None:
    memory = after(linear(ratio, fast=0.0), 12)
    for cycle in range(1, 6):
        assert memory["ratios"][cycle - 1] == pytest.approx(ratio**cycle, rel=1e-3)
    looked_at = memory["ratios"][: memory["longest_cycle"]]
    assert np.all(looked_at[6:] == UNKNOWN)  # too few displacements


def test_a_growth_is_measured_too() -> None:
    assert after(linear(-1.2, fast=0.0), 4)["ratios"][0] == pytest.approx(-1.2, rel=1e-9)


def test_a_ratio_that_noise_could_have_made_is_not_noted() -> None:
    still = START[0] + 1e-8, START[1], START[2]
    memory = new_memory()
    for n, z in enumerate((START, still, START), 0):
        memory["states"][n] = z
    memory["newest"] = 2
    ratios.note_ratios(memory, 1e-6)
    assert np.all(memory["ratios"][: memory["longest_cycle"]] == UNKNOWN)
    assert len(memory["ratios"]) == LONGEST_CYCLE


# --- a jump --------------------------------------------------------------------------------------


@pytest.mark.parametrize("ratio", [-0.97, -0.5, 0.6, 0.9])
def test_the_first_jump_stops_a_hundredth_short_of_the_limit(ratio: float) -> None:
    memory = after(linear(ratio, fast=0.0), 4, (0.9, 0.04, LIMIT[2]))
    way = acceleration.jump(memory, TOL, NOISE)
    assert way == pytest.approx(0.99 * (LIMIT - newest(memory))[:2], rel=1e-6)
    assert (memory["jumps"], memory["aim"]) == (1, 1)
    np.testing.assert_array_equal(memory["stored"], newest(memory))


def test_a_later_jump_goes_all_the_way() -> None:
    memory = on_its_way()
    memory["jumps"] = 1
    way = acceleration.jump(memory, TOL, NOISE)
    assert way == pytest.approx((LIMIT - newest(memory))[:2], rel=1e-6)


def test_a_jump_goes_half_the_way_while_the_film_still_changes() -> None:
    memory = on_its_way(film=0.95, w=0.5)
    way = acceleration.jump(memory, TOL, NOISE)
    assert way == pytest.approx(0.5 * (LIMIT - newest(memory))[:2], rel=1e-6)


def test_no_jump_skips_an_application_in_which_the_film_rises() -> None:
    memory = after(linear(-0.6, fast=0.0), 4, (0.9, 0.04, LIMIT[2]))
    memory["peaks"][:5] = 0.0, 0.0, 0.0, 0.0, 0.01
    assert acceleration.jump(memory, TOL, NOISE) == (0.0, 0.0)
    memory["peaks"][:5] = 0.01
    assert acceleration.jump(memory, TOL, NOISE) != (0.0, 0.0)


def test_a_jump_is_no_longer_than_is_allowed() -> None:
    memory = on_its_way()
    search.limit_jumps(memory, 0.01, False)
    way, left = np.array(acceleration.jump(memory, TOL, NOISE)), (LIMIT - newest(memory))[:2]
    assert np.abs(way).max() == pytest.approx(0.01)
    assert way / 0.01 == pytest.approx(left / np.abs(left).max(), rel=1e-6)
    assert memory["longest_jump"] > np.abs(left).max() - 0.01  # the rest of the way comes next


@pytest.mark.parametrize(
    ("film", "w", "longest"), [(0.1, LIMIT[2], 0.0), (0.95, 0.5, 10.0)], ids=["none", "limited"]
)
def test_there_is_no_jump_if_forbidden_or_if_limited_while_the_film_still_changes(
    film: float, w: float, longest: float
) -> None:
    memory = on_its_way(film, w)
    search.limit_jumps(memory, longest, False)
    assert acceleration.jump(memory, TOL, NOISE) == (0.0, 0.0)


def turning(z: State, noise: float) -> State:
    """A spiral: no displacement is parallel to the one before."""
    x, v = z[0] - LIMIT[0], z[1] - LIMIT[1]
    c, s = 0.9 * math.cos(1.0), 0.9 * math.sin(1.0)
    return LIMIT[0] + c * x - s * v, LIMIT[1] + s * x + c * v, LIMIT[2]


def zigzag(z: State, noise: float) -> State:
    """One ratio along x and its opposite along v: displacements shrink evenly, not along a line."""
    x, v = z[0] - LIMIT[0], z[1] - LIMIT[1]
    return LIMIT[0] + 0.8 * x, LIMIT[1] - 0.8 * v, LIMIT[2]


@pytest.mark.parametrize(
    ("S", "applications"),
    [
        (turning, 6),  # no steady ratio
        (zigzag, 4),  # not along a line
        (linear(-0.05, fast=0.0), 4),  # fast enough
        (linear(0.995, fast=0.0), 4),  # an extrapolation too far
        (linear(-1.1, fast=0.0), 4),  # it grows
        (linear(-0.9, fast=0.0), 2),  # too few displacements
    ],
    ids=["turning", "zigzag", "fast", "slow", "growing", "short"],
)
def test_there_is_no_jump_without_a_clear_limit(S: Map, applications: int) -> None:
    memory = after(S, applications, (0.9, 0.04, LIMIT[2]))
    assert acceleration.jump(memory, TOL, NOISE) == (0.0, 0.0)
    assert memory["jumps"] == 0


def test_a_jump_shorter_than_the_tolerance_is_not_worth_it() -> None:
    memory = on_its_way()
    assert acceleration.jump(memory, 10.0, NOISE) == (0.0, 0.0)


def test_a_jump_has_failed_if_the_next_displacement_is_no_shorter() -> None:
    for moved, failed in ((0.1, False), (0.9, True), (math.nan, True)):
        memory = on_its_way()
        shift = abs(memory["states"][4, 0] - memory["states"][3, 0])
        acceleration.jump(memory, TOL, NOISE)
        memory["newest"] = memory["aim"]
        memory["states"][0] = newest(memory) - [moved * shift, 0.0, 0.0]
        assert acceleration.jump_failed(memory, NOISE) == failed


@pytest.mark.parametrize(("film", "outran"), [(0.0005, False), (0.002, True), (math.nan, True)])
def test_a_jump_outran_the_film_if_the_film_changes_after_it(film: float, outran: bool) -> None:
    memory = on_its_way()
    acceleration.jump(memory, TOL, NOISE)
    memory["newest"] = memory["aim"]
    memory["states"][0] = memory["states"][1] - [0.0, 0.0, film]
    assert acceleration.jump_outran(memory) == outran


def test_after_a_jump_that_outran_the_film_the_next_one_is_half_as_long() -> None:
    memory = on_its_way()
    memory["stride"] = 0.01
    way = acceleration.jump(memory, TOL, NOISE)
    assert np.abs(way).max() == pytest.approx(0.01)
    memory["newest"] = memory["aim"] - 1
    film = tuple(memory["states"][0] + [0.0, 0.0, 0.1])
    assert search.judge(memory, film, TOL, NOISE, 1000)[0] == search.RESTORE
    assert memory["stride"] == pytest.approx(0.005)


@pytest.mark.parametrize(("aim", "judged"), [(3, True), (5, False)])
def test_a_jump_is_judged_before_the_next_one(aim: int, judged: bool) -> None:
    S, z = linear(-0.9, fast=0.0), (0.9, 0.04, LIMIT[2])
    memory = after(S, 3, z)
    memory["jumps"], memory["aim"], memory["residue"] = 1, aim, np.inf
    verdict = search.judge(memory, S(tuple(newest(memory)), 0.0), TOL, NOISE, 1000)[0]
    assert (verdict != search.GO_ON) == judged


def test_the_ratio_between_two_landings_is_stored() -> None:
    memory = on_its_way()
    acceleration.jump(memory, TOL, NOISE)
    memory["ratios"][0] = UNKNOWN
    S, z = linear(-0.7, fast=0.0), (0.31, -0.196, LIMIT[2])
    memory["landing"], memory["image"] = (0.9, 0.04), S((0.9, 0.04, 0.0), 0.0)[:2]
    memory["states"][0], memory["states"][1], memory["newest"] = z, S(z, 0.0), 1
    acceleration.compare_landing(memory, NOISE)
    assert memory["ratios"][0] == pytest.approx(-0.7, rel=1e-9)


def test_a_sequence_nearly_repeats_if_a_hundred_tolerances_remain() -> None:
    far, near = (after(linear(-0.9, fast=0.0), count) for count in (20, 160))
    assert not acceleration.nearly_repeats(far, 20, TOL)
    assert acceleration.nearly_repeats(near, 160, TOL)
    near["ratios"][:] = UNKNOWN
    assert not acceleration.nearly_repeats(near, 160, TOL)


# --- jumps in a search ---------------------------------------------------------------------------


@pytest.mark.parametrize(("ratio", "most"), [(-0.998, 20), (-0.99, 20), (-0.9, 20), (0.8, 40)])
def test_jumps_save_most_of_the_way(ratio: float, most: int) -> None:
    plain, quick = find(linear(ratio), accelerate=False), find(linear(ratio))
    assert quick.applications <= most
    assert quick.applications < 0.7 * plain.applications
    assert quick.count(search.RESTORE) == 0


def test_ratios_near_1_are_left_to_plain_iteration() -> None:
    plain, quick = find(linear(0.995), accelerate=False), find(linear(0.995))
    assert quick.count(search.JUMP) == 0
    assert quick.applications <= plain.applications


def test_a_long_jump_is_not_risked() -> None:
    near, far = linear(0.8), linear(0.8)
    assert search.JUMP in find(near, (1.0, 0.0, 0.0)).verdicts[:5]
    assert search.JUMP not in find(far, (100.0, 0.0, 0.0)).verdicts[:5]


@pytest.mark.parametrize("film", [0.9, 0.97, -0.97])
def test_jumps_do_not_change_the_limit_of_a_slow_film(film: float) -> None:
    start = (0.9, -0.3, 0.5)
    plain, quick = (find(linear(-0.9, film=film), start, a) for a in (False, True))
    assert quick.cycle == plain.cycle == 1
    assert quick.z[:2] == pytest.approx(LIMIT[:2], abs=1.01 * TOL)
    assert quick.applications <= 1.1 * plain.applications + 10


X_AND_V_ALONE = pytest.mark.xfail(reason="only the contraction of x and v is measured", strict=True)


@pytest.mark.parametrize("film", [pytest.param(0.9, marks=X_AND_V_ALONE), 0.97])
def test_a_slow_film_reaches_its_own_limit_too(film: float) -> None:
    found = find(linear(-0.9, film=film), (0.9, -0.3, 0.5))
    assert found.z[2] == pytest.approx(LIMIT[2], abs=2 * TOL)


@pytest.mark.parametrize("growth", [1.02, 1.05, 1.1, 1.2, 1.4])
@pytest.mark.parametrize("x", [1.0, -1.0, 0.6, -0.3, 0.02])
def test_jumps_towards_an_unstable_symmetric_orbit_are_undone(growth: float, x: float) -> None:
    plain, quick = (find(pitchfork(growth), (x, 0.0, 0.0), a) for a in (False, True))
    arm = math.copysign(math.sqrt(growth - 1), x)
    assert plain.z[0] == pytest.approx(arm, abs=3 * TOL)
    assert quick.cycle == plain.cycle == 2
    assert quick.z == pytest.approx(plain.z, abs=3 * TOL)


def test_there_are_jumps_to_be_undone() -> None:
    found = [find(pitchfork(growth), (1.0, 0.0, 0.0)) for growth in (1.02, 1.05, 1.1)]
    assert sum(one.count(search.RESTORE) for one in found) > 0
    assert sum(one.count(search.JUMP) + one.count(search.FINER) for one in found) > 0


def test_a_jump_across_a_border_of_basins_is_not_taken() -> None:
    # Slow along the start's side, with another attractor behind the limit of the slow motion.
    def S(z: State, noise: float) -> State:
        x, v, w = z
        rate = 0.95 if x > 0.5 else 0.4
        limit = 0.4 if x > 0.5 else 0.1
        return limit + rate * (x - limit), 0.02 * v, w

    plain, quick = (find(S, (1.2, 0.0, 0.0), a) for a in (False, True))
    assert quick.z == pytest.approx(plain.z, abs=3 * TOL)
