"""Agreement with 122 golden orbits of Figs. 5 to 9 by another solver (golden/README.md)."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from support.points import amplitude_errors, orbits

from stickslip import Parameters, Status, simulate
from stickslip.variables import BY_SYMBOL

_GOLDEN = Path(__file__).parents[1] / "golden" / "anchors.json"
_NAMES = {
    **BY_SYMBOL,
    "phi0": "initial_order_parameter",
    "x0": "initial_displacement",
}

ANCHORS = [
    anchor
    for anchor in json.loads(_GOLDEN.read_text(encoding="utf-8"))["points"]
    if anchor["status"] == "ok"
]


def parameters(changes: dict[str, float]) -> dict[str, float]:
    return {_NAMES[symbol]: value for symbol, value in changes.items()}


POINTS = np.array([Parameters(**parameters(anchor["changes"])) for anchor in ANCHORS])


def golden(field: str) -> np.ndarray:
    return np.array([anchor[field] for anchor in ANCHORS])


# The golden file says that two orbits close after two periods. They close after one, as
# `test_two_golden_orbits_close_after_one_period` shows, so a period has half the meltings.
CLOSE_AFTER_ONE = [
    ("fig7", {"gamma": 2 / 3, "T": 240.0}),
    ("fig8", {"gamma": -2 / 3, "k": 1e5}),
]


HALVED = np.array(
    [2 if (one["figure"], one["changes"]) in CLOSE_AFTER_ONE else 1 for one in ANCHORS]
)


@cache
def computed(**options: Any) -> SimpleNamespace:
    return orbits(POINTS, **options)


def tight() -> SimpleNamespace:
    return computed(rtol=1e-8, stationary_rtol=1e-8)


def errors(found: SimpleNamespace) -> np.ndarray:
    return amplitude_errors(found, POINTS, golden("sigma"), golden("force"))


def worst(found: SimpleNamespace) -> str:
    i = int(np.argmax(errors(found)))
    return f"{ANCHORS[i]['figure']} {ANCHORS[i]['changes']}: {errors(found)[i]:.2e}"


def test_no_golden_point_is_missing() -> None:
    assert len(ANCHORS) == 122
    assert np.count_nonzero(HALVED == 2) == len(CLOSE_AFTER_ONE)


@pytest.mark.slow
def test_amplitudes_agree_within_the_uncertainty_of_the_golden_ones() -> None:
    assert np.all(tight().status == Status.OK)
    # The anchors themselves miss their uncertainty by up to three times (T = 229 K in the README).
    uncertainty = np.maximum(3e-7, golden("spread"))
    at_229_K = np.array([anchor["changes"].get("T") == 229.0 for anchor in ANCHORS])
    assert np.all((errors(tight()) <= 3 * uncertainty) | at_229_K), worst(tight())
    assert np.all(errors(tight()) <= 3e-6), worst(tight())


def test_default_settings_are_better_than_the_promised_1e_4() -> None:
    # The measured error is 1.2e-6, the limit of the golden numbers; this is four times as much.
    assert np.all(computed().status == Status.OK)
    assert np.all(errors(computed()) <= 5e-6), worst(computed())


@pytest.mark.parametrize("compute", [computed, pytest.param(tight, marks=pytest.mark.slow)])
def test_periods_and_meltings_agree(compute: Callable[[], SimpleNamespace]) -> None:
    found = compute()
    np.testing.assert_array_equal(found.orbit_periods, golden("multiple") / HALVED)
    np.testing.assert_array_equal(found.melting_count, golden("melts") / HALVED)


@pytest.mark.slow
def test_extremes_agree() -> None:
    # If the stress is below 1e-2 of its scale, its sign depends on the noise of ln(phi).
    found, scale = tight(), np.maximum(golden("sigma"), 8e7)
    for field, column in (("sigma_max", "elastic_stress_max"), ("sigma_min", "elastic_stress_min")):
        assert np.all(np.abs(getattr(found, column) - golden(field)) <= 3e-6 * scale)
    scale = np.maximum(golden("force"), 4.8e-5)
    for field, column in (("force_max", "friction_force_max"), ("force_min", "friction_force_min")):
        assert np.all(np.abs(getattr(found, column) - golden(field)) <= 3e-6 * scale)


def test_asymmetric_orbits_agree() -> None:
    asymmetric = golden("asymmetry") > 1e-3
    np.testing.assert_array_equal(computed().asymmetry > 1e-3, asymmetric)
    np.testing.assert_allclose(
        computed().asymmetry[asymmetric], golden("asymmetry")[asymmetric], atol=5e-6
    )


def strobed(changes: dict[str, float]) -> np.ndarray:
    """Return (x/X_m, v/(X_m omega)) of the stationary orbit at the starts of three periods."""
    p = Parameters(**parameters(changes))
    ds = simulate(p, periods=2, start="stationary", samples_per_period=1, rtol=1e-10)
    X_m = p.drive_amplitude
    scaled = [ds.lower_displacement / X_m, ds.lower_velocity / (X_m * p.angular_frequency)]
    return np.array(scaled).T


@pytest.mark.slow
@pytest.mark.parametrize(("figure", "changes"), CLOSE_AFTER_ONE, ids=str)
def test_two_golden_orbits_close_after_one_period(figure: str, changes: dict[str, float]) -> None:
    start, one, two = strobed(changes)
    np.testing.assert_allclose(one, start, rtol=0, atol=1e-9)
    np.testing.assert_allclose(two, one, rtol=0, atol=1e-9)


@pytest.mark.slow
def test_plain_iteration_reaches_the_same_orbits() -> None:
    # Acceleration must end on the attractor of plain iteration. That takes a few hundred to several
    # thousand periods for each orbit, so only some orbits of the slow dilatant fluid are computed.
    gamma = np.array([anchor["changes"].get("gamma", -2 / 3) for anchor in ANCHORS])
    some = (gamma <= 0) | (np.arange(len(ANCHORS)) % 4 == 0)
    plain = orbits(POINTS[some], accelerate=False)
    hurried = computed()
    stress = hurried.elastic_stress_amplitude[some]
    force = hurried.friction_force_amplitude[some]
    assert np.all(plain.status == Status.OK)
    assert np.all(amplitude_errors(plain, POINTS[some], stress, force) <= 5e-6)
    np.testing.assert_array_equal(plain.orbit_periods, hurried.orbit_periods[some])
    np.testing.assert_array_equal(plain.melting_count, hurried.melting_count[some])
    # The accelerated search must really be faster.
    assert hurried.periods_integrated[some].sum() < 0.5 * plain.periods_integrated.sum()


@pytest.mark.parametrize("settings", [{}, {"rtol": 1e-4, "stationary_rtol": 1e-5}], ids=str)
def test_the_stated_error_covers_the_true_one(settings: dict[str, float]) -> None:
    # The uncertainty of the golden numbers is added; an estimate must bound 99 % of the errors.
    found = computed(**settings)
    uncertainty = np.maximum(3e-7, golden("spread"))
    covered = found.amplitude_error + uncertainty >= errors(found)
    assert np.all(found.status == Status.OK)
    assert np.mean(covered) >= 0.99, [ANCHORS[i]["changes"] for i in np.flatnonzero(~covered)]


def test_the_stated_error_is_not_exaggerated() -> None:
    # A bound of 1 would be true but useless, so the estimate must stay near the tolerance.
    assert np.all(computed().amplitude_error <= 1e-4)
    assert np.median(computed().amplitude_error) <= 3e-6
