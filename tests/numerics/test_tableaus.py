"""Tableaus: the published data, and the refusal of any coefficient that is slightly wrong."""

import dataclasses
from typing import Any

import numpy as np
import pytest

from stickslip.numerics.tableaus import RODAS4P2, RosenbrockTableau

NESTED = ("a", "C", "dense")
FLAT = ("c", "d")


def places() -> list[tuple[str, Any]]:
    """Every coefficient by its field and index; None for the scalar gamma."""
    found: list[tuple[str, Any]] = [("gamma", None)]
    for field in FLAT:
        found += [(field, i) for i in range(len(getattr(RODAS4P2, field)))]
    for field in NESTED:
        rows = getattr(RODAS4P2, field)
        found += [(field, (i, j)) for i, row in enumerate(rows) for j in range(len(row))]
    return found


def changed(field: str, place: Any, by: float) -> RosenbrockTableau:
    value = getattr(RODAS4P2, field)
    if place is None:
        return dataclasses.replace(RODAS4P2, **{field: value + by})
    if isinstance(place, int):
        entries = list(value)
        entries[place] += by
        return dataclasses.replace(RODAS4P2, **{field: tuple(entries)})
    rows = [list(row) for row in value]
    rows[place[0]][place[1]] += by
    return dataclasses.replace(RODAS4P2, **{field: tuple(tuple(row) for row in rows)})


CHECKED = [place for place in places() if place[0] != "dense"]
DENSE = [place for place in places() if place[0] == "dense"]


@pytest.mark.parametrize("by", [1e-6, -1e-6])
@pytest.mark.parametrize(("field", "place"), CHECKED, ids=str)
def test_a_coefficient_that_is_off_by_1e_6_is_refused(field: str, place: Any, by: float) -> None:
    with pytest.raises(ValueError, match=r"^RODAS4P2: .* is off by"):
        changed(field, place, by)


def matrices(tableau: RosenbrockTableau) -> tuple[np.ndarray, np.ndarray]:
    """The matrices a and Gamma of the method."""
    a, C = np.zeros((6, 6)), np.zeros((6, 6))
    for i in range(6):
        a[i, :i], C[i, :i] = tableau.a[i], tableau.C[i]
    return a, np.linalg.inv(np.eye(6) / tableau.gamma - C)


def test_the_method_is_L_stable() -> None:
    # R(z) = 1 + b^T (I/z - B)^-1 1 on the imaginary axis and far from 0.
    a, Gamma = matrices(RODAS4P2)
    beta = a @ Gamma + Gamma
    b = beta[-1]

    def amplification(z: complex) -> float:
        return abs(1 + b @ np.linalg.solve(np.eye(6) / z - beta, np.ones(6)))

    assert max(amplification(1j * w) for w in np.logspace(-3, 4, 500)) <= 1 + 1e-12
    assert amplification(-1e8) < 1e-6
    assert amplification(1e8j) < 1e-6


def dense_defects(tableau: RosenbrockTableau, theta: float) -> list[float]:
    """Distances of the continuous extension at theta from the conditions up to order 3."""
    a, Gamma = matrices(tableau)
    alpha = a @ Gamma
    beta = alpha + Gamma
    d1, d2 = (np.append(row, 0.0) for row in tableau.dense)
    m = a[-1] + np.eye(6)[-1]
    weights = theta * (m + (1 - theta) * (d1 + theta * d2)) @ Gamma
    one = np.ones(6)
    c = alpha @ one
    return [
        weights @ one - theta,
        weights @ beta @ one - theta**2 / 2,
        weights @ c**2 - theta**3 / 3,
        weights @ beta @ beta @ one - theta**3 / 6,
    ]


@pytest.mark.parametrize("theta", [0.0, 0.2, 0.5, 0.8, 1.0])
def test_the_continuous_extension_fulfils_the_conditions_of_order_three(theta: float) -> None:
    assert dense_defects(RODAS4P2, theta) == pytest.approx([0.0] * 4, abs=1e-11)


@pytest.mark.parametrize(("field", "place"), DENSE, ids=str)
def test_a_dense_coefficient_that_is_off_by_1e_6_breaks_the_order_of_the_extension(
    field: str, place: Any
) -> None:
    try:
        wrong = changed(field, place, 1e-6)
    except ValueError:
        return  # refused at construction: better still
    assert max(np.abs(dense_defects(wrong, 0.4))) > 1e-9
