"""What the page begins with: nothing, a config, a result."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from stickslip import Parameters
from stickslip.variables import PARAMETERS
from sweeps import run
from sweeps.config.load import from_mapping
from sweeps.page.controls import Scale
from sweeps.page.subject import subject_of_config, subject_of_paper, subject_of_result
from sweeps.points import PointError


def test_nothing_is_the_papers_point():
    subject = subject_of_paper()
    assert subject.first.point.parameters == Parameters()
    assert subject.first.label == "the paper's values"
    assert subject.result is None
    assert list(subject.scales) == list(PARAMETERS)


def test_a_config_gives_values_and_ranges():
    config = from_mapping(
        {
            "model": {"block_mass": 0.5},
            "sweep": {"temperature": [150, 200, 300]},
            "cases": {"drive_amplitude": [4e-7, 8e-7], "angular_frequency": [20, 10]},
            "integrator": {"rtol": 1e-8},
            "simulation": {"periods": 3},
        }
    )
    subject = subject_of_config(config, "a.yaml")
    expected = Parameters(
        block_mass=0.5, temperature=200, drive_amplitude=4e-7, angular_frequency=20
    )
    assert subject.first.point.parameters == expected
    assert subject.scales["temperature"] == Scale(150.0, 300.0)
    assert (subject.scales["drive_amplitude"].lower, subject.name) == (4e-7, "a.yaml")
    assert subject.first.config.integrator.rtol == 1e-8
    assert subject.first.point.simulate(samples_per_period=10).sizes["elapsed_time"] == 11


def test_a_schedule_is_left_out():
    config = from_mapping({"simulation": {"schedule": {"temperature": [200, 300]}}})
    subject = subject_of_config(config, "a.yaml")
    assert subject.first.config.simulation.schedule is None


def test_another_method_is_replaced_and_told():
    config = from_mapping({"integrator": {"method": "euler-cromer", "dt": 1e-9}})
    subject = subject_of_config(config, "a.yaml")
    assert subject.first.config.integrator.method == "adaptive"
    assert subject.notes == ("This page computes with the method adaptive, not with euler-cromer.",)


def test_a_result_opens_in_its_middle(result: xr.Dataset):
    subject = subject_of_result(result, "a.nc", ("a note",))
    assert subject.first.place == {"temperature": 4, "spring_stiffness": 4}
    stiffness = result.spring_stiffness.values[4]
    expected = Parameters(temperature=250, spring_stiffness=stiffness)
    assert subject.first.point.parameters == expected
    assert subject.first.label == "T = 250 K, K = 2000 N/m"
    assert subject.scales["temperature"] == Scale(210.0, 290.0)
    assert subject.scales["spring_stiffness"].logarithmic
    assert subject.notes == ("a note",)
    assert subject.result is result


def test_a_fit_opens_on_its_curve(result: xr.Dataset):
    """Its data and parameters have dimensions of their own."""
    curve = result.isel(spring_stiffness=4)
    fitted = curve.assign(
        fitted_value=("datum", np.ones(3)), parameter_value=("free_parameter", np.ones(2))
    )
    subject = subject_of_result(fitted, "fit.nc")
    assert subject.first.place == {"temperature": 4}
    assert subject.first.point.parameters.temperature == 250
    assert dict(subject.result.sizes) == {"temperature": 9}


def test_a_single_point_has_no_chart():
    alone = run({"model": {"temperature": 250}, "integrator": {"rtol": 1e-4}})
    subject = subject_of_result(alone, "a.nc")
    assert subject.result is None
    assert subject.first.point.parameters == Parameters(temperature=250)


def test_a_stack_without_a_coordinate_opens_by_numbers(result):
    bare = xr.concat([result.reset_coords(drop=True)] * 2, "film")
    assert subject_of_result(bare, "a.nc").first.label == "film 1, T = 250 K, K = 2000 N/m"


def test_what_is_no_result_is_refused():
    with pytest.raises(PointError, match="no result of a sweep"):
        subject_of_result(xr.Dataset({"x": ("t", np.zeros(3))}), "a.nc")
