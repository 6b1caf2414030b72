"""Refined grids: the points that are computed, and the values interpolated between them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from support.sweeps.sweeping import Shell, hash_at_once, hash_of, write

from stickslip import Status
from stickslip.regime import Regime
from stickslip.variables import RESULT_COLUMNS
from sweeps import run
from sweeps.config.load import from_mapping
from sweeps.config.refinement import Refine
from sweeps.engine.plan import plan
from sweeps.engine.refine import Refinement
from sweeps.engine.settings import read_config
from sweeps.files.netcdf import open_result
from sweeps.grid import Grid

COLUMN = {name: number for number, name in enumerate(RESULT_COLUMNS)}
T, OMEGA = np.linspace(200, 264, 33), np.linspace(10, 42, 33)

Law = Callable[[np.ndarray, np.ndarray], dict[str, np.ndarray]]


def grid_of(**more: list[float]) -> Grid:
    sweep = {"temperature": T.tolist(), "omega": OMEGA.tolist(), **more}
    return Grid.from_config(from_mapping({"sweep": sweep}))


def made(grid: Grid, law: Law) -> np.ndarray:
    """Result rows of a whole grid, with the columns that a law of (T, omega) gives."""
    rows, points = np.zeros((grid.size, len(RESULT_COLUMNS))), grid.points(0, grid.size)
    rows[:, COLUMN["elastic_stress_amplitude"]] = 4e6
    rows[:, COLUMN["friction_force_amplitude"]] = 2e-3
    rows[:, COLUMN["orbit_periods"]] = 1
    for name, values in law(points[:, 0], points[:, 4]).items():
        rows[:, COLUMN[name]] = values
    return rows


def refined(grid: Grid, full: np.ndarray, refine: Refine) -> tuple[np.ndarray, np.ndarray]:
    """Refine a grid whose rows are known; return the mask of computed points, and all rows."""
    rows, refinement = np.full_like(full, np.nan), Refinement(refine, grid)
    for needed in refinement.rounds(lambda: rows):
        assert needed[~np.isnan(rows[:, 0])].all()  # needed points stay needed
        rows[needed] = full[needed]
    computed = ~np.isnan(rows[:, 0])
    numbers, between = refinement.interpolated(rows)
    rows[numbers] = between
    return computed.reshape(grid.shape), rows


BOTH = Refine(axes=("temperature", "angular_frequency"), levels=3, where=[1e-2])


def flat(T: np.ndarray, omega: np.ndarray) -> dict[str, np.ndarray]:
    return {}


def tongue(T: np.ndarray, omega: np.ndarray) -> dict[str, np.ndarray]:
    """A thin slanted tongue of another regime, two steps wide."""
    return {"regime": np.where(np.abs(omega - 12 - 0.4 * (T - 200)) < 1.1, 3, 2)}


# --- computed points ------------------------------------------------------------------------------


def test_a_uniform_grid_needs_only_corners_and_middles() -> None:
    computed, rows = refined(grid_of(), made(grid_of(), flat), BOTH)
    expected = np.zeros((33, 33), dtype=bool)
    expected[::8, ::8] = expected[4::8, 4::8] = True
    np.testing.assert_array_equal(computed, expected)
    assert (rows[~computed.ravel(), COLUMN["status"]] == Status.INTERPOLATED).all()


def test_a_thin_tongue_is_followed_to_its_border() -> None:
    grid = grid_of()
    full = made(grid, tongue)
    computed, rows = refined(grid, full, BOTH)
    np.testing.assert_array_equal(rows[:, COLUMN["regime"]], full[:, COLUMN["regime"]])
    assert computed.mean() < 0.55


@pytest.mark.parametrize("name", ["regime", "orbit_periods", "melting_count"])
def test_any_change_of_kind_is_refined(name: str) -> None:
    grid = grid_of()
    full = made(grid, lambda T, _: {name: np.where(T < 221, 2, 1)})
    computed, rows = refined(grid, full, BOTH)
    np.testing.assert_array_equal(rows[:, COLUMN[name]], full[:, COLUMN[name]])
    assert computed[10:12].all()  # 220 and 222 K, the two sides of the border


def test_points_without_a_result_are_refined_around() -> None:
    grid = grid_of()

    def failing(T: np.ndarray, omega: np.ndarray) -> dict[str, np.ndarray]:
        return {"status": np.where(T < 211, float(Status.STEP_LIMIT), 0.0)}

    computed, rows = refined(grid, made(grid, failing), BOTH)
    assert computed[:7].all()
    expected = made(grid, failing)[:, COLUMN["status"]] == Status.STEP_LIMIT
    np.testing.assert_array_equal(rows[:, COLUMN["status"]] == Status.STEP_LIMIT, expected)


def test_a_middle_that_misses_is_refined_unless_only_the_regime_counts() -> None:
    grid = grid_of()

    def bump(T: np.ndarray, omega: np.ndarray) -> dict[str, np.ndarray]:
        return {"elastic_stress_amplitude": 4e6 * (1 + np.exp(-(((T - 230) / 6) ** 2)))}

    full = made(grid, bump)
    coarse, _ = refined(grid, full, Refine(axes=BOTH.axes, levels=3, where=["regime"]))
    fine, rows = refined(grid, full, BOTH)
    assert coarse.sum() < fine.sum()
    column = COLUMN["elastic_stress_amplitude"]
    assert np.abs(rows[:, column] / full[:, column] - 1).max() < 0.02


def test_slices_are_refined_on_their_own() -> None:
    grid = grid_of(rheological_index=[-0.5, 0.0])
    full = made(grid, tongue)
    full[1::2, COLUMN["regime"]] = 2  # no tongue for the second fluid
    computed, _ = refined(grid, full, BOTH)
    assert computed[..., 1].sum() == 5 * 5 + 4 * 4
    assert computed[..., 0].sum() > 200


def test_one_axis_or_three_are_refined_as_well() -> None:
    grid = grid_of()
    full = made(grid, lambda T, _: {"regime": np.where(T < 221, 2, 1)})
    computed, rows = refined(grid, full, Refine(axes=("temperature",), levels=3, where=[1e-2]))
    np.testing.assert_array_equal(rows[:, COLUMN["regime"]], full[:, COLUMN["regime"]])
    assert computed.sum() == 33 * (5 + 4 + 2 + 2)  # corners, middles, the way to the border
    cube = grid_of(spring_stiffness=list(range(1000, 1009)))
    three = Refine(axes=(*BOTH.axes, "spring_stiffness"), levels=3, where=[0.1])
    computed, _ = refined(cube, made(cube, flat), three)
    assert computed.sum() == 5 * 5 * 2 + 4 * 4 * 1


# --- interpolated points --------------------------------------------------------------------------


def test_interpolated_values_are_multilinear_with_the_errors_of_the_middles() -> None:
    grid = grid_of()

    def bowl(T: np.ndarray, omega: np.ndarray) -> dict[str, np.ndarray]:
        return {
            "elastic_stress_amplitude": 4e6 + 40.0 * (T - 232) ** 2 + 1e3 * T * omega,
            "amplitude_error": np.full_like(T, 1e-6),
        }

    full = made(grid, bowl)
    computed, rows = refined(grid, full, BOTH)
    between = ~computed.ravel()
    column, error = COLUMN["elastic_stress_amplitude"], COLUMN["amplitude_error"]
    miss = np.abs(rows[between, column] / full[between, column] - 1)
    assert 0 < miss.max() < 1e-2
    assert (miss <= rows[between, error]).all()
    assert np.median(rows[between, error]) < 30 * np.median(miss)
    assert (rows[between, COLUMN["periods_integrated"]] == 0).all()
    assert (rows[between, COLUMN["orbit_periods"]] == 1).all()


def test_an_interpolated_work_is_as_uncertain_as_its_corners_differ() -> None:
    grid = grid_of()

    def curved(T: np.ndarray, omega: np.ndarray) -> dict[str, np.ndarray]:
        return {
            "dissipated_energy": 1e-9 * np.sqrt(T - 199.0),
            "dissipated_energy_error": np.where(T < 230, 1e-15, 3e-12),
        }

    full = made(grid, curved)
    computed, rows = refined(grid, full, BOTH)
    work, error = COLUMN["dissipated_energy"], COLUMN["dissipated_energy_error"]
    between = ~computed.ravel()
    away = np.abs(rows[:, work] - full[:, work])
    assert (away <= rows[:, error])[between].all()
    assert away[between].max() > 1e-10  # nowhere near what the corners state
    np.testing.assert_array_equal(rows[~between, error], full[~between, error])
    edge = grid.points(0, grid.size)[:, 0] == 264.0
    assert rows[edge & between, error].min() >= 3e-12


def test_an_orbit_and_its_mirror_image_are_not_averaged() -> None:
    grid = grid_of()
    lean = np.random.default_rng(1).choice([-1, 1], grid.size)

    def leaning(T: np.ndarray, omega: np.ndarray) -> dict[str, np.ndarray]:
        high, low = np.where(lean > 0, 3e6, 1e6), np.where(lean > 0, -1e6, -3e6)
        return {"elastic_stress_max": high, "elastic_stress_min": low, "regime": np.full_like(T, 3)}

    _, rows = refined(grid, made(grid, leaning), BOTH)
    extrema = {tuple(pair) for pair in rows[:, [COLUMN["elastic_stress_max"], 3]].tolist()}
    assert extrema == {(3e6, -1e6), (1e6, -3e6)}


# --- sweeps ---------------------------------------------------------------------------------------

LOOSE = "integrator: {rtol: 1e-4}\nstationary: {rtol: 1e-4}\n"
AXES = "sweep: {T: {linspace: [180, 300], num: 17}, omega: {linspace: [10, 50], num: 17}}\n"
MAP = f"{AXES}refine: {{axes: [T, omega], levels: 2, where: [regime]}}\n"


def test_a_refined_file_is_the_whole_cube(shell: Shell) -> None:
    write("a.yaml", MAP, LOOSE)
    code, out, err = shell("sweep", "a.yaml", "-o", "a.nc")
    assert code == 0
    computed = len(set(shell.computed))  # doubtful points are computed again at once
    assert "289 points, " in out
    assert "interpolated: The point lies between computed points" in err
    ds, full = open_result(Path("a.nc")), run(write("b.yaml", AXES, LOOSE))
    filled = ds.status == Status.INTERPOLATED
    assert 40 < int(filled.sum()) < 250
    assert (ds.status == full.status).where(~filled, True).all()
    assert float((ds.regime != full.regime).mean()) < 0.02
    assert set(np.unique(ds.regime)) <= {*Regime}
    assert float(ds.elastic_stress_amplitude.isnull().sum()) == 0
    assert computed == 289 - int(filled.sum())


def test_a_plan_goes_from_the_coarse_points_to_all(shell: Shell) -> None:
    write("a.yaml", MAP, LOOSE)
    planned = plan(read_config("a.yaml"), Path("a.nc"))
    coarse, middles = 5 * 5, 4 * 4
    assert planned.least_seconds / planned.seconds == pytest.approx((coarse + middles) / 17**2)
    assert "less if much of the grid is interpolated" in shell("plan", "a.yaml").out


def test_a_finer_grid_computes_only_the_points_that_it_lacks(shell: Shell) -> None:
    write("a.yaml", MAP, LOOSE)
    shell.ok("sweep", "a.yaml", "-o", "a.nc")
    coarse = len(set(shell.computed))
    assert "nothing to do" in shell("sweep", "a.yaml", "-o", "a.nc").err
    write("a.yaml", AXES, LOOSE)  # without `refine` interpolated points are missing ones
    code, _, err = shell("sweep", "a.yaml", "-o", "a.nc")
    assert code == 0
    assert f"289 points (17 x 17): {coarse} in a.nc; {289 - coarse} to compute" in err
    assert len(set(shell.computed)) == 289 - coarse
    assert hash_of("a.nc") == hash_at_once("a.yaml")


def test_a_new_title_of_a_refined_result_needs_no_workers(
    shell: Shell, monkeypatch: pytest.MonkeyPatch
) -> None:
    write("a.yaml", MAP, LOOSE)
    shell.ok("sweep", "a.yaml", "-o", "a.nc")
    write("a.yaml", "title: new\n", MAP, LOOSE)
    assert "289 already computed" in shell("check", "a.yaml", "-o", "a.nc").out
    monkeypatch.delattr("sweeps.engine.sweep.make_executor")
    assert "289 in a.nc; 0 to compute" in shell.ok("sweep", "a.yaml", "-o", "a.nc").err
    assert hash_of("a.nc") == hash_at_once("a.yaml")


def test_a_kept_journal_has_the_interpolated_points_too(shell: Shell) -> None:
    write("a.yaml", MAP, LOOSE)
    shell.ok("sweep", "a.yaml", "-o", "a.nc", "--keep-journal")
    made = hash_of("a.nc")
    assert "a.nc: complete\n289 of 289 points done" in shell("status", "a.nc").out
    assert "289 already computed" in shell("check", "a.yaml", "-o", "a.nc").out
    assert "pending" not in shell.ok("sweep", "a.yaml", "-o", "a.nc", "--partial").out
    assert hash_of("a.nc") == made
