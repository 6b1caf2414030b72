"""Sobol indices over a box: the estimator, points without a result, and invalid boxes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy.stats import sobol_indices

from stickslip import ParameterError, indices, sensitivity_indices, stationary_orbits
from stickslip.boxes import BoxError, Design
from stickslip.distributions import Range
from stickslip.indices import indices_of, results_named, saltelli
from stickslip.regime import Regime
from stickslip.status import Status
from stickslip.variables import RESULT_COLUMNS

FORCE = RESULT_COLUMNS.index("friction_force_amplitude")
STRESS = RESULT_COLUMNS.index("elastic_stress_amplitude")
THREE = {name: Range(-math.pi, math.pi) for name in ("x_0", "v_0", "rheological_index")}


def ishigami(design: Design, a: float = 7.0, b: float = 0.1) -> np.ndarray:
    """Return the values (d + 2, n) of Ishigami's function, whose indices are known."""
    first, second, third = design.columns.values()
    return np.sin(first) + a * np.sin(second) ** 2 + b * third**4 * np.sin(first)


def rows_with(**columns: np.ndarray) -> np.ndarray:
    """Return result rows with these columns; the regime is liquid."""
    rows = np.zeros((next(iter(columns.values())).size, len(RESULT_COLUMNS)))
    rows[:, RESULT_COLUMNS.index("regime")] = Regime.LIQUID
    for name, values in columns.items():
        rows[:, RESULT_COLUMNS.index(name)] = values.ravel()
    return rows


@pytest.fixture(scope="module")
def design() -> Design:
    return Design.of(THREE, 256, seed=5)


def test_the_indices_of_ishigami_are_in_their_intervals() -> None:
    design = Design.of(THREE, 1024, seed=5)
    rows = rows_with(friction_force_amplitude=ishigami(design))
    ds = indices_of(design, rows, ["friction_force_amplitude"])
    for order, exact in (
        ("first_order", (0.3139, 0.4424, 0.0)),
        ("total_order", (0.5576, 0.4424, 0.2437)),
    ):
        low, high = ds[f"{order}_interval"][0].T.values
        assert (low < exact).all(), order
        assert (exact < high).all(), order
        assert (high - low < 0.25).all(), order


def test_the_estimator_agrees_with_scipy(design: Design) -> None:
    values = ishigami(design)
    given = {"f_A": values[:1], "f_B": values[1:2], "f_AB": values[2:, None]}
    known = sobol_indices(func=given, n=values.shape[1])
    found = saltelli(values - values[:2].mean())
    np.testing.assert_allclose(found, [known.first_order, known.total_order], rtol=1e-13)


def test_base_points_without_a_result_are_left_out_entirely(design: Design) -> None:
    values, lost = ishigami(design), np.array([3, 50, 51])
    rows, there = values.copy(), np.delete(values, lost, axis=1)
    rows[(0, 2, 4), lost] = np.nan  # in A, and in two of the mixtures
    result = rows_with(friction_force_amplitude=rows)
    ds = indices_of(design, result, ["friction_force_amplitude"])
    expected = saltelli(there - there[:2].mean())
    # Up to the order of sums, because the same points are in other arrays.
    found = [ds.first_order[0], ds.total_order[0]]
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-14)
    assert ds.attrs["base_points_without_result"] == 3
    assert ds.attrs["base_points"] == 256


def test_too_many_points_without_a_result_are_refused(design: Design) -> None:
    values = ishigami(design)
    values[0, :6] = np.nan
    rows = rows_with(friction_force_amplitude=values)
    with pytest.raises(BoxError, match=r"6 of 256 base points .* smaller box"):
        indices_of(design, rows, ["friction_force_amplitude"])
    indices_of(design, rows, ["friction_force_amplitude"], largest_missing=0.03)


