"""The identity of points: parameters and settings, and nothing that leaves numbers unchanged."""

from __future__ import annotations

import tracemalloc
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stickslip.kernels.version import NUMERICS_VERSION
from stickslip.parameters import Parameters
from sweeps.config.load import from_mapping
from sweeps.grid import Grid
from sweeps.identity import PointKeys, differences, near_duplicates, settings_of

CONFIG: dict[str, Any] = {
    "model": {"M": 0.5},
    "sweep": {"T": [150, 200, 250], "gamma": [0, "2/3"]},
    "cases": {"X_m": [4e-7, 8e-7], "omega": [20, 10]},
}


def grid_of(**changes: Any) -> Grid:
    return Grid.from_config(from_mapping(CONFIG | changes))


def keys(**changes: Any) -> list[bytes]:
    """Return the key of each point of a config."""
    config = from_mapping(CONFIG | changes)
    grid = Grid.from_config(config)
    found = PointKeys(grid, settings_of(config)).of(np.arange(grid.size))
    return [key.tobytes() for key in found]


def settings(**changes: Any) -> dict[str, Any]:
    return dict(settings_of(from_mapping(CONFIG | changes)))


def test_the_settings_of_an_adaptive_sweep() -> None:
    assert settings() == {
        "integrator.method": "adaptive",
        "integrator.rtol": 1e-6,
        "stationary.rtol": 1e-6,
        "stationary.max_periods": 5000,
        "stationary.accelerate": True,
        "noise.treatment": "typical-path",
        "integrator.max_error": 0.01,
        "stationary.window": 200,
        "film.friction": "power-law",
        "film.strain": "adiabatic",
    }


def test_the_settings_of_a_fixed_step() -> None:
    found = settings(integrator={"method": "euler-cromer", "dt": 1e-9, "max_steps": 10})
    assert found["integrator.dt"] == 1e-9
    assert found["integrator.max_steps"] == 10
    assert "integrator.rtol" not in found


def test_the_version_of_the_numerics_enters_the_keys(monkeypatch: pytest.MonkeyPatch) -> None:
    before = {*keys()}
    monkeypatch.setattr("sweeps.identity.NUMERICS_VERSION", NUMERICS_VERSION + 1)
    assert not before & {*keys()}


def test_each_difference_is_a_line() -> None:
    old = settings()
    assert differences(old, settings()) == []
    new = settings(
        integrator={"rtol": 1e-5, "max_steps": 10},
        stationary={"accelerate": False},
    )
    assert differences(old, new) == [
        "integrator.rtol: 1e-06 -> 1e-05",
        "stationary.accelerate: True -> False",
        "integrator.max_steps: not set -> 10",
    ]
    assert differences(new, old)[-1] == "stationary.accelerate: False -> True"
    assert "integrator.max_steps: 10 -> not set" in differences(new, old)
    fixed = settings(integrator={"method": "euler-cromer"})
    assert differences(old, fixed) == [
        "integrator.method: adaptive -> euler-cromer",
        "integrator.rtol: 1e-06 -> not set",
        "integrator.dt: not set -> 1e-10",
    ]


CHANGES: dict[str, dict[str, Any]] = {
    "tolerance": {"integrator": {"rtol": 1e-5}},
    "method": {"integrator": {"method": "euler-cromer"}},
    "step": {"integrator": {"method": "euler-cromer", "dt": 1e-9}},
    "budget of steps": {"integrator": {"max_steps": 10**6}},
    "stationary tolerance": {"stationary": {"rtol": 1e-5}},
    "budget of periods": {"stationary": {"max_periods": 4999}},
    "acceleration": {"stationary": {"accelerate": False}},
    "noise": {"model": {"M": 0.5, "phi_0": 0.5}, "noise": {"treatment": "none"}},
    "start without that noise": {"model": {"M": 0.5, "phi_0": 0.5}},
    "fixed value, by a bit": {"model": {"M": np.nextafter(0.5, 1.0).item()}},
    "another fixed value": {"model": {"M": 0.5, "K": 2999.0}},
    "two fixed values exchanged": {"model": {"M": 1.0, "h": 0.5}},
    "... and back": {"model": {"M": 0.5, "h": 1.0}},
    "a case paired otherwise": {"cases": {"X_m": [4e-7, 8e-7], "omega": [10, 20]}},
    "followed": {"cases": {}, "follow": "T"},
    "followed along another axis": {"cases": {}, "follow": "gamma"},
}


