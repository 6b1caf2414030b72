"""The recipes of CONTRIBUTING.md change the numbers as they should, with each suitable method.

All recipes that change numbers are applied to one copy of the sources, which is compiled once. Then
small sweeps by each method show that the numbers change correctly.
"""

from __future__ import annotations

import json
import math
import sys
from itertools import pairwise
from pathlib import Path

import pytest
from support.recipes import RECIPES, carried_out, copied, output_of, refusal, script

import sweeps


@pytest.fixture(scope="module")
def changed_copy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the sources with all recipes carried out."""
    copy = copied(tmp_path_factory.mktemp("copy"))
    for recipe in RECIPES.values():
        carried_out(recipe, copy)
    return copy


ALL = (
    "plain",
    "eyring",
    "stiffer eyring",
    "liquid eyring",
    "octic",
    "plateau",
    "damped",
    "two tones",
    "two tones of a mirrored drive",
    "thickened",
    "not thickened",
)
COARSE = ("plain", "octic", "plateau", "damped", "two tones", "two tones of a mirrored drive")
"""Cases in which a step of 2e-6 s is stable."""

CASES = {"adaptive": ALL, "fixed": ALL, "runge_kutta": COARSE}
"""The cases by the name of a fixture; each takes a minute or more to compile."""

RUNS = [(method, case) for method, cases in CASES.items() for case in cases]


def results_of(
    copy: Path, method: str, cases: tuple[str, ...] = ALL
) -> dict[str, dict[str, float]]:
    """Return the results of small sweeps by a method, by case."""
    done = output_of(script("small_sweeps.py"), copy, method, *cases, cache=copy / "cache")
    assert done.returncode == 0, done.stderr
    found: dict[str, dict[str, float]] = json.loads(done.stdout)
    return found


@pytest.fixture(scope="module")
def adaptive(changed_copy: Path) -> dict[str, dict[str, float]]:
    return results_of(changed_copy, "adaptive")


@pytest.fixture(scope="module")
def fixed(changed_copy: Path) -> dict[str, dict[str, float]]:
    return results_of(changed_copy, "euler-cromer")


@pytest.fixture(scope="module")
def runge_kutta(changed_copy: Path) -> dict[str, dict[str, float]]:
    return results_of(changed_copy, "rk4", COARSE)


@pytest.mark.stress
@pytest.mark.parametrize(("method", "case"), RUNS)
def test_the_power_balance_holds(request: pytest.FixtureRequest, method: str, case: str) -> None:
    found = request.getfixturevalue(method)[case]
    assert found["status"] == 0
    assert found["power_balance_error"] < 1e-3


@pytest.mark.stress
@pytest.mark.parametrize(("method", "case"), RUNS[len(ALL) :])
def test_all_methods_compute_the_same_physics(
    request: pytest.FixtureRequest,
    adaptive: dict[str, dict[str, float]],
    method: str,
    case: str,
) -> None:
    found, exact = request.getfixturevalue(method)[case], adaptive[case]
    works = ("friction_work", "dissipated_work")
    for name in ("elastic_stress_amplitude", "friction_force_amplitude", *works):
        assert found[name] == pytest.approx(exact[name], rel=2e-3)


@pytest.mark.stress
@pytest.mark.parametrize("case", COARSE)
def test_the_stated_error_of_a_new_method_holds(
    adaptive: dict[str, dict[str, float]], runge_kutta: dict[str, dict[str, float]], case: str
) -> None:
    found, exact = runge_kutta[case], adaptive[case]
    error = found["amplitude_error"] + exact["amplitude_error"]
    assert error < 1e-4
    for name in ("elastic_stress_amplitude", "friction_force_amplitude"):
        assert found[name] == pytest.approx(exact[name], rel=error)


@pytest.mark.stress
def test_a_new_method_has_its_order(changed_copy: Path) -> None:
    done = output_of(script("liquid.py"), changed_copy, cache=changed_copy / "cache")
    assert done.returncode == 0, done.stderr
    for name, errors in json.loads(done.stdout).items():
        for coarse, fine in pairwise(errors):
            assert math.log2(coarse / fine) == pytest.approx(4.0, abs=0.2), (name, errors)


BEFORE = {
    "eyring": "plain",
    "stiffer eyring": "eyring",
    "octic": "plain",
    "plateau": "plain",
    "damped": "plain",
    "two tones": "plain",
    "thickened": "not thickened",
}
"""The case from which the numbers of a case differ."""


@pytest.mark.stress
@pytest.mark.parametrize(("method", "case"), [run for run in RUNS if run[1] in BEFORE])
def test_the_numbers_change(request: pytest.FixtureRequest, method: str, case: str) -> None:
    results = request.getfixturevalue(method)
    found, before = results[case], results[BEFORE[case]]
    amplitudes = ("elastic_stress_amplitude", "friction_force_amplitude")
    assert any(abs(found[name] / before[name] - 1.0) > 1e-3 for name in amplitudes)


@pytest.mark.stress
@pytest.mark.parametrize("method", CASES)
def test_two_tones_of_a_mirrored_drive_are_the_mirror_image(
    request: pytest.FixtureRequest, method: str
) -> None:
    found = request.getfixturevalue(method)
    for name in ("elastic_stress_amplitude", "friction_force_amplitude"):
        mirrored = found["two tones of a mirrored drive"][name]
        assert mirrored == pytest.approx(found["two tones"][name], rel=1e-12)


@pytest.mark.stress
def test_a_parameter_at_its_default_changes_nothing(
    adaptive: dict[str, dict[str, float]],
) -> None:
    model = {"gamma": 0, "T": 250, "delta": 1.0, "omega": 30, "x_0": 0.8e-6, "phi_0": 0.6}
    config = {"model": model, "integrator": {"rtol": 1e-5}, "stationary": {"rtol": 1e-5}}
    today = sweeps.run(config, workers=1)
    # More parameters make other code, so the last digits differ, and the steps that depend on them.
    error = float(today.amplitude_error)
    for name in ("elastic_stress_amplitude", "friction_force_amplitude"):
        assert adaptive["plain"][name] == pytest.approx(float(today[name]), rel=error)


@pytest.mark.stress
def test_a_liquid_film_has_the_stress_of_the_new_law(
    adaptive: dict[str, dict[str, float]],
) -> None:
    """Stiff springs hold the block, so the film shears at the speed of the drive."""
    expected = 0.6e-9 * 2e5 * math.asinh(0.8e-6 * 30 / 1e-6)
    found = adaptive["liquid eyring"]["friction_force_amplitude"]
    assert found == pytest.approx(expected, rel=0.02)


@pytest.fixture(scope="module")
def sprung(changed_copy: Path) -> dict[str, list[dict[str, float]]]:
    """Orbits with a rigid upper block, and with one on springs of 1e7, 1e8 and 1e9 N/m."""
    done = output_of(script("sprung_sweeps.py"), changed_copy, cache=changed_copy / "cache")
    assert done.returncode == 0, done.stderr
    found: dict[str, list[dict[str, float]]] = json.loads(done.stdout)
    return found


@pytest.mark.stress
@pytest.mark.parametrize("case", ["locked", "liquid"])
def test_with_a_stiffer_spring_the_force_approaches_the_rigid_limit(
    sprung: dict[str, list[dict[str, float]]], case: str
) -> None:
    """The difference is proportional to 1/K_2."""
    assert all(found["status"] == 0 for found in sprung[case])
    assert all(found["power_balance_error"] < 1e-7 for found in sprung[case])
    rigid, *others = (found["friction_force_amplitude"] for found in sprung[case])
    away = [1.0 - force / rigid for force in others]
    sys.stdout.write(f"{case}: off by {away} at K_2 = 1e7, 1e8, 1e9 N/m\n")
    assert away[0] / away[1] == pytest.approx(10.0, rel=0.02)
    assert away[1] / away[2] == pytest.approx(10.0, rel=0.02)


@pytest.mark.stress
def test_locked_blocks_move_together_on_their_springs(
    sprung: dict[str, list[dict[str, float]]],
) -> None:
    """X_2 = X K_2/(K_2 + 2 K - (M + M_2) omega^2), and F = (2 K - M omega^2) X_2."""
    for found, K_2 in zip(sprung["locked"][1:], (1e7, 1e8, 1e9), strict=True):
        moved = 0.8e-6 * K_2 / (K_2 + 2 * 500 - (0.4 + 0.4) * 30**2)
        expected = (2 * 500 - 0.4 * 30**2) * moved
        assert found["friction_force_amplitude"] == pytest.approx(expected, rel=1e-6)


@pytest.mark.stress
def test_the_work_lost_in_a_newtonian_liquid_follows_from_its_force(
    sprung: dict[str, list[dict[str, float]]],
) -> None:
    """It is pi F^2 h/(k A omega) for a harmonic force."""
    found = sprung["liquid"][0]
    expected = math.pi * found["friction_force_amplitude"] ** 2 * 1e-9 / (5e4 * 0.6e-9 * 30)
    assert found["dissipated_work"] == pytest.approx(expected, rel=1e-4)


def test_a_method_refuses_an_unknown_state_variable(changed_copy: Path) -> None:
    asked = {"film": {"strain": "sprung"}, "integrator": {"method": "euler-cromer"}}
    refused = refusal(changed_copy, f"from sweeps import run; run({asked})")
    assert "adaptive" in refused
    assert "strain" in refused
