"""Quantiles of results over the cases of a sample, and the bands drawn from them."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from support.pictures import failed, random_cases, sweep

import sweeps.accessor  # noqa: F401 - registers `stickslip`
from stickslip.status import Status
from sweeps.charts.choice import variables_of
from sweeps.charts.quantiles import medians_of, quantiles_of
from sweeps.figures import PlotOptions, draw

F = "friction_force_amplitude"


def over_temperatures(count: int = 64, temperatures: int = 3) -> xr.Dataset:
    """Return random cases at several temperatures; the forces are 1, 2, ... mN in random order."""
    ds = random_cases(count, spring_stiffness=(1e3, 5e3)).drop_vars("temperature")
    ds = xr.concat(
        [ds] * temperatures,
        xr.Variable("temperature", np.linspace(200.0, 300.0, temperatures)),
        data_vars="all",
        coords="minimal",
    )
    ordered = np.tile(np.arange(1.0, count + 1), (temperatures, 1))
    forces = np.random.default_rng(0).permuted(ordered, axis=1)
    return ds.assign({F: (ds[F].dims, forces * 1e-3, ds[F].attrs)})


def test_quantiles_are_taken_over_the_cases_with_a_result():
    ds = over_temperatures(11)
    ds = failed(ds, Status.NOT_STATIONARY, temperature=0, case=[0, 1])
    ds = failed(ds, Status.NOT_STATIONARY, temperature=1)
    found = quantiles_of(ds, [0.5, 0.1])
    assert found[F].dims == ("quantile", "temperature")
    assert found["quantile"].values.tolist() == [0.1, 0.5]
    assert found["cases_with_result"].values.tolist() == [9, 0, 11]
    assert found["status"].values.tolist() == [Status.OK, Status.NOT_STATIONARY, Status.OK]
    np.testing.assert_allclose(found[F].values[:, 2], [2e-3, 6e-3], rtol=1e-14)
    np.testing.assert_allclose(
        found[F].values[:, 0], np.quantile(ds[F].values[0, 2:], [0.1, 0.5]), rtol=1e-14
    )
    assert np.isnan(found[F].values[:, 1]).all()
    assert found[F].attrs["units"] == "N"
    assert "case" not in found.dims
    assert "spring_stiffness" not in found.coords  # it varied from case to case


def test_a_variable_without_quantiles_is_refused_for_what_it_is():
    found = quantiles_of(over_temperatures(4))
    with pytest.raises(ValueError, match=f"no quantiles of regime, only of .*{F}"):
        variables_of(found, PlotOptions(variable=("regime",)))


def test_masked_kinds_and_counts_have_no_quantiles():
    ds = over_temperatures(11)
    found = quantiles_of(ds.stickslip.ok())
    assert found.data_vars.keys() == quantiles_of(ds).data_vars.keys()
    assert not {"regime", "melting_count"} & found.data_vars.keys()


@pytest.mark.parametrize(
    ("ds", "levels", "said"),
    [
        (sweep(temperature=[200.0, 250.0]), None, "this result has none"),
        (over_temperatures(4), [0.5, 95.0], r"levels must be between 0 and 1, not \[0.5, 95.0\]"),
        (over_temperatures(4), [], "levels must be between 0 and 1"),
        (over_temperatures(4).isel(case=[]), None, "has no points along case"),
        (over_temperatures(4).isel(temperature=[]), None, "has no points along temperature"),
        (over_temperatures(4).drop_vars("status"), None, "it lacks a status"),
    ],
)
def test_impossible_quantiles_are_refused(ds, levels, said):
    with pytest.raises(ValueError, match=said):
        quantiles_of(ds, levels)


def test_a_swept_axis_of_random_cases_has_medians_and_bands():
    ds = failed(over_temperatures(), Status.NOT_STATIONARY, temperature=0, case=[0, 1])
    figure = draw(ds, options=PlotOptions(F, x="temperature"))
    (axes,) = figure.axes
    found = quantiles_of(ds)
    np.testing.assert_allclose(axes.lines[0].get_ydata(), 1e3 * found[F].sel(quantile=0.5))
    assert len(axes.collections) == 2
    for band, (low, high) in zip(axes.collections, [(0.025, 0.975), (0.16, 0.84)], strict=True):
        ends = band.get_paths()[0].vertices[:, 1]
        expected = 1e3 * found[F].sel(quantile=[low, high]).values
        assert (ends.min(), ends.max()) == pytest.approx((expected.min(), expected.max()))
    top = 1e3 * float(found[F].max())
    assert axes.get_ylim()[1] > top
    small_print = " ".join(text.get_text() for text in figure.texts)
    assert "Medians; bands hold 95 % and 68 % of 64 cases." in small_print
    assert "Left out: 2 points without a result." in small_print


def test_a_part_of_the_quantiles_and_variables_made_of_them_are_drawn():
    made = quantiles_of(over_temperatures())
    figure = draw(made[[F]], options=PlotOptions(F, x="temperature"))
    assert figure.get_supxlabel().startswith("Medians; bands hold 95 % and 68 % of 64 cases.")
    own = made.assign(mu=(made[F] / 0.01).drop_attrs())
    (axes,) = draw(own, options=PlotOptions("mu", x="temperature")).axes
    np.testing.assert_allclose(axes.lines[0].get_ydata(), 100 * made[F].sel(quantile=0.5))
    assert len(axes.collections) == 2
    bare = made.drop_attrs(deep=False)
    assert "Medians; bands hold" in draw(bare, options=PlotOptions(F)).get_supxlabel()


@pytest.mark.parametrize(("sign", "log"), [(1.0, "z"), (-1.0, "")])
def test_both_ends_of_a_band_lie_within_the_panel(sign, log):
    ds = over_temperatures()
    ds = ds.assign({F: (ds[F] * sign).assign_attrs(ds[F].attrs)})
    (axes,) = draw(ds, options=PlotOptions(F, x="temperature", log=log)).axes
    ends = 1e3 * quantiles_of(ds)[F].values
    low, high = axes.get_ylim()
    assert low < ends.min()
    assert ends.max() < high


@pytest.mark.parametrize(("temperatures", "lines"), [(40, 1), (3, 0)])
def test_a_long_axis_beside_random_cases_has_bands_without_being_named(temperatures, lines):
    figure = draw(over_temperatures(temperatures=temperatures), options=PlotOptions(F))
    assert len(figure.axes[0].lines) == lines


@pytest.mark.parametrize("choice", [{}, {"x": "temperature"}])
def test_many_counts_of_random_cases_have_no_bands(choice):
    ds = over_temperatures(temperatures=40)
    counts = np.arange(ds.status.size, dtype="i4").reshape(ds.status.shape)
    ds = ds.assign(periods_integrated=(ds.status.dims, counts))
    for one in (ds, ds.stickslip.ok()):
        figure = draw(one, options=PlotOptions("periods_integrated", **choice))
        assert "Medians" not in figure.get_supxlabel()


def test_quantiles_are_drawn_as_the_result_is():
    ds = over_temperatures()
    direct, by_way = (
        draw(each, options=PlotOptions(F, x="temperature")) for each in (ds, quantiles_of(ds))
    )
    lines = [figure.axes[0].lines[0].get_ydata() for figure in (direct, by_way)]
    np.testing.assert_array_equal(*lines)


def test_curves_of_quantiles_need_the_median():
    with pytest.raises(ValueError, match=r"0\.5 must be one of the levels"):
        medians_of(quantiles_of(over_temperatures(4), [0.1, 0.9]))


def test_quantiles_of_a_single_point_are_no_curves():
    found = quantiles_of(random_cases(64, spring_stiffness=(1e3, 5e3)))
    with pytest.raises(ValueError, match="these have no axis"):
        draw(found, "amplitudes")
    several = quantiles_of(over_temperatures())
    with pytest.raises(ValueError, match="these have no axis"):
        draw(several, None, PlotOptions(F, at=("T=200",)))


def test_random_cases_over_their_own_parameters_stay_points():
    figure = draw(over_temperatures(), options=PlotOptions(F, x="spring_stiffness"))
    assert not figure.axes[0].lines