def test_every_key_changes_with_whatever_changes_a_point() -> None:
    found = [keys(), *(keys(**changes) for changes in CHANGES.values())]
    assert len({key for each in found for key in each}) == sum(map(len, found))


ELSEWHERE: dict[str, dict[str, Any]] = {
    "order of the values": {"sweep": {"T": [200, 150, 250], "gamma": [0, "2/3"]}},
    "one value more": {"sweep": {"T": [150, 200, 250, 300], "gamma": [0, "2/3"]}},
    "one value less": {"sweep": {"T": [150, 200], "gamma": [0, "2/3"]}},
    "order of the axes": {"sweep": {"gamma": [0, "2/3"], "T": [150, 200, 250]}},
    "an axis more": {"sweep": {"T": [150, 200, 250], "gamma": [0, "2/3"], "K": [3000]}},
    "another direction": {"sweep": {"T": [150, 200, 250]}, "model": {"M": 0.5, "gamma": -0.0}},
    "an axis of one value": {
        "sweep": {"T": [150, 200, 250], "gamma": [0, "2/3"], "M": [0.5]},
        "model": {},
    },
    "order of the cases": {"cases": {"X_m": [8e-7, 4e-7], "omega": [10, 20]}},
    "an axis instead of cases": {
        "sweep": CONFIG["sweep"] | {"X_m": [4e-7, 8e-7], "omega": [20, 10]},
        "cases": {},
    },
}


@pytest.mark.parametrize("name", ELSEWHERE)
def test_a_point_has_one_key_wherever_it_lies(name: str) -> None:
    config = from_mapping(CONFIG | ELSEWHERE[name])
    mine, theirs = grid_of(), Grid.from_config(config)
    other = PointKeys(theirs, settings_of(config))
    found = other.find(PointKeys(mine, settings()).of(np.arange(mine.size)))
    rows = {row.tobytes(): n for n, row in enumerate(theirs.rows(np.arange(theirs.size)) + 0.0)}
    there = [rows.get(row.tobytes(), -1) for row in mine.rows(np.arange(mine.size)) + 0.0]
    assert found.tolist() == there
    assert (found >= 0).any()
    np.testing.assert_array_equal(other.numbers_of(mine.rows(np.arange(mine.size))), found)


def points_of(grid: Grid) -> list[Parameters]:
    return [Parameters(*row) for row in grid.points(0, grid.size)]


def located(grid: Grid, points: np.ndarray) -> np.ndarray:
    return PointKeys(grid, {}, alone=True).numbers_of(points)


values = st.sampled_from([0.5, 1.0, 1.5, 2.0, 250.0, 1e4])


@st.composite
def grids(draw: st.DrawFn) -> Grid:
    """Draw up to three axes, and cases, with values that other grids are likely to share.

    The second parameter of the cases repeats values.
    """
    mapping: dict[str, dict[str, object]] = {"model": {"M": draw(values)}, "sweep": {}, "cases": {}}
    for name in draw(st.permutations(["T", "k", "K"]))[: draw(st.integers(0, 3))]:
        mapping["sweep"][name] = draw(st.lists(values, min_size=1, max_size=4, unique=True))
    count = draw(st.integers(0, 4))
    if count:
        linked = draw(
            st.lists(
                st.tuples(values, st.sampled_from([1.0, 2.0])),
                min_size=count,
                max_size=count,
                unique=True,
            )
        )
        mapping["cases"] = {"omega": [a for a, _ in linked], "X_m": [b for _, b in linked]}
    return Grid.from_config(from_mapping(mapping))


