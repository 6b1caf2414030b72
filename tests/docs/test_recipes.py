"""The recipes of CONTRIBUTING.md, each carried out on a copy of the sources, run and seen to work.

A recipe is a list of edits of files. Those that change numbers are applied to one copy, so that it
is compiled once; a small sweep in each method then shows that the numbers change as they should.
"""

from __future__ import annotations

import json
import math
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from support.marks import one_then
from support.recipes import (
    DRAWN,
    EXECUTOR_RECIPE,
    FIGURE_RECIPE,
    LIQUID,
    PHASES_OF_FILMS,
    RECIPES,
    REFUSED,
    RUNGE_KUTTA,
    SEPTIC,
    SERIAL_SWEEPS,
    SMALL_SWEEPS,
    SPRUNG_SWEEPS,
    Edit,
)

import stickslip
import sweeps
from stickslip.options import OFFERED
from stickslip.status import Status

ENDED = 1800.0  # seconds: a hang, on any machine

MOST_FILES = {
    "friction law": 3,
    "law of the order parameter": 3,
    "state variables": 4,
    "integral": 3,
    "free energy": 1,
    "force on the block": 2,
    "drive tone": 2,
    "parameter": 2,
    "result variable": 2,
    "figure": 2,
    "method": 2,
    "executor": 2,
}
"""Files at most, as the table of CONTRIBUTING.md says."""


def carried_out(recipe: list[Edit], copy: Path) -> set[str]:
    """Apply a recipe to a copy of the sources; the files that it touched."""
    for edit in recipe:
        path = copy / edit.file
        if not edit.before:
            path.parent.mkdir(exist_ok=True)
            path.write_text(edit.text)
            continue
        source = path.read_text()
        assert source.count(edit.before) == 1, f"{edit.file}: {edit.before!r}"
        path.write_text(source.replace(edit.before, edit.text + edit.before))
    return {edit.file for edit in recipe}


def copied(folder: Path) -> Path:
    for package in (stickslip, sweeps):
        source = Path(package.__file__).parent
        ignore = shutil.ignore_patterns("__pycache__")
        shutil.copytree(source, folder / package.__name__, ignore=ignore)
    return folder


def output_of(
    code: str, copy: Path, *arguments: str, cache: Path | None = None
) -> subprocess.CompletedProcess[str]:
    environment = os.environ | {"PYTHONPATH": str(copy)}
    if cache is not None:
        environment["NUMBA_CACHE_DIR"] = str(cache)
    return subprocess.run(
        [sys.executable, "-c", code, *arguments],
        cwd=copy,
        env=environment,
        capture_output=True,
        text=True,
        timeout=ENDED,
        check=False,
    )


