"""The drive of Eqs. 1 and 2: a sum of cosines, their velocity and their acceleration."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.differences import slope_of

from stickslip.model import drive
from stickslip.options import COSINE, HARMONICS
from stickslip.parameters import Parameters

PAPER = Parameters()
WITH_HARMONICS = Parameters(third_harmonic=-0.3, fifth_harmonic=0.2)
POINTS = pytest.mark.parametrize("p", [PAPER, WITH_HARMONICS], ids=["paper", "harmonics"])
phases = st.floats(0.0, 20.0)


@POINTS
@given(phase=phases, amplitude=st.sampled_from([0.8e-6, -3e-7]))
def test_the_drive_is_a_sum_of_cosines(p: Parameters, phase: float, amplitude: float) -> None:
    p = p._replace(drive_amplitude=amplitude)
    X = math.cos(phase) + p.third_harmonic * math.cos(3 * phase)
    X += p.fifth_harmonic * math.cos(5 * phase)
    found = drive.upper_displacement(p, phase / 10.0)
    assert found == pytest.approx(amplitude * X, abs=1e-13 * abs(amplitude))


@pytest.mark.parametrize(
    ("function", "derivative"),
    [
        (drive.upper_displacement, drive.upper_velocity),
        (drive.upper_velocity, drive.upper_acceleration),
    ],
    ids=["velocity", "acceleration"],
)
@POINTS
@given(phase=phases)
def test_velocity_and_acceleration_are_derivatives(
    function, derivative, p: Parameters, phase: float
) -> None:
    t, step = phase / 10.0, 1e-4
    difference = slope_of(lambda t: function(p, t), t, step)
    largest = derivative(PAPER, 0.0) or derivative(PAPER, 0.25 * drive.period(PAPER))
    assert derivative(p, t) == pytest.approx(difference, abs=1e-7 * abs(largest))


def test_a_single_tone_equals_the_sum_of_all_tones_without_harmonics() -> None:
    for one, every in zip(drive.UPPER[COSINE], drive.UPPER[HARMONICS], strict=True):
        assert one(PAPER, 0.03) == every(PAPER, 0.03)
        assert one(WITH_HARMONICS, 0.03) != every(WITH_HARMONICS, 0.03)


def test_an_even_harmonic_is_refused() -> None:
    with pytest.raises(ValueError, match="tone 2 of the drive: an even harmonic breaks"):
        drive.tone(2, "third_harmonic")


def test_the_drive_does_not_exceed_its_largest_values() -> None:
    for largest, function in (
        (drive.largest_displacement, drive.upper_displacement),
        (drive.largest_speed, drive.upper_velocity),
        (drive.largest_acceleration, drive.upper_acceleration),
    ):
        times = [i / 400 * drive.period(PAPER) for i in range(400)]
        sizes = [abs(function(PAPER, t)) for t in times]
        assert max(sizes) == pytest.approx(largest(PAPER), rel=1e-4)
        assert max(sizes) <= largest(PAPER) * (1 + 1e-15)


def test_bounds_are_sums_over_the_tones() -> None:
    p, unit = WITH_HARMONICS, PAPER.drive_amplitude
    assert drive.largest_displacement(p) == pytest.approx(1.5 * unit)
    assert drive.half_way(p) == pytest.approx(2.9 * unit)
    assert drive.largest_speed(p) == pytest.approx(2.9 * 10 * unit)
    assert drive.acceleration_speed(p) == pytest.approx((1 + 2.7 + 5) * 10 * unit)
    assert drive.largest_acceleration(p) == pytest.approx((1 + 2.7 + 5) * 100 * unit)
    assert [drive.highest_harmonic(q) for q in (PAPER, p, p._replace(fifth_harmonic=0))] == [
        1.0, 5.0, 3.0
    ]  # fmt: skip
    heavy = p._replace(spring_stiffness=100.0)  # inertia counts from the third harmonic on
    assert drive.full_force(heavy) == pytest.approx((200 + 0.3 * 360 + 0.2 * 1000) * unit)
    points = np.array([PAPER, p, heavy])
    each = [drive.full_force(q) for q in (PAPER, p, heavy)]
    assert drive.full_forces(points) == pytest.approx(each, rel=1e-15)


def test_a_period_later_the_drive_is_where_it_was() -> None:
    T = drive.period(PAPER)
    assert pytest.approx(2 * math.pi / 10.0, rel=1e-15, abs=0) == T
    for t in (0.0, 0.1, 0.4):
        assert drive.upper_velocity(PAPER, t + T) == pytest.approx(
            drive.upper_velocity(PAPER, t), abs=1e-19
        )


@pytest.mark.parametrize("t", [0.0, 0.03, 0.4])
def test_compiled_and_plain_python_agree(t: float) -> None:
    for function in (drive.upper_displacement, drive.upper_velocity, drive.upper_acceleration):
        assert function(PAPER, t) == pytest.approx(function.py_func(PAPER, t), rel=1e-15, abs=0)
