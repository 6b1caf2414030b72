"""Charts of results: their kinds, axes and values."""

from __future__ import annotations

import numpy as np
import pytest
from support.pictures import GAMMAS, both_ways, failed, random_cases, sweep

from stickslip.status import Status
from stickslip.symbols import plain
from sweeps.charts.chart import Cells, Cloud, Curves, chart_of, further_axes
from sweeps.charts.choice import Choice

STRESS = "elastic_stress_amplitude"
T, K = np.linspace(150.0, 320.0, 35), np.geomspace(100.0, 1e4, 21)
GAMMA = list(GAMMAS)


def regimes(ds):
    """Return a sweep along one axis that is liquid above 280 K and slips below."""
    return ds.assign(regime=("temperature", np.where(T > 280.0, 0, 2).astype("i1")))


def test_one_long_axis_gives_a_curve_for_each_value_of_the_other():
    ds = sweep(temperature=T, rheological_index=GAMMA)
    chart = chart_of(ds, Choice(STRESS))
    assert isinstance(chart, Curves)
    assert [curve.label.split(",")[0] for curve in chart.curves] == [
        "pseudoplastic",
        "Newtonian",
        "dilatant",
    ]
    np.testing.assert_allclose(chart.curves[1].values, ds[STRESS][:, 1] / 1e6)
    assert plain(chart.label) == "σₑₗ,ₘₐₓ (MPa)"
    assert further_axes(ds, Choice(STRESS)) == []
    assert [curve.places["rheological_index"] for curve in chart.curves] == [0, 1, 2]


def test_points_without_a_value_are_gaps():
    ds = failed(sweep(temperature=T, rheological_index=GAMMA), Status.DIVERGED, temperature=3)
    chart = chart_of(ds, Choice(STRESS))
    assert np.isnan(chart.curves[0].values[3])


def test_two_long_axes_give_a_map_and_the_others_are_cut():
    ds = sweep(temperature=T, spring_stiffness=K, rheological_index=GAMMA)
    choice = Choice(STRESS)
    chart = chart_of(ds, choice)
    assert isinstance(chart, Cells)
    assert further_axes(ds, choice) == ["rheological_index"]
    assert chart.image().shape == (21, 35)
    np.testing.assert_allclose(chart.image(), ds[STRESS][:, :, 0].T / 1e6, rtol=1e-6)


def test_uneven_axes_keep_the_sizes_of_their_cells():
    uneven = [150.0, 160.0, 170.0, 180.0, 190.0, 200.0, 210.0, 220.0, 300.0]
    ds = sweep(temperature=uneven, spring_stiffness=K)
    chart = chart_of(ds, Choice(STRESS))
    image = chart.image()
    last = np.mean(image[0] == image[0, -1])
    assert last == pytest.approx(80.0 / 195.0, abs=0.01)
    assert image.shape[0] == 21


def test_the_axes_may_be_chosen():
    ds = sweep(temperature=T, spring_stiffness=K, rheological_index=GAMMA)
    chart = chart_of(ds, Choice(STRESS, x="spring_stiffness", y="rheological_index"))
    assert isinstance(chart, Cells)
    assert chart.across.geometric
    assert chart.up.names[0].startswith("pseudoplastic")
    with pytest.raises(ValueError, match="is both x and y"):
        chart_of(ds, Choice(STRESS, x="temperature", y="temperature"))


def test_kinds_along_one_axis_are_a_strip():
    ds = regimes(sweep(temperature=T))
    chart = chart_of(ds, Choice("regime"))
    assert isinstance(chart, Cells)
    assert chart.colours.codes == (0, 2)
    assert np.unique(chart.image()).tolist() == [0.0, 1.0]


def test_both_ways_are_two_curves():
    ds = both_ways(sweep(angular_frequency=np.linspace(5.0, 50.0, 20)))
    chart = chart_of(ds, Choice(STRESS))
    assert [curve.label for curve in chart.curves] == ["upward", "downward"]
    assert chart.curves[1].places == {"direction": 1}


def test_kinds_both_ways_are_two_strips():
    ds = both_ways(sweep(temperature=T))
    ds["regime"] = ds["status"].copy(data=np.broadcast_to([[0], [2]], ds["status"].shape))
    chart = chart_of(ds, Choice("regime"))
    assert isinstance(chart, Cells)
    assert chart.up.names == ("upward", "downward")
    assert np.unique(chart.values, axis=1).tolist() == [[0.0], [1.0]]


def test_a_curve_knows_its_jumps_and_the_range_of_all_values():
    ds = regimes(sweep(temperature=T))
    ds[STRESS] = ds[STRESS].where(T <= 280.0, 0.1 * ds[STRESS])
    chart = chart_of(ds, Choice(STRESS))
    assert np.flatnonzero(chart.curves[0].jumps).tolist() == [np.flatnonzero(T > 280.0)[0] - 1]
    low, high = chart.ends
    assert low < 0.0
    assert high > float(ds[STRESS].max()) / 1e6
    ds[STRESS][3] = 0.0
    heights = chart_of(ds, Choice(STRESS, log="z")).curves[0].values
    assert np.flatnonzero(np.isnan(heights)).tolist() == [3]


def test_cases_may_lie_over_the_variable_itself():
    ds = random_cases(60, temperature=(150.0, 320.0), spring_stiffness=(100.0, 1e4))
    chart = chart_of(ds, Choice(STRESS, x="temperature"), of_values=True)
    assert isinstance(chart, Cloud)
    np.testing.assert_allclose(chart.y, ds[STRESS] / 1e6)
    assert chart.colours is not None
    assert chart.colours.name == "regime"


def test_random_cases_are_a_cloud():
    bounds = {"temperature": (150.0, 320.0), "spring_stiffness": (100.0, 1e4)}
    ds = random_cases(60, **bounds)
    chart = chart_of(ds, Choice("regime"))
    assert isinstance(chart, Cloud)
    assert chart.names == ("temperature", "spring_stiffness")
    np.testing.assert_array_equal(chart.x, ds.temperature)
    np.testing.assert_array_equal(chart.y, ds.spring_stiffness)
    swapped = chart_of(ds, Choice("regime", x="spring_stiffness"))
    assert swapped.names == ("spring_stiffness", "temperature")
    with pytest.raises(ValueError, match="choose another one for the vertical axis"):
        chart_of(ds, Choice("regime", x="temperature", y="temperature"))