def test_a_variable_that_few_motions_have_is_refused_by_name(design: Design) -> None:
    """All points have a result, so neither more periods nor a larger share would help."""
    amplitudes = ishigami(design)
    rows = rows_with(
        friction_force_amplitude=amplitudes, lyapunov_exponent=np.full_like(amplitudes, np.nan)
    )
    with pytest.raises(BoxError, match="not every motion in the box has lyapunov_exponent;"):
        indices_of(design, rows, ["friction_force_amplitude", "lyapunov_exponent"])


def test_a_result_that_does_not_vary_has_no_indices(design: Design) -> None:
    rows = rows_with(
        friction_force_amplitude=ishigami(design),
        elastic_stress_amplitude=np.full((5, 256), 3.0) * (1 + 1e-15 * ishigami(design)),
    )
    names = ["friction_force_amplitude", "elastic_stress_amplitude"]
    ds = indices_of(design, rows, names)
    assert ds.first_order[0].notnull().all()
    assert ds.total_order[1].isnull().all()
    assert ds.total_order_interval[1].isnull().all()


def test_a_parameter_without_influence_has_the_index_0(design: Design) -> None:
    first, second, _ = design.columns.values()
    rows = rows_with(friction_force_amplitude=first + 2 * second)
    ds = indices_of(design, rows, ["friction_force_amplitude"])
    assert ds.total_order[0].values[2] == 0.0
    assert ds.total_order_interval[0, 2].values.tolist() == [0.0, 0.0]


def test_a_result_that_varies_at_few_points_has_no_intervals(design: Design) -> None:
    values = np.zeros((5, 256))
    values[:, :4] = ishigami(design)[:, :4]
    ds = indices_of(
        design, rows_with(friction_force_amplitude=values), ["friction_force_amplitude"]
    )
    assert ds.total_order.notnull().all()
    assert ds.first_order_interval.isnull().all()  # a sample may have none of the four points
    assert ds.total_order_interval.isnull().all()


def test_counts_of_points_without_a_result_do_not_enter(design: Design) -> None:
    counts = np.round(4.0 + ishigami(design))
    statuses = np.zeros_like(counts)
    counts[2, 7], statuses[2, 7] = -1.0, Status.FAILED
    ds = indices_of(design, rows_with(melting_count=counts, status=statuses), ["melting_count"])
    assert ds.attrs["base_points_without_result"] == 1
    assert float(ds["mean"][0]) == pytest.approx(np.delete(counts[:2], 7, axis=1).mean())


def test_a_mixture_has_one_parameter_of_the_other_matrix(design: Design) -> None:
    for i, column in enumerate(design.columns.values()):
        in_A, in_B, *mixed = column
        for j, values in enumerate(mixed):
            np.testing.assert_array_equal(values, in_B if i == j else in_A)
        assert not np.array_equal(in_A, in_B)


def test_a_logarithmic_range_is_drawn_evenly_in_the_logarithm() -> None:
    drawn = Design.of({"spring_stiffness": Range(500.0, 5e4, True)}, 256, 0).columns
    exponents = np.log10(drawn["spring_stiffness"][:2])
    assert exponents.min() >= math.log10(500)
    np.testing.assert_allclose(exponents.mean(axis=1), math.log10(5000), atol=0.01)


def test_orbits_are_computed_at_the_points_of_the_design() -> None:
    box = {"T": (255, 300), "k": {"log": (2e4, 2e5)}, "gamma": 0}
    ds = sensitivity_indices(box, base_points=16, seed=3)
    ranges = {
        "temperature": Range(255.0, 300.0),
        "viscosity_coefficient": Range(2e4, 2e5, True),
    }
    design = Design.of(ranges, 16, 3)
    force = stationary_orbits(design.points() | {"gamma": 0.0}).friction_force_amplitude.values
    force = force.reshape(4, 16)
    expected = saltelli(force - force[:2].mean())
    np.testing.assert_array_equal([ds.first_order[1], ds.total_order[1]], expected)
    assert float(ds["mean"][1]) == pytest.approx(force[:2].mean(), rel=1e-14)
    assert float(ds.regime_share.sum()) == pytest.approx(1.0)
    assert float(ds.rheological_index) == 0.0