@given(here=grids(), there=grids())
def test_a_point_is_found_in_another_grid_if_and_only_if_all_parameters_are_equal(
    here: Grid, there: Grid
) -> None:
    numbers = {row: number for number, row in enumerate(points_of(there))}
    expected = [numbers.get(row, -1) for row in points_of(here)]
    assert located(there, here.points(0, here.size)).tolist() == expected
    assert located(here, here.points(0, here.size)).tolist() == [*range(here.size)]


@pytest.mark.parametrize("form", ["linspace", "geomspace"])
def test_a_refined_grid_has_the_points_of_the_coarse_one(form: str) -> None:
    def axis(ends: list[float], count: int) -> dict[str, object]:
        return {form: ends, "num": count}

    coarse, fine = (
        Grid.from_config(
            from_mapping({"sweep": {"T": axis([150, 320], n), "k": axis([1e4, 2e5], m)}})
        )
        for n, m in ((18, 20), (171, 39))
    )
    found = located(fine, coarse.points(0, coarse.size))
    expected = np.arange(0, 171, 10)[:, None] * 39 + np.arange(0, 39, 2)
    np.testing.assert_array_equal(found, expected.ravel())
    back = located(coarse, fine.points(0, fine.size))
    assert (back >= 0).sum() == coarse.size


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e-300])
def test_a_row_with_a_value_that_no_axis_has_is_not_found(value: float) -> None:
    grid = Grid.from_config(from_mapping(CONFIG))
    everything = np.repeat(grid.points(5, 6), 20, axis=0)
    everything[np.arange(20), np.arange(20)] = value
    assert located(grid, everything).tolist() == [-1] * 20
    everything = np.repeat(grid.points(5, 6), 20, axis=0)
    bit = np.nextafter(everything, np.inf)
    everything[np.arange(20), np.arange(20)] = bit[np.arange(20), np.arange(20)]
    assert located(grid, everything).tolist() == [-1] * 20


def test_many_linked_lists_of_many_values_are_distinguished() -> None:
    rng, count = np.random.default_rng(1), 1024
    names = Parameters._fields[:12]
    cases = {name: ((1.0 + rng.permutation(count)) / count).tolist() for name in names}
    grid = Grid.from_config(from_mapping({"cases": cases}))
    found = located(grid, grid.points(0, count)[::-1])
    np.testing.assert_array_equal(found, np.arange(count)[::-1])
    mixed = grid.points(0, count)
    mixed[:, 0] = np.roll(mixed[:, 0], 1)  # each value is known, but not together
    assert (located(grid, mixed) == -1).all()


def test_keys_that_begin_alike_are_distinguished(monkeypatch: pytest.MonkeyPatch) -> None:
    """This happens to a few of ten million points, and here to all."""
    whole = PointKeys.of

    def alike(self: PointKeys, numbers: np.ndarray) -> np.ndarray:
        found = whole(self, numbers)
        found[:, 0] &= np.uint64(0xFF)
        found[:, 0] |= np.uint64(1 << 63)
        return found

    monkeypatch.setattr(PointKeys, "of", alike)
    grid = grid_of()
    known = PointKeys(grid, settings())
    numbers = np.random.default_rng(1).permutation(grid.size)
    assert known.find(known.of(numbers)).tolist() == numbers.tolist()
    strange = PointKeys(grid, settings(integrator={"rtol": 1e-5})).of(numbers)
    assert (known.find(strange) == -1).all()


def test_keys_that_were_released_take_no_memory_and_are_found_again() -> None:
    grid = grid_of(sweep={"T": {"linspace": [150, 250], "num": 10_000}})
    known, some = PointKeys(grid, settings()), np.arange(grid.size)[::1000]
    held = []
    tracemalloc.start()
    for _ in range(2):
        assert known.find(known.of(some)).tolist() == some.tolist()
        held.append(tracemalloc.get_traced_memory()[0])
        known.release()
        held.append(tracemalloc.get_traced_memory()[0])
    tracemalloc.stop()
    assert min(held[0] - held[1], held[2] - held[3]) >= 8 * grid.size


