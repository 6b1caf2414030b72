"""The borders of sweeps: their places, the kinds on either side, and results without borders."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
import xarray as xr
from support import messages

from stickslip import Parameters, Status, stationary_orbit
from stickslip.dispatch import thread_pool
from stickslip.dispatch.task import Block, Task, compute_block
from stickslip.options import Options
from stickslip.orbit import compute_orbits
from stickslip.regime import Regime
from stickslip.variables import RESULT_COLUMNS
from sweeps import borders as boundaries_module
from sweeps import run
from sweeps.borders import BoundaryError, computation, types_of
from sweeps.engine.progress import Display, Scene

MEETING = 2
LOOSE = {"integrator": {"rtol": 1e-4}, "stationary": {"rtol": 1e-4}}
LINE = {"sweep": {"omega": {"linspace": [5, 60], "num": 56}}}
# The film melts for good above some temperature, at each frequency at another one.
SMALL = LOOSE | {
    "sweep": {
        "T": {"linspace": [230, 300], "num": 8},
        "omega": {"linspace": [20, 60], "num": 7},
    }
}

# Of these points two never close.
ODD = {
    "model": {"k": 22802, "K": 2349.9, "T": 205.9},
    "sweep": {"omega": {"linspace": [34, 37], "num": 7}},
    "integrator": {"rtol": 1e-4},
    "stationary": {"rtol": 1e-4, "window": 40},
}


@pytest.fixture(scope="module")
def line() -> xr.Dataset:
    return run(LINE)


@pytest.fixture(scope="module")
def small() -> xr.Dataset:
    return run(SMALL)


@pytest.fixture(scope="module")
def borders(small: xr.Dataset) -> xr.Dataset:
    return small.stickslip.boundaries(1e-4)


@pytest.mark.parametrize("kind", ["regime", "orbit"])
def test_the_five_borders_over_the_frequency(line: xr.Dataset, kind: Any) -> None:
    found = line.stickslip.boundaries(kind=kind)
    np.testing.assert_allclose(
        found.angular_frequency, [14.9181, 18.1079, 37.8709, 46.5025, 48.9315], atol=2e-4
    )
    assert found.line.values.tolist() == [0, 1, 2, 3, 4]
    kinds = np.stack([found.kind_left, found.kind_right], axis=1).tolist()
    assert kinds == [[2, 3], [3, 2], [2, 3], [3, 4], [4, 0]]
    assert found.type.values.tolist() == [0, 1, 0, 0, 0]
    assert (found.angular_frequency_bracket < 55e-6).all()
    if kind == "orbit":
        counts = np.stack([found.melting_count_left, found.melting_count_right], axis=1)
        assert counts.tolist() == [[4, 2], [2, 2], [2, 1], [1, 2], [2, 0]]
        assert found.orbit_periods_right.values.tolist() == [1, 1, 1, 3, 1]


def test_both_ends_of_a_bracket_are_orbits_of_their_kinds(line: xr.Dataset) -> None:
    found = line.stickslip.boundaries(1e-4)
    for point in range(2):
        row = found.isel(boundary_point=point)
        for side, sign in (("left", -1), ("right", 1)):
            omega = row.angular_frequency + sign * row.angular_frequency_bracket / 2
            orbit = stationary_orbit(Parameters(angular_frequency=omega.item()))
            assert orbit.regime == row[f"kind_{side}"]
            assert orbit.floquet_multiplier == pytest.approx(row[f"multiplier_{side}"].item())


def test_a_border_of_a_map_parts_its_kinds(borders: xr.Dataset) -> None:
    """A small step across a line, to its left or right, finds the kind on that side."""
    cell = {"temperature": 10.0, "angular_frequency": 40 / 6}
    scaled = np.stack([borders[name] / step for name, step in cell.items()], axis=1)
    points, expected = [], []
    for number in range(1, borders.sizes["boundary_point"]):
        row = borders.isel(boundary_point=number)
        if row.line != borders.line[number - 1] or row.type == MEETING:
            continue
        along = scaled[number] - scaled[number - 1]
        axis = int(row.temperature_bracket == 0)  # along which its edge lies
        across = np.eye(2)[axis] * np.sign(np.array([-along[1], along[0]])[axis])
        for side, sign in (("left", 1), ("right", -1)):
            place = (scaled[number] + sign * 1e-3 * across) * list(cell.values())
            point = Parameters(temperature=place[0], angular_frequency=place[1])
            points.append(point)
            expected.append(row[f"kind_{side}"].item())
    results, _ = compute_orbits(np.array(points), Options(rtol=1e-4, stationary_rtol=1e-4))
    assert len(expected) > 30
    assert results[:, RESULT_COLUMNS.index("regime")].tolist() == expected


def test_a_fold_has_a_multiplier_near_one() -> None:
    nan = np.nan
    multipliers = [[0.9, 0.1], [nan, 1.1], [0.5, 0.1], [nan, nan], [1e4, 0.2], [nan, nan]]
    is_crossing = np.array([True] * 5 + [False])
    types = types_of(np.array(multipliers), is_crossing)
    assert types.tolist() == [1, 1, 0, 0, 0, MEETING]


def test_borders_are_described_as_cf_requires(small: xr.Dataset, borders: xr.Dataset) -> None:
    assert borders.attrs["config"] == small.attrs["config"]
    assert borders.attrs["Conventions"] == "CF-1.8"
    for name, variable in borders.variables.items():
        assert "long_name" in variable.attrs, name
        assert "units" in variable.attrs, name
    assert borders.kind_left.attrs["flag_meanings"] == small.regime.attrs["flag_meanings"]
    assert borders.type.attrs["flag_meanings"] == "grazing fold meeting"
    assert borders.spring_stiffness.item() == 3000.0


def test_the_order_of_axes_and_the_number_of_workers_change_no_border(
    small: xr.Dataset, borders: xr.Dataset
) -> None:
    turned = small.isel(temperature=slice(None, None, -1))
    xr.testing.assert_equal(turned.stickslip.boundaries(1e-4, workers=1), borders)


@pytest.mark.stress
def test_a_motion_that_never_closes_needs_only_its_kind(monkeypatch: pytest.MonkeyPatch) -> None:
    """A longer window would only improve statistics, so none is used; late points come last."""
    begun: list[Task] = []

    def watched(task: Task) -> Block:
        begun.append(task)
        return compute_block(task)

    ds = run(ODD)
    assert (ds.regime == Regime.APERIODIC).any()
    expected = ds.stickslip.boundaries(1e-3)
    monkeypatch.setattr(thread_pool, "compute_block", watched)
    ds.attrs["config"] = ds.attrs["config"].replace("window: 40", "window: 100000")
    found = ds.stickslip.boundaries(1e-3)
    xr.testing.assert_equal(found, expected)
    assert Regime.APERIODIC in found.kind_right
    assert {task.options.window for task in begun} == {20}
    late = next(place for place, task in enumerate(begun) if task.is_unlimited)
    assert late > 1
    assert found.attrs["computed_points"] == expected.attrs["computed_points"]


def test_a_narrow_bracket_does_not_wait_for_a_slow_middle(monkeypatch: pytest.MonkeyPatch) -> None:
    """Towards the first border, orbits take ever longer to close: 3, 5, 11, 15, ... periods."""
    ds = run({"model": {"T": 166}, "sweep": {"omega": [5, 34.5625, 35.25, 60]}})
    found, accuracy = ds.stickslip.boundaries(1e-4), 55e-4
    monkeypatch.setattr(computation, "PATIENT", 0.0)
    patient = ds.stickslip.boundaries(1e-4)
    wide = found.angular_frequency_bracket.values > accuracy
    assert wide.tolist() == [True, False]
    assert found.angular_frequency_bracket.values[0] < 10 * accuracy
    assert (patient.angular_frequency_bracket <= accuracy).all()
    assert [ds.attrs["wide_brackets"] for ds in (found, patient)] == ["1", "0"]
    assert int(found.attrs["computed_points"]) < int(patient.attrs["computed_points"])
    for side in ("kind_left", "kind_right"):
        np.testing.assert_array_equal(found[side], patient[side])
    away = np.abs(found.angular_frequency - patient.angular_frequency)
    assert (away < found.angular_frequency_bracket / 2 + accuracy).all()


def test_progress_shows_how_many_points_follow(
    line: xr.Dataset, monkeypatch: pytest.MonkeyPatch
) -> None:
    scenes: list[Scene] = []

    def shown(scene: Scene, *, wanted: bool) -> Display:
        assert wanted
        scenes.append(scene)
        return Display()

    monkeypatch.setattr(boundaries_module, "display_of", shown)
    found = boundaries_module.boundaries(line, 1e-3, progress=True)
    (scene,) = scenes
    done = found.attrs["computed_points"]
    assert done == str(scene.done) == str(scene.goal)
    assert re.fullmatch(
        f"bisecting: {done} of about {done} points, \\d+:\\d+ elapsed", scene.headline
    )
    assert scene.outlook == ""


def test_points_without_a_result_make_no_borders(line: xr.Dataset) -> None:
    part = line.sel(angular_frequency=slice(10, 20)).copy(deep=True)
    part.status[{"angular_frequency": 5}] = Status.NOT_STATIONARY  # at 15 rad/s
    found = part.stickslip.boundaries(1e-3)
    assert found.angular_frequency.values == pytest.approx([18.11], abs=0.02)
    part.status[:] = Status.INTERPOLATED
    assert part.stickslip.boundaries(1e-3).sizes["boundary_point"] == 2


def test_a_result_masked_by_ok_has_the_same_borders(line: xr.Dataset) -> None:
    failed = line.copy(deep=True)
    failed["status"][13] = Status.NOT_STATIONARY
    failed["regime"][13] = Regime.UNKNOWN
    found, masked = (ds.stickslip.boundaries(1e-2) for ds in (failed, failed.stickslip.ok()))
    assert found.drop_attrs().equals(masked.drop_attrs())


def test_a_fitted_curve_has_borders_as_its_sweep_has(line: xr.Dataset) -> None:
    """The data and parameters of a fit add dimensions of their own."""
    part = line.sel(angular_frequency=slice(44, 50))
    fitted = part.assign(fitted_value=("datum", np.ones(3)), parameter_value=("free", [1.0]))
    xr.testing.assert_equal(fitted.stickslip.boundaries(1e-3), part.stickslip.boundaries(1e-3))


def test_a_stack_of_results_has_borders_only_if_their_settings_are_the_same() -> None:
    """The Dataset keeps only the config of the first result."""
    axis = {"sweep": {"T": [200, 300]}}
    loose, stiff, strict, other = (
        run(settings | axis | {"model": {"K": K}}) for settings in (LOOSE, {}) for K in (3000, 4000)
    )
    same = xr.concat([loose, stiff], "spring_stiffness")
    assert same.stickslip.boundaries(0.1).sizes["boundary_point"] > 1
    mixed = xr.concat([loose, strict], "rtol")
    assert mixed.isel(rtol=0).stickslip.boundaries(0.1).sizes["boundary_point"] == 1
    for stack in (mixed.isel(rtol=1), xr.concat([loose, other], "spring_stiffness")):
        message = f"results {messages.OTHER_SETTINGS}, or edited; compute the borders of each"
        with pytest.raises(BoundaryError, match=message):
            stack.stickslip.boundaries(0.1)


def test_the_settings_of_a_refined_stack_are_those_of_its_computed_points() -> None:
    """No periods were computed for an interpolated point, so it does not reveal the settings."""
    refined = {
        "sweep": {"T": {"linspace": [200, 300], "num": 17}},
        "refine": {"axes": ["T"], "levels": 2, "where": ["regime", 0.3]},
    }
    one, other = (
        run(settings | refined | {"model": {"K": K}}) for settings, K in ((LOOSE, 3e3), ({}, 4e3))
    )
    assert (other.status == Status.INTERPOLATED).any()
    with pytest.raises(BoundaryError, match=messages.OTHER_SETTINGS):
        xr.concat([one, other], "spring_stiffness").stickslip.boundaries(0.1)


def test_dropped_parameters_are_those_of_the_config_or_refused() -> None:
    rough = {"integrator": {"rtol": 1e-4}, "stationary": {"rtol": 1e-4}, "model": {"K": 1000}}
    axes = {"T": {"linspace": [150, 320], "num": 6}, "omega": [10, 40]}
    ds = run(rough | {"sweep": axes})
    slow = ds.isel(angular_frequency=0)
    found = slow.drop_vars("spring_stiffness").stickslip.boundaries(1e-2)
    np.testing.assert_array_equal(found.temperature, slow.stickslip.boundaries(1e-2).temperature)
    with pytest.raises(
        BoundaryError, match="this result has lost angular_frequency, which varied in it"
    ):
        ds.isel(angular_frequency=1, drop=True).stickslip.boundaries(1e-2)


def test_one_kind_has_no_borders(line: xr.Dataset) -> None:
    part = line.sel(angular_frequency=slice(50, 60))
    assert part.stickslip.boundaries().sizes["boundary_point"] == 0


def test_a_logarithmic_axis_is_bisected_by_ratios() -> None:
    ds = run(LOOSE | {"sweep": {"omega": {"geomspace": [5, 60], "num": 20}}})
    found = ds.stickslip.boundaries(1e-4)
    assert found.angular_frequency.values[0] == pytest.approx(14.918, abs=0.01)
    part = found.angular_frequency_bracket / found.angular_frequency
    assert (part <= 1e-4 * np.log(12) * 1.01).all()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"sweep": {"omega": [14.0, 15.0], "T": [200, 210], "K": [2e3, 3e3]}}, "select a point"),
        ({"sweep": {}}, "varies along nothing"),
        ({"sweep": {"omega": [14.0, 15.0]}, "follow": "omega"}, "sweep without `follow`"),
        ({"sweep": {}, "cases": {"T": [200, 210], "K": [2e3, 3e3]}}, "select a case"),
        (
            {
                "sweep": {"omega": [50.0, 51.0]},
                "model": {"rheological_index": 0},
                "noise": {"treatment": "stochastic", "realizations": 2},
                "stationary": {"rtol": 1e-4, "window": 20},
            },
            "a stochastic film has no borders",
        ),
    ],
)
def test_results_without_borders_are_refused(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(BoundaryError, match=message):
        run(LOOSE | changes).stickslip.boundaries()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"accuracy": 0.0}, "accuracy must be a fraction"),
        ({"accuracy": float("nan")}, "accuracy must be a fraction"),
        ({"kind": "amplitude"}, "kind must be regime or orbit"),
    ],
)
def test_wrong_arguments_are_refused(
    line: xr.Dataset, arguments: dict[str, Any], message: str
) -> None:
    with pytest.raises(BoundaryError, match=message):
        line.stickslip.boundaries(**arguments)


def test_another_dataset_is_no_map(borders: xr.Dataset) -> None:
    with pytest.raises(BoundaryError, match="not the result of a sweep: it lacks status"):
        borders.stickslip.boundaries()
    with pytest.raises(BoundaryError, match="not the result of a sweep: it has no config"):
        xr.Dataset().stickslip.boundaries()
