"""Missing points, and layouts: gaps, crosses, curves, maps, facets, tables."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from matplotlib.collections import QuadMesh
from support.pictures import (
    GAMMAS,
    TEMPERATURES,
    both_ways,
    crosses,
    curves,
    described,
    failed,
    legend_of,
    linked,
    note,
    panels,
    sweep,
    trajectory,
)

from stickslip.status import Status
from stickslip.variables import PARAMETERS
from sweeps.charts.axes import Layout, layout_of
from sweeps.figures import PlotOptions, draw

# --- missing points -----------------------------------------------------------------------------


def test_missing_points_are_gaps_crosses_and_a_note():
    ds = sweep(temperature=TEMPERATURES, rheological_index=list(GAMMAS))
    ds = failed(ds, Status.NOT_STATIONARY, temperature=slice(5, 8), rheological_index=0)
    ds = failed(ds, Status.PENDING, temperature=20, rheological_index=2)
    figure = draw(ds)
    for axes in panels(figure):
        gaps = [np.flatnonzero(np.isnan(line.get_ydata())).tolist() for line in curves(axes)]
        assert gaps == [[5, 6, 7], [], [20]]
        first, second = crosses(axes)
        np.testing.assert_array_equal(first.get_xdata(), TEMPERATURES[5:8])
        np.testing.assert_array_equal(second.get_xdata(), TEMPERATURES[[20]])
        assert first.get_color() != second.get_color()
        assert axes.get_ylim()[1] * second.get_ydata()[0] > np.nanmax(curves(axes)[1].get_ydata())
    assert note(figure) == "× 4 of 105 points missing (3 not stationary, 1 pending)"


def test_a_number_with_a_bad_status_is_not_drawn():
    ds = sweep(temperature=TEMPERATURES)
    ds["status"][3] = Status.INVARIANT_VIOLATED
    figure = draw(ds)
    assert all(np.isnan(curves(axes)[0].get_ydata()[3]) for axes in panels(figure))
    assert "1 of 35 points missing (1 invariant violated)" in note(figure)


def test_a_nan_without_a_reason_is_reported():
    ds = sweep(temperature=TEMPERATURES)
    ds["friction_force_amplitude"][3] = np.nan
    assert "1 without a value" in note(draw(ds))


def test_a_masked_point_is_missing_without_a_status():
    ds = sweep(temperature=[200.0, 250.0, 300.0])
    masked = ds.where(ds.temperature > 200.0)
    assert note(draw(masked)) == "× 1 of 3 points missing (1 without a status)"
    table = draw(masked.isel(temperature=0))
    said = " ".join(text.get_text() for text in table.texts)
    assert "It has no result. 1 of 1 points missing (1 without a status)" in said


def test_a_point_between_two_gaps_has_a_marker():
    ds = failed(sweep(temperature=TEMPERATURES), Status.DIVERGED, temperature=[9, 11])
    (line,) = curves(panels(draw(ds))[0])
    assert line.get_marker() == "o"
    assert line.get_markevery() == [10]


def test_a_sweep_without_any_result_still_says_so():
    ds = failed(sweep(temperature=TEMPERATURES), Status.REFUSED, temperature=slice(None))
    assert "35 of 35 points missing (35 refused)" in note(draw(ds))


# --- layouts ------------------------------------------------------------------------------------


def test_two_long_axes_give_maps_with_colour_bars():
    k = np.geomspace(1e4, 2e5, 12)
    ds = sweep(temperature=TEMPERATURES, viscosity_coefficient=k)
    ds = ds.assign_coords(rheological_index=0.0)
    ds = failed(ds, Status.DIVERGED, temperature=4, viscosity_coefficient=7)
    figure = draw(ds)
    upper, lower = panels(figure)
    (mesh,) = (c for c in upper.collections if isinstance(c, QuadMesh))
    expected = (ds.elastic_stress_amplitude * 1e-6).transpose("viscosity_coefficient", ...)
    np.testing.assert_allclose(mesh.get_array().filled(np.nan), expected)
    bars = [axes.get_ylabel() for axes in figure.axes if axes not in (upper, lower)]
    assert bars == [r"$\sigma_\mathrm{el,max}$ (MPa)", r"$F_\mathrm{max}$ (mN)"]
    assert (lower.get_xlabel(), lower.get_ylabel()) == ("$T$ (K)", r"$k$ (Pa$\cdot$s)")
    assert (lower.get_xscale(), lower.get_yscale()) == ("linear", "log")
    missing = "Grey: 1 of 420 points missing (1 diverged)"
    assert note(figure) == rf"{missing} With $\gamma = 0$."


def test_the_cells_of_a_map_lie_around_their_points():
    k = np.geomspace(1e4, 2e5, 12)
    upper = panels(draw(sweep(temperature=TEMPERATURES, viscosity_coefficient=k)))[0]
    corners = upper.collections[0].get_coordinates()
    np.testing.assert_allclose(corners[0, :-1, 0] + 2.5, TEMPERATURES)
    np.testing.assert_allclose(np.sqrt(corners[:-1, 0, 1] * corners[1:, 0, 1]), k)


def test_facets_share_one_scale_and_say_what_they_leave_out():
    stiffness = [500.0, 1000.0, 2000.0, 3000.0, 4000.0, 6000.0]
    k = np.geomspace(1e4, 2e5, 12)
    ds = sweep(temperature=TEMPERATURES, viscosity_coefficient=k, spring_stiffness=stiffness)
    figure = draw(ds)
    titles = [axes.get_title() for axes in panels(figure)]
    assert titles[:4] == [f"$K = {value}$ N/m" for value in (500, 2000, 3000, 6000)]
    assert len({axes.collections[0].get_clim() for axes in panels(figure)[:4]}) == 1
    assert note(figure) == "4 of 6 values of $K$ are drawn."


def test_five_axes_give_a_few_panels_and_say_where_the_rest_is_cut():
    ds = sweep(
        temperature=np.linspace(150.0, 320.0, 8),
        viscosity_coefficient=np.geomspace(1e4, 2e5, 6),
        spring_stiffness=np.geomspace(500.0, 1e4, 6),
        rheological_index=list(GAMMAS),
        angular_frequency=[10.0, 15.0, 32.0, 38.0],
    )
    ds = failed(ds, Status.PENDING, temperature=0, viscosity_coefficient=0)
    figure = draw(ds)
    titles = [axes.get_title() for axes in panels(figure)[:4]]
    assert titles == [rf"$\omega = {omega}$ rad/s" for omega in (10, 15, 32, 38)]
    middle = ds.isel(viscosity_coefficient=3, spring_stiffness=3, rheological_index=1)
    expected = middle.elastic_stress_amplitude.isel(angular_frequency=2) * 1e-6
    np.testing.assert_allclose(curves(panels(figure)[2])[1].get_ydata(), expected)
    # Points missing elsewhere do not concern this picture.
    assert note(figure) == (
        r"Other axes at their middle: $k = 60341.8$ Pa$\cdot$s$^{\gamma+1}$, $K = 3017.09$ N/m."
    )
    figure.draw_without_rendering()
    boxes = [axes.title.get_window_extent() for axes in panels(figure)[:4]]
    assert all(left.x1 < right.x0 for left, right in itertools.pairwise(boxes))


def test_a_note_names_the_fixed_parameters_that_are_not_the_usual_ones():
    ds = sweep(temperature=TEMPERATURES).assign_coords(block_mass=0.5, spring_stiffness=2e3)
    figure = draw(described(ds))
    assert note(figure) == "With $K = 2000$ N/m, $M = 0.5$ kg."
    assert note(draw(described(trajectory().assign_coords(block_mass=0.5)))) == "With $M = 0.5$ kg."


def test_a_long_note_is_wrapped_and_never_cut():
    others = {name: p.default * 1.25 for name, p in PARAMETERS.items() if p.default}
    del others["temperature"]
    figure = draw(described(sweep(temperature=TEMPERATURES).assign_coords(others)))
    figure.draw_without_rendering()
    small_print = figure._supxlabel.get_window_extent()
    assert figure.bbox.x0 <= small_print.x0
    assert small_print.x1 <= figure.bbox.x1
    assert figure.bbox.y0 <= small_print.y0
    first, *others = figure.get_supxlabel().split("\n")
    assert first.startswith("With ")
    assert others  # and no unit is parted from its number
    assert all(line.startswith("$") for line in others)
    assert small_print.y1 < panels(figure)[1].xaxis.label.get_window_extent().y0


def test_both_ways_are_a_solid_and_a_dashed_curve_in_one_colour():
    ds = both_ways(sweep(temperature=TEMPERATURES, rheological_index=list(GAMMAS)))
    figure = draw(ds)
    upper, _ = panels(figure)
    lines = curves(upper)
    assert [line.get_linestyle() for line in lines] == ["-", "--"] * 3
    assert all(
        up.get_color() == down.get_color() for up, down in zip(lines[::2], lines[1::2], strict=True)
    )
    for i, line in enumerate(lines):
        one = ds.elastic_stress_amplitude.isel(rheological_index=i // 2, direction=i % 2)
        np.testing.assert_allclose(line.get_ydata(), one * 1e-6)
    assert legend_of(figure)[-2:] == ["upward", "downward"]
    up, down = figure.legends[0].get_lines()[-2:]
    assert (up.get_linestyle(), down.get_linestyle()) == ("-", "--")
    assert up.get_color() == down.get_color() == "#000000"  # no colour of a curve


def test_both_ways_of_a_single_point_lie_beside_each_other():
    ds = both_ways(sweep(temperature=TEMPERATURES))
    lower = panels(draw(ds, options=PlotOptions(at=("T=200",))))[1]
    assert [text.get_text() for text in lower.get_xticklabels()] == ["upward", "downward"]
    assert len(curves(lower)[0].get_xdata()) == 2
    (strip,) = panels(draw(ds, options=PlotOptions("melting_count", at=("T=200",))))
    assert [text.get_text() for text in strip.get_xticklabels()] == ["upward", "downward"]


def test_both_ways_of_a_map_lie_side_by_side():
    k = np.geomspace(1e4, 2e5, 12)
    figure = draw(both_ways(sweep(temperature=TEMPERATURES, viscosity_coefficient=k)))
    assert [axes.get_title() for axes in panels(figure)[:2]] == ["upward", "downward"]


def test_an_interpolated_point_is_drawn_as_any_other():
    ds = sweep(temperature=TEMPERATURES)
    ds["status"][5:9] = Status.INTERPOLATED
    figure = draw(ds)
    assert np.isfinite(curves(panels(figure)[0])[0].get_ydata()).all()
    assert note(figure) == ""


def test_three_axes_with_one_long_give_curves_in_columns():
    ds = sweep(
        rheological_index=list(GAMMAS), temperature=TEMPERATURES, spring_stiffness=[1e3, 3e3]
    )
    figure = draw(ds)
    assert [axes.get_title() for axes in panels(figure)[:2]] == ["$K = 1000$ N/m", "$K = 3000$ N/m"]
    assert panels(figure)[0].get_ylim() == panels(figure)[1].get_ylim()
    line = curves(panels(figure)[1])[2]
    expected = ds.elastic_stress_amplitude.isel(rheological_index=2, spring_stiffness=1) * 1e-6
    np.testing.assert_allclose(line.get_ydata(), expected)


def test_the_longest_axis_carries_the_curves_where_all_are_short():
    ds = sweep(rheological_index=list(GAMMAS), temperature=[200.0, 220.0, 250.0, 300.0])
    assert layout_of(ds) == Layout(x="temperature", hue="rheological_index")


def test_linked_cases_are_labelled_with_all_their_parameters():
    ds = linked(sweep(temperature=TEMPERATURES, case=[0, 1]))
    labels = [text.get_text() for text in draw(ds).legends[0].get_texts()]
    assert labels[1] == r"$X_m = 0.8$ µm, $\omega = 10$ rad/s"


def test_linked_cases_alone_lie_along_their_first_parameter():
    ds = linked(sweep(case=np.arange(9)))
    lower = panels(draw(ds))[1]
    np.testing.assert_allclose(curves(lower)[0].get_xdata(), np.linspace(0.4, 0.8, 9))
    assert lower.get_xlabel() == r"$X_m$ (µm), linked with $\omega$"


def cells(figure) -> dict[str, str]:
    """Return the table of a picture: the text to the right of each symbol."""
    rows: dict[float, list[tuple[float, str]]] = {}
    for text in figure.texts:
        rows.setdefault(text.get_position()[1], []).append(
            (text.get_position()[0], text.get_text())
        )
    lines = [[text for _, text in sorted(row)] for row in rows.values()]
    return {line[i]: line[i + 1] for line in lines for i in range(0, len(line) - 1, 2)}


@pytest.mark.parametrize("axes", [{}, {"temperature": [200.0]}])
def test_a_single_point_is_a_table(axes):
    figure = draw(sweep(**axes))
    lines = [text.get_text() for text in figure.texts]
    assert lines[0] == "A single point."
    assert cells(figure)[r"$F_\mathrm{max}$"] == "$4.768$ mN"
    assert cells(figure)[r"$n_\mathrm{melt}$"] == "$4$"
    assert cells(figure)["$T$"] == "$200$ K"


def test_a_point_cut_out_of_a_sweep_says_where():
    ds = sweep(temperature=TEMPERATURES, spring_stiffness=[1000.0, 2000.0])
    figure = draw(ds, options=PlotOptions(at=("T=200", "K=2000")))
    assert figure.texts[0].get_text() == "At $T = 200$ K, $K = 2000$ N/m."


def test_a_variable_of_the_user_is_above_the_table_of_a_point():
    about = {"long_name": "friction force over the load of the machine", "units": "1"}
    ds = sweep(temperature=[200.0, 250.0]).assign(mu=("temperature", [0.3, np.nan], about))
    first, second = (
        draw(ds, options=PlotOptions("mu", at=(at,))).texts[1].get_text()
        for at in ("T=200", "T=250")
    )
    assert first == "friction force over the load of the machine: $0.3$"
    assert second.endswith(": none")


def test_a_point_without_amplitudes_is_a_table():
    ds = sweep(temperature=[200.0]).assign(regime=("temperature", np.array([2], dtype="i1")))
    part = ds[["regime", "status"]]
    figure = draw(part, options=PlotOptions("regime"))
    assert cells(figure)[r"$\mathrm{regime}$"] == "stick-slip, symmetric"
    part["status"][0] = Status.DIVERGED
    figure = draw(part, options=PlotOptions("regime"))
    assert cells(figure)[r"$\mathrm{regime}$"] == "missing"
    assert Status.DIVERGED.sentence in " ".join(text.get_text() for text in figure.texts)


def test_a_failed_single_point_says_why():
    ds = sweep(temperature=[200.0])
    ds["status"][0] = Status.DIVERGED
    ds["melting_count"][0] = -1
    figure = draw(ds)
    assert Status.DIVERGED.sentence in " ".join(text.get_text() for text in figure.texts)
    assert cells(figure)[r"$F_\mathrm{max}$"] == "missing"
    assert cells(figure)[r"$n_\mathrm{melt}$"] == "missing"


def test_a_single_point_names_its_regime_and_no_text_lies_on_another():
    ds = sweep().assign(regime=((), np.int8(2)), lyapunov_exponent=((), np.nan))
    every = {name: parameter.default for name, parameter in PARAMETERS.items()}
    figure = draw(described(ds.assign_coords(every)))
    assert cells(figure)[r"$\mathrm{regime}$"] == "stick-slip, symmetric"
    assert cells(figure)[r"$\lambda$"] == "none"
    boxes = [text.get_window_extent() for text in figure.texts]
    assert not any(a.overlaps(b) for a, b in itertools.combinations(boxes, 2))
    assert all(figure.bbox.x0 <= box.x0 and box.x1 <= figure.bbox.x1 for box in boxes)
