"""The values of an axis, in each of its forms."""

from __future__ import annotations

import pytest

from sweeps.config.load import from_mapping, from_yaml


@pytest.mark.parametrize(
    ("axis", "values"),
    [
        ("[3, 1, 2]", (3, 1, 2)),
        ("[-1/2, 1/2]", (-0.5, 0.5)),
        ("{linspace: [0, 1], num: 5}", (0, 0.25, 0.5, 0.75, 1)),
        ("{linspace: [0, 1], num: 11}", (0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1)),
        ("{linspace: [1, 0], num: 2}", (1, 0)),
        ("{num: 2, linspace: [0, 1/2]}", (0, 0.5)),
        ("{linspace: [7, 9], num: 1}", (7,)),
        ("{arange: [0, 1, 0.25]}", (0, 0.25, 0.5, 0.75, 1)),
        ("{arange: [0, 0.9, 0.25]}", (0, 0.25, 0.5, 0.75)),
        ("{arange: [1, 0, -0.5]}", (1, 0.5, 0)),
        ("{arange: [2, 2, 1]}", (2,)),
    ],
)
def test_forms_of_an_axis(axis: str, values: tuple[float, ...]) -> None:
    assert from_yaml(f"sweep: {{x_0: {axis}}}").sweep["initial_displacement"] == values


def test_a_long_list_is_kept_whole() -> None:
    values = [float(number) for number in range(1, 2501)]
    assert from_mapping({"sweep": {"T": values}}).sweep["temperature"] == tuple(values)


def test_geomspace_takes_values_not_exponents() -> None:
    values = from_yaml("sweep: {k: {geomspace: [1e4, 1e6], num: 3}}").sweep
    assert values["viscosity_coefficient"] == pytest.approx((1e4, 1e5, 1e6), rel=1e-12)
    assert (values["viscosity_coefficient"][0], values["viscosity_coefficient"][-1]) == (1e4, 1e6)


def test_arange_includes_a_stop_that_rounding_would_lose() -> None:
    values = from_yaml("sweep: {T: {arange: [0, 0.3, 0.1]}}").sweep["temperature"]
    assert len(values) == 4
    assert values[-1] == 0.3  # 3 * 0.1 is 0.30000000000000004
    short = from_yaml("sweep: {T: {arange: [0, 0.3000001, 0.1]}}").sweep["temperature"]
    assert short == (0.0, 0.1, 0.2, 0.3)  # the floats that these decimals are


@pytest.mark.parametrize(
    ("coarse", "fine"),
    [
        ("linspace: [0, 1], num: 11", "linspace: [0, 5], num: 501"),
        ("linspace: [0.1, 0.7], num: 7", "arange: [0, 1, 0.05]"),
        ("linspace: [150, 320], num: 8", "linspace: [150, 320], num: 15"),
        ("geomspace: [1e4, 3e6], num: 7", "geomspace: [1e4, 3e6], num: 19"),
        ("geomspace: [1e-3, 7], num: 4", "geomspace: [1e-3, 7], num: 10"),
    ],
)
def test_a_refined_axis_has_the_same_floats_as_the_coarse_one(coarse: str, fine: str) -> None:
    few, many = (
        from_yaml(f"sweep: {{x_0: {{{axis}}}}}").sweep["initial_displacement"]
        for axis in (coarse, fine)
    )
    assert set(few) < set(many)
