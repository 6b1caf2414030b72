"""A term of the free energy as the recipe adds it, its phases compared with numpy.roots."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from support.recipes import (
    RECIPES,
    SEPTIC,
    Edit,
    carried_out,
    copied,
    output_of,
    refusal,
    said_by_tests,
    script,
)

# --- the phases of a film with an octic term ------------------------------------------------------

ENERGIES = ("cubic", "quartic", "quintic", "sextic", "septic", "octic")


def with_turns(turns: list[float], **given: float) -> dict[str, float]:
    """Return the coefficients of a film whose balance turns at these order parameters.

    If some coefficients are given, the lowest others follow from the turning points.
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
    """The turning points of a film from numpy.roots, and what follows from them."""

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
"""2 alpha (T - T_c) [J/m3], with which all solids of a film exist at rest."""

for _name, _values in FILMS.items():
    _values["temperature"] = 290.0 + HEATING[_name] / (2 * 0.95)


@pytest.fixture(scope="module")
def phases(tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict[str, Any]]:
    """The phases of films, computed by a copy with a septic and an octic term."""
    copy = copied(tmp_path_factory.mktemp("octic"))
    carried_out([*RECIPES["free energy"], SEPTIC], copy)
    films = json.dumps(list(FILMS.values()))
    done = output_of(script("phases_of_films.py"), copy, films, cache=copy / "cache")
    assert done.returncode == 0, done.stderr
    return dict(zip(FILMS, json.loads(done.stdout), strict=True))


@pytest.mark.stress
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


@pytest.mark.stress
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


def test_an_undeclared_coefficient_is_refused(tmp_path: Path) -> None:
    code = "from stickslip import Parameters; Parameters(octic_coefficient=400.0)"
    assert "no parameter 'octic_coefficient'" in refusal(copied(tmp_path), code)


def test_an_octic_coefficient_bounds_the_order_parameter_only_with_the_right_sign(
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
        pytest.param(
            [OF_THE_ENERGY_ALONE],
            "phi_power=6",
            "test_the_log_force_is_the_slope_of_the_free_energy",
            marks=pytest.mark.stress,
        ),
    ],
    ids=["no power", "a term of the energy alone"],
)
def test_a_term_that_is_missing_somewhere_fails_a_test_of_the_model(
    edits: list[Edit], power: str, test: str, tmp_path: Path
) -> None:
    copy, (edit,) = copied(tmp_path), RECIPES["free energy"]
    carried_out([edit._replace(text=edit.text.replace("phi_power=6", power)), *edits], copy)
    said = said_by_tests(copy, "model/test_film.py", "-k", test)
    assert "1 failed" in said, said
    assert f"test_film.py::{test}" in said
