"""Weights of errors of ln(phi), and the steps that a passage of the strain allows."""

from __future__ import annotations

import math

import pytest

from stickslip import Parameters
from stickslip.model import noise, solids
from stickslip.model.weights import film_weight, passage_limits

PAPER = Parameters()
CRITICAL = solids.solidification_strain(PAPER)
LEVEL = math.log(noise.level(PAPER))
GROWTH = 4 / 3 * 100.0 * 1.9 * 90.0 * CRITICAL  # in a passage, times the rate of the strain


def crossing(times: float, rate: float) -> tuple[float, float]:
    """The limits of a step from `times` critical strains above zero to as many below."""
    h = 2 * times * CRITICAL / rate
    return passage_limits(PAPER, True, (times * CRITICAL, -rate), (-times * CRITICAL, -rate), h)


def test_a_step_over_a_passage_is_cut_to_its_edge() -> None:
    rate = GROWTH / 30  # 30 e-folds
    part, _ = crossing(10.0, rate)
    landed = 10.0 - part * 20.0
    assert 1.0 < landed < 2.0
    assert crossing(0.4, rate)[0] == 1.0  # resolved already


def test_a_passage_without_growth_is_not_resolved() -> None:
    assert crossing(10.0, 1.01 * GROWTH)[0] == 1.0
    assert crossing(10.0, 0.99 * GROWTH)[0] < 1.0


def test_neither_a_solid_nor_a_film_above_the_critical_temperature_is_slowed_down() -> None:
    rate = GROWTH / 30
    ends, h = ((10 * CRITICAL, -rate), (-10 * CRITICAL, -rate)), 20 * CRITICAL / rate
    assert passage_limits(PAPER, True, *ends, h)[0] < 1.0
    assert passage_limits(PAPER, False, *ends, h) == (1.0, math.inf)
    hot = PAPER._replace(temperature=290.0)
    assert passage_limits(hot, True, *ends, h) == (1.0, math.inf)


def test_a_strain_that_dips_to_zero_inside_a_step_is_seen() -> None:
    # Both ends three critical strains away, on the same side: the parabola between touches zero.
    h = 1.0
    rate = 4 * 3 * CRITICAL / h
    part, _ = passage_limits(PAPER, True, (3 * CRITICAL, -rate), (3 * CRITICAL, rate), h)
    assert part < 1.0
    part, _ = passage_limits(PAPER, True, (3 * CRITICAL, -rate / 9), (3 * CRITICAL, rate / 9), h)
    assert part == 1.0


def test_the_next_step_ends_at_the_passage_ahead() -> None:
    rate = GROWTH / 30
    far = (10 * CRITICAL, -rate)
    _, ahead = passage_limits(PAPER, True, far, far, 1e-9)
    assert 8 * CRITICAL / rate <= ahead <= 9 * CRITICAL / rate
    away = (10 * CRITICAL, rate)
    assert passage_limits(PAPER, True, away, away, 1e-9)[1] == math.inf


@pytest.mark.parametrize("times", [0.0, 0.9, -0.9])
def test_errors_of_a_film_that_may_freeze_count_in_full(times: float) -> None:
    far, near = 3 * CRITICAL, times * CRITICAL
    relieved = film_weight(PAPER, 1e-9, LEVEL, far, far)
    full = 1 / (1 + abs(LEVEL))
    assert relieved < 0.1 * full
    for ends in ((far, near), (near, far), (-far, near)):
        assert film_weight(PAPER, 1e-9, LEVEL, *ends) == pytest.approx(full)


def test_no_error_of_more_than_half_an_e_fold_is_accepted() -> None:
    far = 3 * CRITICAL
    for rtol in (1e-6, 1e-4, 1e-2):
        assert 0.5 * film_weight(PAPER, rtol, LEVEL, far, far) >= rtol * (1 - 1e-12)
