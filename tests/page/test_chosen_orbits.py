"""The choice of points with an orbit in a page, the nearest orbit, and thinning."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import qmc
from support.pictures import failed, random_cases, sweep

from stickslip.status import Status

pytest.importorskip("bokeh", reason="bokeh is not installed")

from sweeps.page.chosen_orbits import chosen_points, nearest_chosen, start_along, thinned

T, K = np.linspace(150.0, 320.0, 30), np.linspace(500.0, 5000.0, 20)


@pytest.fixture
def ds():
    """Return a map that is liquid in its right third, with an asymmetric and a failed point."""
    ds = sweep(temperature=T, spring_stiffness=K)
    regime = np.where(np.arange(30)[:, None] >= 20, 0, 2) * np.ones((30, 20), dtype="i1")
    regime[4, 7] = 3
    return failed(
        ds.assign(regime=(("temperature", "spring_stiffness"), regime.astype("i1"))),
        Status.DIVERGED, temperature=2, spring_stiffness=3,
    )  # fmt: skip


def start_of(ds):
    return int(np.ravel_multi_index([start_along(ds, dim) for dim in ds.status.dims], (30, 20)))


def test_the_point_where_the_page_opens_comes_first_unless_it_is_still_to_be_computed(ds):
    start = start_of(ds)
    assert chosen_points(ds, 1).tolist() == [start]
    for most in (2, 10, 50):
        assert start in chosen_points(ds, most)
    ds["status"].values.flat[start] = Status.PENDING
    assert start not in chosen_points(ds, 10_000)


def test_failed_points_are_next_and_the_number_is_limited(ds):
    assert chosen_points(ds, 2).tolist() == sorted([2 * 20 + 3, start_of(ds)])
    assert chosen_points(ds, 0).size == 0
    assert np.unique(chosen_points(ds, 50)).size == 50
    assert chosen_points(ds, 10_000).size == 600


def test_both_sides_of_every_kind_of_boundary_are_chosen(ds):
    columns, rows = np.unravel_index(chosen_points(ds, 50), (30, 20))
    assert np.isin([19, 20], columns).all()
    assert (4, 7) in set(zip(columns.tolist(), rows.tolist(), strict=True))
    both = set(rows[columns == 19]) & set(rows[columns == 20])
    assert len(both) > 2


def test_the_others_are_spread_over_all_of_the_map():
    columns, rows = np.unravel_index(
        chosen_points(sweep(temperature=T, spring_stiffness=K), 60), (30, 20)
    )
    counts, _, _ = np.histogram2d(columns, rows, bins=(3, 2), range=((0, 30), (0, 20)))
    assert counts.min() >= 8


def test_a_single_point_and_a_line_have_orbits_too():
    assert chosen_points(sweep(), 5).tolist() == [0]
    assert chosen_points(sweep(), 0).size == 0
    assert chosen_points(sweep(temperature=T), 7).size == 7
    assert nearest_chosen(sweep(), np.array([0])).tolist() == [0]


def test_the_nearest_orbit_is_one_of_the_same_fluid_where_there_is_one():
    ds = sweep(temperature=T, rheological_index=[-0.5, 0.0])
    near = nearest_chosen(ds, np.array([0, 59])).reshape(30, 2)
    assert near[[0, 9, 20, 29]].tolist() == [[0, 1]] * 4
    assert nearest_chosen(ds, np.array([0])).tolist() == [0] * 60


def test_the_nearest_orbit_is_one_of_the_same_kind_where_there_is_one(ds):
    beside, far, liquid = 4 * 20 + 8, 15 * 20 + 10, 29 * 20 + 19
    near = nearest_chosen(ds, np.array([beside, 4 * 20 + 7, far, liquid])).reshape(30, 20)
    assert near[4, 7] == 1
    assert near[19, 19] == 2  # though the liquid one is nearer
    assert near[4, 6] == near[4, 8] == 0
    assert (near[20:] == 3).all()
    assert nearest_chosen(ds, np.array([far, liquid]))[4 * 20 + 7] == 0  # any: none is asymmetric


def test_points_in_the_whole_box_of_a_sobol_sequence_have_orbits():
    ds = random_cases(1024, temperature=(150.0, 320.0), spring_stiffness=(100.0, 1e4))
    drawn = qmc.scale(qmc.Sobol(2, rng=1).random(1024), [150.0, 100.0], [320.0, 1e4])
    names = ("temperature", "spring_stiffness")
    ds = ds.assign_coords({n: ("case", v) for n, v in zip(names, drawn.T, strict=True)})
    chosen = chosen_points(ds, 200)
    counts, *_ = np.histogram2d(*drawn[chosen].T, bins=4, range=[(150.0, 320.0), (100.0, 1e4)])
    assert counts.min() >= 4


def test_among_cases_in_no_order_the_nearest_has_similar_parameters():
    ds = random_cases(60, temperature=(150.0, 320.0), spring_stiffness=(100.0, 1e4))
    chosen = np.array([5, 17, 40])
    scaled = np.stack(
        [ds.temperature.values / np.ptp(ds.temperature.values),
         np.log(ds.spring_stiffness.values) / np.ptp(np.log(ds.spring_stiffness.values))], axis=-1
    )  # fmt: skip
    distances = np.linalg.norm(scaled[:, None] - scaled[chosen], axis=-1)
    alike = ds.drop_vars("regime")
    assert nearest_chosen(alike, chosen).tolist() == distances.argmin(axis=1).tolist()


# --- courses --------------------------------------------------------------------------------------


def test_lines_between_the_kept_samples_reproduce_the_curves():
    time = np.linspace(0.0, 1.0, 4001)
    heights = np.stack([np.sin(20 * time), np.where(time < 0.3, 0.0, 5.0), np.zeros_like(time)])
    kept = thinned(np.stack([time, *heights]))
    assert 20 < kept.size < 1000
    for height in heights:
        missed = np.abs(np.interp(time, time[kept], height[kept]) - height).max()
        assert missed <= 1e-3 * max(np.ptp(height), 1e-300)