@pytest.fixture(scope="module")
def changed_copy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The sources with all recipes carried out."""
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
"""By the name of a fixture; each takes a minute or more to compile."""

RUNS = [(method, case) for method, cases in CASES.items() for case in cases]


def results_of(
    copy: Path, method: str, cases: tuple[str, ...] = ALL
) -> dict[str, dict[str, float]]:
    """What small sweeps by a method give, by case."""
    done = output_of(SMALL_SWEEPS, copy, method, *cases, cache=copy / "cache")
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


@pytest.mark.parametrize("name", RECIPES)
def test_a_recipe_touches_no_more_files_than_promised(name: str, tmp_path: Path) -> None:
    touched = carried_out(RECIPES[name], copied(tmp_path))
    sys.stdout.write(f"{name}: {len(touched)} files: {', '.join(sorted(touched))}\n")
    assert len(touched) <= MOST_FILES[name]


def test_a_figure_is_drawn_from_a_file_and_a_line(tmp_path: Path) -> None:
    copy = copied(tmp_path)
    touched = carried_out(FIGURE_RECIPE, copy)
    sys.stdout.write(f"figure: {len(touched)} files: {', '.join(sorted(touched))}\n")
    assert len(touched) <= MOST_FILES["figure"]
    done = output_of(DRAWN, copy)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == [1e-7, 2e-7]


def test_a_figure_without_its_line_is_unknown(tmp_path: Path) -> None:
    copy = copied(tmp_path)
    carried_out(FIGURE_RECIPE[:1], copy)
    done = output_of(DRAWN, copy)
    assert done.returncode != 0
    assert "errors" in done.stderr


@pytest.mark.slow
def test_an_executor_computes_the_same_bits_from_a_file_and_a_line(tmp_path: Path) -> None:
    copy = copied(tmp_path)
    touched = carried_out(EXECUTOR_RECIPE, copy)
    sys.stdout.write(f"executor: {len(touched)} files: {', '.join(sorted(touched))}\n")
    assert len(touched) <= MOST_FILES["executor"]
    done = output_of(SERIAL_SWEEPS, copy)  # kernels of the same sources: they are in the cache
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["in memory"] == found["into a file"] == found["by threads"]
    assert found["threads"] == ["MainThread"] * 6
    assert found["help"] == "threads|loky|serial|dask"


@pytest.mark.parametrize(
    ("left_out", "message"),
    [
        ("executor_table", "a.yaml:2: execution.backend: must be 'threads', 'loky' or 'dask', not"),
        ("serial", "No module named 'sweeps.engine.executors.serial'"),
    ],
    ids=["line", "file"],
)
def test_an_executor_without_its_line_or_its_file_is_refused(
    left_out: str, message: str, tmp_path: Path
) -> None:
    copy = copied(tmp_path)
    carried_out([edit for edit in EXECUTOR_RECIPE if left_out not in edit.file], copy)
    (copy / "a.yaml").write_text("execution:\n  backend: serial\n")
    done = output_of("from sweeps import run; run('a.yaml')", copy)
    assert done.returncode != 0
    assert message in done.stderr


@pytest.mark.stress
@pytest.mark.parametrize(("method", "case"), RUNS)
def test_what_is_measured_is_what_is_integrated(
    request: pytest.FixtureRequest, method: str, case: str
) -> None:
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
def test_a_new_method_states_an_error_that_holds(
    adaptive: dict[str, dict[str, float]], runge_kutta: dict[str, dict[str, float]], case: str
) -> None:
    found, exact = runge_kutta[case], adaptive[case]
    error = found["amplitude_error"] + exact["amplitude_error"]
    assert error < 1e-4
    for name in ("elastic_stress_amplitude", "friction_force_amplitude"):
        assert found[name] == pytest.approx(exact[name], rel=error)


@pytest.mark.stress
def test_a_new_method_has_its_order(changed_copy: Path) -> None:
    done = output_of(LIQUID, changed_copy, cache=changed_copy / "cache")
    assert done.returncode == 0, done.stderr
    for name, errors in json.loads(done.stdout).items():
        for coarse, fine in pairwise(errors):
            assert math.log2(coarse / fine) == pytest.approx(4.0, abs=0.2), (name, errors)


CHOSEN = "from stickslip import stationary_orbit; stationary_orbit(method='rk4', max_steps=1)"


def test_a_method_without_its_line_is_unknown(tmp_path: Path) -> None:
    copy = copied(tmp_path)
    carried_out(RECIPES["method"][:1], copy)
    done = output_of(CHOSEN, copy)
    assert done.returncode != 0
    assert "method must be one of adaptive, euler-cromer, not 'rk4'" in done.stderr


@pytest.mark.parametrize("left_out", one_then("stress", OFFERED))
def test_a_method_without_a_function_is_refused_by_its_name(left_out: str, tmp_path: Path) -> None:
    copy, (module, line) = copied(tmp_path), RECIPES["method"]
    less = RUNGE_KUTTA.replace(f"\ndef {left_out}(", f"\ndef another_{left_out}(")
    carried_out([module._replace(text=less), line], copy)
    done = output_of(CHOSEN, copy)
    assert done.returncode != 0
    assert f"stickslip.kernels.rk4, a method, lacks the function {left_out}\n" in done.stderr


def test_a_config_asks_no_noise_of_a_method_that_it_does_not_know(tmp_path: Path) -> None:
    copy = copied(tmp_path)
    carried_out(RECIPES["method"], copy)
    asked = {"integrator": {"method": "rk4", "dt": 1e-6}, "noise": {"treatment": "stochastic"}}
    code = f"from sweeps.config.load import from_mapping; from_mapping({asked})"
    done = output_of(code, copy)
    assert done.returncode != 0
    assert "stochastic needs `integrator: {method: adaptive or euler-cromer}`" in done.stderr


BEFORE = {
    "eyring": "plain",
    "stiffer eyring": "eyring",
    "octic": "plain",
    "plateau": "plain",
    "damped": "plain",
    "two tones": "plain",
    "thickened": "not thickened",
}
"""What the numbers of a case differ from."""


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
def test_a_parameter_at_its_neutral_value_changes_nothing(
    adaptive: dict[str, dict[str, float]],
) -> None:
    model = {"gamma": 0, "T": 250, "delta": 1.0, "omega": 30, "x_0": 0.8e-6, "phi_0": 0.6}
    config = {"model": model, "integrator": {"rtol": 1e-5}, "stationary": {"rtol": 1e-5}}
    today = sweeps.run(config, workers=1)
    # More parameters make other code: the last digits differ, and the steps that hang on them.
    error = float(today.amplitude_error)
    for name in ("elastic_stress_amplitude", "friction_force_amplitude"):
        assert adaptive["plain"][name] == pytest.approx(float(today[name]), rel=error)


@pytest.mark.stress
def test_a_liquid_film_passes_on_the_stress_of_the_new_law(
    adaptive: dict[str, dict[str, float]],
) -> None:
    """Stiff springs hold the block, so the film shears at the speed of the drive."""
    expected = 0.6e-9 * 2e5 * math.asinh(0.8e-6 * 30 / 1e-6)
    found = adaptive["liquid eyring"]["friction_force_amplitude"]
    assert found == pytest.approx(expected, rel=0.02)


@pytest.fixture(scope="module")
def sprung(changed_copy: Path) -> dict[str, list[dict[str, float]]]:
    """Orbits with a rigid upper block, and on springs of 1e7, 1e8 and 1e9 N/m."""
    done = output_of(SPRUNG_SWEEPS, changed_copy, cache=changed_copy / "cache")
    assert done.returncode == 0, done.stderr
    found: dict[str, list[dict[str, float]]] = json.loads(done.stdout)
    return found


@pytest.mark.stress
@pytest.mark.parametrize("case", ["locked", "liquid"])
def test_a_stiff_spring_of_the_upper_block_takes_the_force_to_that_of_a_rigid_one(
    sprung: dict[str, list[dict[str, float]]], case: str
) -> None:
    """In proportion to 1/K_2."""
    assert all(found["status"] == 0 for found in sprung[case])
    assert all(found["power_balance_error"] < 1e-7 for found in sprung[case])
    rigid, *others = (found["friction_force_amplitude"] for found in sprung[case])
    away = [1.0 - force / rigid for force in others]
    sys.stdout.write(f"{case}: off by {away} at K_2 = 1e7, 1e8, 1e9 N/m\n")
    assert away[0] / away[1] == pytest.approx(10.0, rel=0.02)
    assert away[1] / away[2] == pytest.approx(10.0, rel=0.02)


@pytest.mark.stress
def test_blocks_that_are_locked_move_as_one_on_their_springs(
    sprung: dict[str, list[dict[str, float]]],
) -> None:
    """X_2 = X K_2/(K_2 + 2 K - (M + M_2) omega^2), and F = (2 K - M omega^2) X_2."""
    for found, K_2 in zip(sprung["locked"][1:], (1e7, 1e8, 1e9), strict=True):
        moved = 0.8e-6 * K_2 / (K_2 + 2 * 500 - (0.4 + 0.4) * 30**2)
        expected = (2 * 500 - 0.4 * 30**2) * moved
        assert found["friction_force_amplitude"] == pytest.approx(expected, rel=1e-6)


@pytest.mark.stress
def test_the_work_lost_in_a_newtonian_liquid_is_that_of_its_force(
    sprung: dict[str, list[dict[str, float]]],
) -> None:
    """Pi F^2 h/(k A omega) for a harmonic force."""
    found = sprung["liquid"][0]
    expected = math.pi * found["friction_force_amplitude"] ** 2 * 1e-9 / (5e4 * 0.6e-9 * 30)
    assert found["dissipated_work"] == pytest.approx(expected, rel=1e-4)


def test_a_method_that_does_not_know_a_state_variable_refuses_it(changed_copy: Path) -> None:
    done = output_of(REFUSED, changed_copy)
    assert done.returncode != 0
    assert "adaptive" in done.stderr
    assert "strain" in done.stderr


def without(recipe: str, left_out: str, folder: Path) -> Path:
    """A copy in which the step with this text is left out of a recipe."""
    copy = copied(folder)
    kept = [edit for edit in RECIPES[recipe] if left_out not in f"{edit.file}: {edit.text}"]
    assert len(kept) == len(RECIPES[recipe]) - 1
    carried_out(kept, copy)
    return copy


@pytest.mark.parametrize(
    ("recipe", "left_out", "message"),
    [
        ("integral", "accumulate.py:     DISSIPATED_WORK,", "too many values to unpack"),
        ("state variables", "sprung.SPRUNG", "KeyError: 'sprung'"),
        ("state variables", 'options.py:         "sprung"', "strain must be one of"),
    ],
)
def test_a_step_that_is_left_out_is_refused_at_the_start(
    recipe: str, left_out: str, message: str, tmp_path: Path
) -> None:
    copy = without(recipe, left_out, tmp_path)
    code = (
        "from stickslip import Options\n"
        "from stickslip.kernels.adaptive import rows\n"
        "from stickslip.model.models import model_of\n"
        "model_of(Options(strain='sprung').physics)\n"
    )
    done = output_of(code, copy)
    assert done.returncode != 0
    assert message in done.stderr


LEFT_OUT: dict[str, tuple[str, Callable[[Edit], bool], str]] = {
    "the name of the law": ("friction law", lambda e: "options" in e.file, "friction must be one"),
    "the parameter of the law": (
        "friction law",
        lambda e: "eyring_speed" in e.text and "variables" in e.file,
        "eyring_speed",
    ),
    "the new parameter": ("parameter", lambda e: "variables" in e.file, "plateau_viscosity"),
    "the registry": ("result variable", lambda e: "variables" in e.file, "friction_work"),
    "the column": ("result variable", lambda e: "results" in e.file, "friction_work"),
}


@pytest.mark.slow
@pytest.mark.parametrize("step", one_then("stress", [*LEFT_OUT]))
def test_a_step_that_is_left_out_is_an_error_and_no_wrong_number(step: str, tmp_path: Path) -> None:
    name, left_out, message = LEFT_OUT[step]
    copy = copied(tmp_path)
    carried_out([edit for edit in RECIPES[name] if not left_out(edit)], copy)
    law = "eyring" if name == "friction law" else "power-law"
    code = (
        "import numpy as np\n"
        "from stickslip import Options, Parameters\n"
        "from stickslip.kernels.adaptive import rows\n"
        "from stickslip.kernels.stability import fastest_rate\n"
        f"physics = Options(friction={law!r}).physics\n"
        "points = np.array([Parameters()])\n"
        "print(fastest_rate(points, physics.friction))\n"
        "from stickslip.kernels.trajectories import observables_kernel\n"
        "observables_kernel(physics)(\n"
        "    points[0], np.zeros(1), np.ones((1, 3)), 0.0, np.zeros((1, 6)))\n"
        "from stickslip.kernels.adaptive.passes import new_queue\n"
        "queue = new_queue(np.zeros((1, 40)), np.zeros((1, 4)))\n"
        "orbits = rows.Orbits(np.zeros((1, 4)), queue.measured.copy(), np.zeros(1, bool),\n"
        "    np.zeros((1, 2)), np.zeros(1), np.zeros((1, 4, 3)), np.zeros((1, 3)),\n"
        "    np.zeros((1, 3)), np.zeros((1, 3)))\n"
        "states = np.zeros((1, 4))\n"
        "rows.row_kernels(physics).write_results(\n"
        "    points, queue, orbits, states, states, 1e-6, np.zeros((1, 30)))\n"
    )
    done = output_of(code, copy, cache=copy / "cache")
    assert done.returncode != 0
    assert message in done.stderr


# --- the phases of a film with an octic term ------------------------------------------------------

ENERGIES = ("cubic", "quartic", "quintic", "sextic", "septic", "octic")


def with_turns(turns: list[float], **given: float) -> dict[str, float]:
    """Coefficients of a film whose balance turns at these order parameters.

    Where some are given, the lowest are found that make it turn there.
    """
    if not given:  # the slope is -6 g times the product of (phi - turn)
        slope = -6.0 * 400.0 * np.poly(turns)[::-1]
        sizes = np.abs(slope) / np.arange(1, 7)
        return {f"{n}_coefficient": float(k) for n, k in zip(ENERGIES, sizes, strict=True)}
    powers, signs = np.arange(1, 7), np.array([1, -1, 1, -1, 1, -1])
    rows = signs * powers * np.array(turns)[:, None] ** (powers - 1)
    known = np.array([given.get(name, 0.0) for name in ENERGIES])
    lowest = np.linalg.solve(rows[:, : len(turns)], -rows @ known)
    known[: len(turns)] = lowest
    return {f"{n}_coefficient": float(k) for n, k in zip(ENERGIES, known, strict=True)}


class Film(NamedTuple):
    """What numpy.roots says of a film: its turning points, and what follows from them."""

    turns: list[float]
    largest: float
    strongest: float
    balance: np.polynomial.Polynomial

    @classmethod
    def of(cls, values: dict[str, float]) -> Film:
        signs = np.array([1, -1, 1, -1, 1, -1])
        balance = np.array([values[f"{n}_coefficient"] for n in ENERGIES]) * signs
        polynomial = np.polynomial.Polynomial([0.0, *balance])
        turns = real_roots(polynomial.deriv())
        heating = 2 * 0.95 * (values["temperature"] - 290.0)
        largest, strongest = real_roots(polynomial - heating)[-1], max(polynomial(np.array(turns)))
        return cls(turns, largest, strongest, polynomial)


def real_roots(polynomial: np.polynomial.Polynomial) -> list[float]:
    roots = np.roots(polynomial.coef[::-1])
    return sorted(float(z.real) for z in roots if abs(z.imag) < 1e-9 and z.real > 0.0)


FILMS = {
    "two solids": with_turns([0.12, 0.4, 0.5], sextic=2395.83, octic=400.0),
    "without a sextic term": {f"{name}_coefficient": 0.0 for name in ENERGIES}
    | {"cubic_coefficient": 230.0, "quintic_coefficient": 300.0, "octic_coefficient": 4000.0},
    "three solids": with_turns([0.2, 0.4, 0.6, 0.8, 1.0]),
}
HEATING = {"two solids": 3.44, "without a sextic term": 3.0, "three solids": 5.8}
"""2 alpha (T - T_c) [J/m3]: at rest all solids of a film exist."""

FILMS = {
    name: values | {"temperature": 290.0 + HEATING[name] / (2 * 0.95)}
    for name, values in FILMS.items()
}


@pytest.fixture(scope="module")
def phases(tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict[str, Any]]:
    """What a copy with a septic and an octic term says of films."""
    copy = copied(tmp_path_factory.mktemp("octic"))
    carried_out([*RECIPES["free energy"], SEPTIC], copy)
    done = output_of(PHASES_OF_FILMS, copy, json.dumps(list(FILMS.values())), cache=copy / "cache")
    assert done.returncode == 0, done.stderr
    return dict(zip(FILMS, json.loads(done.stdout), strict=True))


@pytest.mark.slow
@pytest.mark.parametrize("name", FILMS)
def test_the_phases_follow_an_octic_term(phases: dict[str, dict[str, Any]], name: str) -> None:
    expected, found = Film.of(FILMS[name]), phases[name]
    first = (expected.turns + [math.inf] * 2)[:3]
    assert found["turning points"] == pytest.approx(first, rel=1e-9)
    assert found["thresholds"][:3] == pytest.approx(first, rel=1e-9)
    soft_exists = [expected.balance(phi) for phi in first[1::-1] if first[2] < math.inf]
    assert found["thresholds"][3:] == pytest.approx(soft_exists or [0.0, 0.0], rel=1e-9)
    assert found["largest"] == pytest.approx(expected.largest, rel=1e-7)
    melting = math.sqrt((expected.strongest - HEATING[name]) / 4e12)
    assert found["melting strain"] == pytest.approx(melting, rel=1e-9)
    assert found["melting strain of the page"] == found["melting strain"]


@pytest.mark.slow
@pytest.mark.parametrize("name", FILMS)
def test_the_page_of_phases_follows_an_octic_term(
    phases: dict[str, dict[str, Any]], name: str
) -> None:
    expected, found = Film.of(FILMS[name]), phases[name]
    phi = np.array(found["order parameter"])
    falls = np.searchsorted(expected.turns, phi) % 2 == 1
    clear = np.abs(phi[:, None] - expected.turns).min(axis=1) > 1e-9
    clear &= phi > 0.0
    assert np.array_equal(np.array(found["stable"])[clear] == 1, falls[clear])
    rising, strains = np.array(found["ramp"][0]), np.array(found["strain"])
    assert rising[0] == pytest.approx(expected.largest, rel=1e-7)
    liquid = strains[rising == 0.0]
    melting = math.sqrt((expected.strongest - HEATING[name]) / 4e12)
    assert liquid.min() == pytest.approx(melting, rel=2e-3)


def refusal(copy: Path, code: str) -> str:
    done = output_of(code, copy, cache=copy / "cache")
    assert done.returncode != 0
    return done.stderr


def test_a_coefficient_that_is_not_declared_is_refused(tmp_path: Path) -> None:
    code = "from stickslip import Parameters; Parameters(octic_coefficient=400.0)"
    assert "no parameter 'octic_coefficient'" in refusal(copied(tmp_path), code)


def test_a_positive_octic_coefficient_bounds_the_order_parameter_and_a_wrong_sign_does_not(
    tmp_path: Path,
) -> None:
    copy, (edit,) = copied(tmp_path), RECIPES["free energy"]
    carried_out([edit], copy)
    code = "from stickslip import Parameters; Parameters(quintic_coefficient=1.0"
    assert output_of(f"{code}, octic_coefficient=400.0)", copy).returncode == 0
    needed = "needs a sextic_coefficient (e) or octic_coefficient (g) > 0"
    assert needed in refusal(copy, f"{code})")
    registry = copy / edit.file
    registry.write_text(registry.read_text().replace("phi_power=6", "phi_power=6, phi_sign=-1"))
    needed = "octic_coefficient (g) > 0 needs a higher coefficient > 0"
    assert needed in refusal(copy, f"{code}, octic_coefficient=400.0)")


OF_THE_ENERGY_ALONE = Edit(
    "stickslip/model/film.py",
    "    low = harmonic - cubic",
    "    harmonic += p.octic_coefficient / 8.0 * (phi2 * phi2) * (phi2 * phi2)\n",
)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("edits", "power", "test"),
    [
        ([], "", "test_every_energy_density_of_the_registry_is_a_coefficient"),
        (
            [OF_THE_ENERGY_ALONE],
            "phi_power=6",
            "test_the_log_force_is_the_slope_of_the_free_energy",
        ),
    ],
    ids=["no power", "a term of the energy alone"],
)
def test_a_term_that_is_not_one_of_all_fails_a_test_of_the_model(
    edits: list[Edit], power: str, test: str, tmp_path: Path
) -> None:
    copy, (edit,) = copied(tmp_path), RECIPES["free energy"]
    carried_out([edit._replace(text=edit.text.replace("phi_power=6", power)), *edits], copy)
    tests = Path(__file__).parents[1]
    options = ["-q", "-p", "no:cacheprovider", "-k", test, str(tests / "model/test_film.py")]
    code = f"import sys, pytest; sys.path.insert(0, {str(tests)!r}); pytest.main({options!r})"
    done = output_of(code, copy, cache=copy / "cache")
    assert "1 failed" in done.stdout, done.stdout
    assert f"test_film.py::{test}" in done.stdout


@pytest.mark.stress
@pytest.mark.parametrize("method", ["adaptive", "euler-cromer"])
def test_a_loss_of_the_block_that_is_left_out_violates_the_power_balance(
    method: str, tmp_path: Path
) -> None:
    copy, recipe = copied(tmp_path), RECIPES["force on the block"]
    carried_out([edit for edit in recipe if edit.before != "    return 0.0\n"], copy)
    done = output_of(SMALL_SWEEPS, copy, method, "damped", cache=copy / "cache")
    assert json.loads(done.stdout)["damped"]["status"] == Status.INVARIANT_VIOLATED


def said_by_tests(copy: Path, tests: str, *chosen: str) -> str:
    """What tests of the project say of a copy of the sources."""
    folder = Path(__file__).parents[1]
    options = ["-q", "-p", "no:cacheprovider", *chosen, str(folder / tests)]
    code = f"import sys, pytest; sys.path.insert(0, {str(folder)!r}); pytest.main({options!r})"
    return output_of(code, copy, cache=copy / "cache").stdout


@pytest.mark.slow
def test_a_slope_of_the_block_that_is_left_out_fails_a_test_of_the_model(tmp_path: Path) -> None:
    copy, recipe = copied(tmp_path), RECIPES["force on the block"]
    carried_out([edit for edit in recipe if "stiffness, 0.0" not in edit.before], copy)
    said = said_by_tests(copy, "model/test_block.py")
    assert "5 failed" in said, said
    assert "test_the_slopes_are_those_of_the_force" in said


@pytest.mark.slow
def test_a_law_without_its_derivative_over_phi_fails_a_test_of_laws(tmp_path: Path) -> None:
    copy = copied(tmp_path)
    carried_out(RECIPES["law of the order parameter"], copy)
    law, slope = copy / "stickslip/model/laws/of_the_solid.py", "2.0 * (growth - 1.0) * stress"
    assert slope in law.read_text()
    law.write_text(law.read_text().replace(slope, "0.0"))
    fluid = copy / "stickslip/variables.py"
    fluid.write_text(
        fluid.read_text().replace('"viscosity_growth", default=0.0', '"", default=3.0')
    )
    said = said_by_tests(copy, "model/laws/test_laws.py", "-k", "derivative_over_the_log and solid")
    assert "8 failed" in said, said


@pytest.mark.slow
def test_a_tone_that_is_not_directed_fails_a_test_of_the_registry(tmp_path: Path) -> None:
    copy = copied(tmp_path)
    carried_out(RECIPES["drive tone"], copy)
    registry = copy / "stickslip/variables.py"
    text = registry.read_text()
    registry.write_text(
        text.replace("neutral=0.0, directed=True),\n    _not", "neutral=0.0),\n    _not")
    )
    said = said_by_tests(copy, "test_variables.py", "-k", "direction")
    assert "1 failed" in said, said
