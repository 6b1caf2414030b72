"""On followed lines each point starts from the orbit before it, whatever happens to the sweep."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from support.marks import one_then
from support.sweeps.sweeping import LOOSE, Shell, hash_at_once, hash_of, write

from stickslip import Parameters, Status
from stickslip.dispatch import lines as following
from stickslip.dispatch.blocks import Costs
from stickslip.dispatch.lines import Lines, follow, start_after
from stickslip.options import METHODS, Options
from stickslip.orbit import compute_orbits
from stickslip.variables import RESULT_COLUMNS
from sweeps import run
from sweeps.config.load import from_mapping
from sweeps.engine.plan import plan
from sweeps.engine.resume import lines_of
from sweeps.files.netcdf import open_result
from sweeps.grid import Grid

LINE = "sweep: {T: [200, 210], omega: [14, 14.5, 15, 15.5, 18, 18.5]}\nfollow: omega\n"


def grid_of(**axes: list[float]) -> Grid:
    return Grid.from_config(from_mapping({"sweep": axes, "follow": "omega"}))


# --- the orbits -----------------------------------------------------------------------------------


@pytest.mark.parametrize("method", one_then("stress", [*METHODS]))
def test_each_point_starts_on_the_orbit_before_it(method: str) -> None:
    # A film without elasticity allows a large fixed step.
    options = Options(method=method, dt=2e-5, rtol=1e-4, stationary_rtol=1e-4)
    soft = {"elastic_coefficient": 0.0, "rheological_index": 0.0}
    points = np.array([Parameters(angular_frequency=w, **soft) for w in (10.0, 11.0, 12.0)])
    rows = follow(points, 3, options)
    state = None
    for point, row in zip(points, rows, strict=True):
        expected, state = compute_orbits(point, options, state)
        np.testing.assert_array_equal(row, expected[0])
    from_rest, _ = compute_orbits(points, options)
    assert not np.array_equal(rows[1:], from_rest[1:])


def test_the_states_of_a_line_are_computed_once(monkeypatch: pytest.MonkeyPatch) -> None:
    options = Options(rtol=1e-4, stationary_rtol=1e-4)
    points = np.array([Parameters(angular_frequency=w) for w in (14.0, 14.5, 15.0, 15.5)])
    state, states = None, []
    for point in points:
        _, state = compute_orbits(point, options, state)
        states.append(state[0])
    counted = []

    def counting(some: np.ndarray, *rest: object) -> object:
        counted.append(len(some))
        return compute_orbits(some, *rest)

    monkeypatch.setattr(following, "KNOWN", {})
    monkeypatch.setattr(following, "compute_orbits", counting)
    for number, computed in ((2, 2), (4, 4), (3, 4), (4, 4)):
        np.testing.assert_array_equal(start_after(points[:number], options), states[number - 1])
        assert len(counted) == computed
    other = Options(rtol=1e-5, stationary_rtol=1e-4)
    assert not np.array_equal(start_after(points, other), states[-1])
    assert len(counted) == 8
    assert np.isnan(start_after(points[:0], options)).all()


def test_the_number_of_remembered_states_is_limited(monkeypatch: pytest.MonkeyPatch) -> None:
    options = Options(rtol=1e-4, stationary_rtol=1e-4)
    monkeypatch.setattr(following, "KNOWN", {})
    monkeypatch.setattr(following, "MOST_KNOWN", 2)
    for temperature in (200.0, 210.0, 220.0, 230.0):
        start_after(np.array([Parameters(temperature=temperature)]), options)
    assert len(following.KNOWN) <= 3


def test_up_and_down_a_line_may_end_on_different_orbits() -> None:
    ds = run({"sweep": {"omega": [14, 14.5, 15, 15.5, 18, 18.5]}, "follow": "omega"})
    assert ds.direction.values.tolist() == ["up", "down"]
    lopsided = (ds.asymmetry > 0.1).sel(direction="up").values.tolist()
    assert lopsided == [False, False, True, True, True, False]
    assert not (ds.asymmetry > 0.1).sel(direction="down").any()
    assert ds.attrs["follow_breaks"] == "0"


def test_a_line_goes_on_after_a_point_without_a_result(monkeypatch: pytest.MonkeyPatch) -> None:
    given = []

    def compute(points: np.ndarray, options: Options, starts: np.ndarray) -> tuple:
        given.append(starts.copy())
        results, finals = compute_orbits(points, options, starts)
        results[points[:, 4] == 11.0, RESULT_COLUMNS.index("status")] = Status.NOT_STATIONARY
        return results, np.where(points[:, 4:5] == 11.0, -1.0, finals)

    monkeypatch.setattr(following, "compute_orbits", compute)
    omegas = (11.0, 10.0, 11.0, 12.0)
    points = np.array([Parameters(angular_frequency=w) for w in omegas])
    follow(points, 4, Options(rtol=1e-4))
    assert np.isnan(given[1]).all()  # the config's start, as nothing has settled yet
    np.testing.assert_array_equal(given[2], given[3])
    assert (given[2] != -1.0).all()


def test_the_file_counts_the_breaks() -> None:
    config = {"sweep": {"omega": [10, 11, 12]}, "follow": "omega"}
    ds = run(config | {"stationary": {"max_periods": 1}})
    assert ds.attrs["follow_breaks"] == "6"


# --- lines ----------------------------------------------------------------------------------------


def test_a_line_goes_up_and_down_again() -> None:
    grid = grid_of(omega=[1, 2, 3], T=[200, 250])
    assert grid.shape == (3, 2, 2)
    lines = grid.lines()
    assert lines.tolist() == [[0, 4, 8, 9, 5, 1], [2, 6, 10, 11, 7, 3]]
    for line in lines:
        assert [row[4] for row in grid.rows(line)] == [1, 2, 3, 3, 2, 1]


def test_a_line_with_a_point_missing_is_computed_as_a_whole() -> None:
    grid = grid_of(T=[1, 2, 3], omega=[1, 2])
    done = np.ones(grid.size, dtype=bool)
    done[5] = False
    (block,) = Lines(grid.lines(), done, slots=2)
    assert block.tolist() == grid.lines()[1].tolist()
    assert lines_of(grid, np.array([5])).nonzero()[0].tolist() == sorted(block)


def test_lines_are_dealt_out_evenly() -> None:
    grid = grid_of(T=list(range(1, 41)), omega=[1, 2])
    nothing = np.zeros(grid.size, dtype=bool)
    sizes = [len(block) // 4 for block in Lines(grid.lines(), nothing, slots=2)]
    assert sizes == [16, 16, 8]
    assert [len(block) // 4 for block in Lines(grid.lines(), nothing, slots=20)] == [2] * 20


# --- sweeps ---------------------------------------------------------------------------------------


def test_a_longer_axis_keeps_the_way_up(shell: Shell) -> None:
    write("a.yaml", LINE, LOOSE)
    assert shell("sweep", "a.yaml", "-o", "a.nc").code == 0
    write("a.yaml", LINE.replace("18.5]", "18.5, 19]"), LOOSE)
    code, _, err = shell("sweep", "a.yaml", "-o", "a.nc")
    assert (code, err) == (0, "28 points (2 x 7 x 2): 12 in a.nc; 16 to compute\n")
    assert hash_of("a.nc") == hash_at_once("a.yaml")


def test_points_without_following_are_different_points(shell: Shell) -> None:
    write("a.yaml", LINE.replace("follow: omega\n", ""), LOOSE)
    assert shell("sweep", "a.yaml", "-o", "a.nc").code == 0
    write("a.yaml", LINE, LOOSE)
    code, _, err = shell("sweep", "a.yaml", "-o", "a.nc")
    assert code == 2
    assert "follow: not set -> angular_frequency" in err


def test_retrying_a_point_computes_its_whole_line(shell: Shell) -> None:
    write("a.yaml", LINE, LOOSE)
    shell.disturb = None
    command = ["sweep", "a.yaml", "-o", "a.nc"]
    assert shell(*command, "--set", "stationary.max_periods=5").code == 3
    failed = int((open_result(Path("a.nc")).status != 0).sum())
    assert 0 < failed < 24
    code, _, err = shell(*command, "--set", "stationary.max_periods=5", "--retry-failed")
    assert code == 3
    lines = xr.open_dataset("a.nc").status.stack(line=["temperature"])
    broken = int((lines != 0).any(["angular_frequency", "direction"]).sum())
    assert f"; {12 * broken} to compute" in err


def test_a_plan_counts_lines(shell: Shell) -> None:
    write("a.yaml", LINE, LOOSE)
    code, out, _ = shell("plan", "a.yaml", "-o", "a.nc")
    assert code == 0
    assert "points: 24" in out
    assert "from a sample of 24" in out
    assert "blocks: 2" in out  # a line each, one for each worker


def test_a_plan_expects_whole_lines_where_a_point_is_missing(shell: Shell) -> None:
    write("a.yaml", LINE, LOOSE)
    shell.ok("sweep", "a.yaml", "-o", "a.nc", "--set", "omega=[14, 14.5, 15, 15.5, 18]")
    out = shell.ok("plan", "a.yaml", "-o", "a.nc").out
    assert "points: 24, 10 already computed" in out  # those upward
    assert "from a sample of 14;" in out  # whose blocks take the time of 24


def test_a_line_has_one_worker(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Costs, "estimate", lambda _costs, points, slots: float(points // slots))
    axes = {"T": [200, 210], "omega": [14, 14.5]}
    config = from_mapping({"sweep": axes, "follow": "omega", "execution": {"workers": 16}})
    planned = plan(config, tmp_path / "a.nc")
    assert (planned.blocks, planned.seconds) == (2, 4.0)
