"""The drive of Eqs. 1 and 2: a cosine, its velocity and its acceleration."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.differences import slope_of

from stickslip.model import drive
from stickslip.parameters import Parameters

PAPER = Parameters()
phases = st.floats(0.0, 20.0)


@given(phase=phases, amplitude=st.sampled_from([0.8e-6, -3e-7]))
def test_the_drive_is_a_cosine(phase: float, amplitude: float) -> None:
    p = PAPER._replace(drive_amplitude=amplitude)
    X = drive.upper_displacement(p, phase / 10.0)
    assert pytest.approx(amplitude * math.cos(phase), abs=1e-14 * abs(amplitude)) == X


@pytest.mark.parametrize(
    ("function", "derivative"),
    [
        (drive.upper_displacement, drive.upper_velocity),
        (drive.upper_velocity, drive.upper_acceleration),
    ],
    ids=["velocity", "acceleration"],
)
@given(phase=phases)
def test_velocity_and_acceleration_are_derivatives(function, derivative, phase: float) -> None:
    t, step = phase / 10.0, 1e-4
    difference = slope_of(lambda t: function(PAPER, t), t, step)
    largest = derivative(PAPER, 0.0) or derivative(PAPER, 0.25 * drive.period(PAPER))
    assert derivative(PAPER, t) == pytest.approx(difference, abs=1e-10 * abs(largest))


def test_an_even_harmonic_is_refused() -> None:
    with pytest.raises(ValueError, match="tone 2 of the drive: an even harmonic breaks"):
        drive.tone(2, drive.TONES[0].amplitude)


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