@pytest.mark.parametrize(
    ("box", "error", "message"),
    [
        ({"T": 200}, BoxError, "no parameter varies"),
        ({"T": (280, 200)}, BoxError, "temperature: must rise"),
        ({"gamma": {"log": (-0.5, 1)}}, BoxError, "two values above 0 for a logarithm"),
        (
            {"T": {"normal": (math.nan, 1)}},
            BoxError,
            "temperature: the mean must be a finite number",
        ),
        (
            {"k": {"lognormal": (1e4, math.inf)}},
            BoxError,
            "deviation must be a number above 0, not",
        ),
        ({"T": (200, 250, 300)}, BoxError, r"temperature: must be \[low, high\], "),
        ({"T": "warm", "k": (1e4, 2e4)}, ParameterError, "temperature must be a number"),
        ({"T": (-5, 200)}, ParameterError, "temperature"),
        ({"warmth": (200, 300)}, TypeError, "warmth"),
    ],
)
def test_an_invalid_box_is_refused(
    box: dict[str, object], error: type[Exception], message: str
) -> None:
    with pytest.raises(error, match=message):
        sensitivity_indices(box, base_points=8)


def test_a_fixed_parameter_may_be_a_scalar_of_a_result(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(indices, "orbit_rows", lambda rows, _: rows_with(asymmetry=rows[:, 0]))
    of_a_result = xr.Dataset(coords={"spring_stiffness": 500.0, "temperature": 250.0})
    box = {"T": (200, 280), "K": of_a_result.spring_stiffness, "omega": np.float32(32)}
    ds = sensitivity_indices(box, "asymmetry", base_points=4)
    assert (float(ds.spring_stiffness), float(ds.angular_frequency)) == (500.0, 32.0)
    assert "temperature" not in ds.coords


def test_results_have_symbols_too() -> None:
    assert results_named(["F_max", "W"]) == ["friction_force_amplitude", "dissipated_energy"]
    with pytest.raises(BoxError, match="friction_force_amplitude is named twice"):
        results_named(["F_max", "friction_force_amplitude"])


def test_base_points_are_a_power_of_2_and_results_have_names() -> None:
    with pytest.raises(BoxError, match=r"power of 2.* 1024, not 1000"):
        sensitivity_indices({"T": (200, 280)}, base_points=1000)
    with pytest.raises(BoxError, match="no result force; there are elastic_stress_amplitude"):
        sensitivity_indices({"T": (200, 280)}, of="force")


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        ({"confidence": 95}, "confidence must be between 0 and 1, not 95"),
        ({"largest_missing": 2}, "the largest share of missing base points must be from 0 to 1"),
    ],
)
def test_levels_and_shares_are_refused_before_anything_is_computed(
    monkeypatch: pytest.MonkeyPatch, limits: dict[str, Any], message: str
) -> None:
    monkeypatch.setattr(indices, "orbit_rows", lambda *_: pytest.fail("orbits were computed"))
    with pytest.raises(BoxError, match=message):
        sensitivity_indices({"T": (255, 300)}, base_points=2, **limits)


def test_the_box_is_named_by_its_distributions() -> None:
    box = {"T": (200.0, 240.0), "k": {"lognormal": (5e4, 0.2)}}
    ds = sensitivity_indices(box, base_points=4, largest_missing=1.0)
    assert ds.distribution.values.tolist() == [
        "[200, 240]",
        "lognormal [50000, 0.20000000000000001]",
    ]
    assert ds.stickslip is not None
    with pytest.raises(BoxError, match=r"base points must be a whole number, not 16.0"):
        sensitivity_indices(box, base_points=16.0)  # type: ignore[arg-type]
