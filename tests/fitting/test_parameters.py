"""Free parameters: scales, bounds, and parameters that cannot be free."""

from __future__ import annotations

import math

import pytest

from stickslip.distributions import Normal
from stickslip.parameters import Parameters
from sweeps.fitting.parameters import FreeError, free_parameters, priors_of

START = Parameters()


def test_scales_and_bounds() -> None:
    k, gamma, x_0, amplitude = free_parameters(
        ["k", "gamma", "x_0", "X_m"], START._replace(drive_amplitude=-1e-6), []
    )
    assert k.form == amplitude.form == "logarithmic"
    assert float(k.value(k.start)) == pytest.approx(5e4)
    assert float(amplitude.value(amplitude.start)) == pytest.approx(-1e-6)
    assert k.slope(k.start) == pytest.approx(5e4)
    assert gamma.form == "plain"
    assert gamma.lower > -1.0  # which is no valid value
    assert x_0.unit == 1e-6
    for free in (k, gamma, x_0, amplitude):
        assert free.lower <= free.box[0] < free.start < free.box[1] <= free.upper
        assert free.is_valid(free.lower)
        assert free.is_valid(free.upper)
    assert not gamma.is_valid(-1.0)


def test_trials_stay_in_a_given_range() -> None:
    k, phi = free_parameters({"k": (1e5, 1e6), "phi_0": (0.0, 2.0)}, START, [])
    assert k.box == pytest.approx((math.log(1e5), math.log(1e6)))
    assert (k.lower, k.upper) == k.box
    assert k.lower < k.start < k.upper  # 5e4 is out of it
    assert phi.start == 0.0


@pytest.mark.parametrize("start", [-0.5, 0.5, 4.9])
def test_a_wide_range_on_a_plain_scale_is_not_cut(start: float) -> None:
    fixed = START._replace(rheological_index=start)
    gamma, x_0 = free_parameters({"gamma": (0.0, 5.0), "x_0": (-8e-6, 8e-6)}, fixed, [])
    assert (gamma.lower, gamma.upper) == gamma.box == (0.0, 5.0)
    assert gamma.lower < gamma.start < gamma.upper
    assert x_0.box == pytest.approx((-10.0, 10.0))  # in units of X_m


def test_a_unit_of_0_is_refused() -> None:
    with pytest.raises(FreeError, match="in units of quartic_coefficient, which must not be 0"):
        free_parameters("d", START._replace(quartic_coefficient=0.0, sextic_coefficient=850.0), [])


@pytest.mark.parametrize(
    ("free", "columns", "message"),
    [
        ("gama", [], "did you mean 'gamma'?"),
        ("T", ["temperature"], "temperature is free and also a column of the data"),
        (["k", "viscosity_coefficient"], [], "is listed twice"),
        ([], [], "no parameter is free"),
        ("d", [], None),
        ({"k": (1e5, 1e4)}, [], "must rise"),
        ({"k": [1e4]}, [], "must be (lowest, highest), not [10000.0]"),
        ({"k": 1e4}, [], "must be (lowest, highest), not 10000.0"),
        ({"T": (0.0, 300.0)}, [], "must not contain 0"),
        ({"gamma": (-1.0, 0.0)}, [], "the range of rheological_index: must be greater than -1"),
    ],
)
def test_parameters_that_cannot_be_free(
    free: object, columns: list[str], message: str | None
) -> None:
    if message is None:
        assert free_parameters(free, START, columns)
        return
    with pytest.raises(FreeError) as raised:
        free_parameters(free, START, columns)
    assert message in str(raised.value)


def test_priors_may_be_fractions_as_in_configs() -> None:
    (free,) = free_parameters("gamma", START, [])
    prior = priors_of({"gamma": {"normal": ["-2/3", 0.1]}}, [free])["rheological_index"]
    assert isinstance(prior, Normal)
    assert prior.middle == -2 / 3
    with pytest.raises(FreeError, match="the prior of rheological_index: must be a number"):
        priors_of({"gamma": {"normal": ["about 1", 0.1]}}, [free])


def test_a_logarithm_needs_a_start() -> None:
    with pytest.raises(FreeError, match="starts at 0"):
        free_parameters("D", START._replace(noise_intensity=0.0), [])