def test_a_setting_at_its_default_changes_no_key() -> None:
    grid, full = grid_of(), settings()
    shorter = {name: v for name, v in full.items() if name != "stationary.window"}
    numbers = np.arange(grid.size)
    np.testing.assert_array_equal(
        PointKeys(grid, full).of(numbers), PointKeys(grid, shorter).of(numbers)
    )


FOLLOWED = {"sweep": {"omega": [10, 11, 12], "T": [200, 210]}, "follow": "omega"}


@pytest.mark.parametrize(
    ("omega", "kept"),
    [
        ([10, 11, 12], {"up": 3, "down": 3}),
        ([10, 11, 12, 13], {"up": 3, "down": 0}),
        ([10, 11, 11.5, 12], {"up": 2, "down": 0}),
        ([9, 10, 11, 12], {"up": 0, "down": 0}),
    ],
)
def test_the_key_of_a_followed_point_encodes_the_earlier_points(
    omega: list[float], kept: dict[str, int]
) -> None:
    old = from_mapping(FOLLOWED)
    new = from_mapping(FOLLOWED | {"sweep": {"omega": omega, "T": [200, 210]}})
    mine, theirs = (PointKeys(Grid.from_config(each), settings_of(each)) for each in (old, new))
    grid = Grid.from_config(old)
    found = theirs.find(mine.of(np.arange(grid.size))).reshape(grid.shape)
    for way, count in enumerate(kept.values()):
        assert (found[:, :, way] >= 0).sum() == 2 * count
    alone = PointKeys(Grid.from_config(new), settings_of(new), alone=True)
    assert (alone.numbers_of(grid.rows(np.arange(grid.size))) % 2 == 0).all()  # the upward ones


@pytest.mark.parametrize(
    "changes",
    [
        {"title": "another"},
        {"output": "elsewhere.nc"},
        {"execution": {"workers": 7, "block_points": 3, "backend": "loky"}},
        {"plot": {"figure": "time_courses"}},
        {"simulation": {"periods": 3}},
        {"integrator": {"rtol": 1e-6}},
        {"model": {"M": 0.5, "K": 3000}},
        {"sweep": {"temperature": {"arange": [150, 250, 50]}, "rheological_index": [0, "2/3"]}},
        {"cases": {"omega": [20, 10], "X_m": [4e-7, 8e-7]}},
    ],
)
def test_no_key_changes_with_what_changes_no_number(changes: dict[str, Any]) -> None:
    assert keys(**changes) == keys()


@pytest.mark.parametrize(
    ("old", "new", "pairs"),
    [
        ([150, 200], [150, 200], []),
        ([150, 200], [150.1, 200.1], []),
        ([150, 200, 250], [150, 200.00000001, 250], ["200.0 and 200.00000001"]),
        ([150, 200, 250], [150, 199.99999999, 250], ["200.0 and 199.99999999"]),
        ([150, 200, 250], [150, 200, 200.00000001], ["200.0 and 200.00000001"]),
        ([250, 150, 200], [200.00000001, 100], ["200.0 and 200.00000001"]),
        ([150, 200], [150, 200.0000004], []),
        ([250], [249.99999999, 250.1], ["250.0 and 249.99999999"]),
    ],
)
def test_values_that_differ_by_rounding_are_found(
    old: list[float], new: list[float], pairs: list[str]
) -> None:
    first, second = grid_of(sweep={"T": old}), grid_of(sweep={"T": new})
    assert near_duplicates(first, second) == [f"temperature {pair}" for pair in pairs]


def test_near_duplicates_are_found_whether_fixed_swept_or_linked() -> None:
    old = grid_of()
    near = 0.5 * (1.0 + 1e-12)
    lines = [f"block_mass 0.5 and {near!r}"]
    assert set(near_duplicates(old, grid_of(model={"M": near}))) == set(lines)
    swept = grid_of(model={}, sweep={"M": [0.1, near, 1.0]})
    assert set(near_duplicates(old, swept)) == set(lines)
    linked = grid_of(model={}, cases={"M": [0.1, near], "omega": [20, 10]})
    assert set(near_duplicates(old, linked)) == set(lines)
    assert near_duplicates(old, grid_of(cases={"X_m": [4e-7], "omega": [20]})) == []
