"""Films with a soft and a hard solid, from a free energy of sixth order."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stickslip import Parameters
from stickslip.model import film, noise, solids

P, Q, R = 0.12, 0.4, 0.5


def with_turns(p: float, q: float, r: float, e: float = 2395.83, **more: float) -> Parameters:
    """A film whose balance turns at these order parameters."""
    return Parameters(
        cubic_coefficient=4.0 * e * p * q * r,
        quartic_coefficient=2.0 * e * (p * q + p * r + q * r),
        quintic_coefficient=4.0 * e * (p + q + r) / 3.0,
        sextic_coefficient=e,
        **more,
    )


TWO = with_turns(P, Q, R)


@given(
    turns=st.lists(st.floats(0.01, 1.5), min_size=3, max_size=3, unique=True),
    e=st.floats(1.0, 1e5),
)
def test_turning_points_are_found_anywhere(turns: list[float], e: float) -> None:
    p, q, r = sorted(turns)
    if min(q - p, r - q) < 1e-3:
        return  # nearly one point: rounding of the coefficients decides
    found = solids.turning_points(with_turns(p, q, r, e))
    np.testing.assert_allclose(found, (p, q, r), rtol=1e-7)


def nearly_degenerate_films() -> list[Parameters]:
    """Films with two turning points that nearly coincide, or with coefficients of 0 or nearly 0."""
    rng, found = np.random.default_rng(5), []
    for _ in range(200):
        p, r = rng.uniform(0.01, 1.5, 2)
        q = p * (1.0 + 10.0 ** rng.uniform(-9, -2))
        found.append(with_turns(p, q, r, 10.0 ** rng.uniform(0, 5)))
    for _ in range(200):
        d, e = 10.0 ** rng.uniform(0, 4), 10.0 ** rng.uniform(-2, 5)
        b, c = 10.0 ** rng.uniform(-3, 3), 10.0 ** rng.uniform(0, 4)
        b, c, d = (k * (rng.random() > 0.3) for k in (b, c, d))
        found.append(
            Parameters(
                cubic_coefficient=b,
                quartic_coefficient=c,
                quintic_coefficient=d,
                sextic_coefficient=e,
            )
        )
    return found


def test_turning_points_are_as_exact_as_the_coefficients_allow() -> None:
    for p in nearly_degenerate_films():
        powers, turns = range(1, film.HIGHEST_POWER + 1), solids.turning_points(p)
        k = [film.balance_coefficient(p, power) for power in powers]
        finite = [phi for phi in turns if phi < math.inf]
        assert len(finite) in (1, 3)
        assert finite == sorted(finite)
        for phi in finite:
            terms = np.array([n * k[n - 1] * phi ** (n - 1) for n in range(1, len(k) + 1)])
            assert abs(terms.sum()) <= 4e-16 * np.abs(terms).sum()


@pytest.mark.parametrize(
    ("lowest", "turns"),
    [
        ((0.0, 850.0, 0.0, 500.0), (0.0, math.inf, math.inf)),  # it falls from 0
        ((0.0, 0.0, 0.0, 500.0), (0.0, math.inf, math.inf)),
        ((0.0, 0.0, 400.0, 500.0), (0.6, math.inf, math.inf)),  # it rises from 0 as phi^3
        ((0.0, 144.0, 600.0, 450.0), (0.0, 0.2, 0.8)),
        ((230.0, 850.0, 0.0, 1e-9), (230.0 / 1700.0, math.inf, math.inf)),
    ],
)
def test_turning_points_where_coefficients_vanish(
    lowest: tuple[float, ...], turns: tuple[float, ...]
) -> None:
    names = ("cubic", "quartic", "quintic", "sextic")
    p = Parameters(**{f"{n}_coefficient": k for n, k in zip(names, lowest, strict=True)})
    np.testing.assert_allclose(solids.turning_points(p), turns, rtol=1e-12, atol=0)


def test_one_solid_has_one_turning_point() -> None:
    film_of_one = Parameters(sextic_coefficient=2000.0)
    turns = solids.turning_points(film_of_one)
    assert turns.between == turns.hard == math.inf
    slope = film.log_force_slope(film_of_one, turns.soft)
    assert slope == pytest.approx(0.0, abs=1e-9)
    assert 0.0 < turns.soft < solids.turning_points(Parameters()).soft


def test_the_only_turning_point_of_the_paper_is_b_over_2c() -> None:
    assert solids.turning_points(Parameters()).soft == 230.0 / 1700.0
    thresholds = solids.thresholds(Parameters())
    assert tuple(thresholds) == (230.0 / 1700.0, math.inf, math.inf, 0.0, 0.0)


def test_limits_of_the_solids() -> None:
    # The two solids of this film were designed to have these limits.
    limits = [solids.balance(TWO, phi) for phi in solids.turning_points(TWO)]
    assert limits == pytest.approx([11.482, 3.067, 3.594], abs=1e-3)
    strains = [math.sqrt((B - film.heating(TWO)) / TWO.elastic_coefficient) for B in limits]
    assert strains[2] == pytest.approx(6.6067e-6, abs=1e-10)  # hard to soft
    assert solids.melting_strain(TWO) == pytest.approx(6.7543e-6, abs=1e-10)
    assert solids.solidification_strain(TWO) == pytest.approx(6.5383e-6, abs=1e-10)
    assert solids.coexistence_limit(TWO) == pytest.approx(11.482, abs=1e-3)


def test_the_hard_solid_at_rest() -> None:
    at_rest = solids.largest_order_parameter(TWO)
    assert at_rest == pytest.approx(0.8904, abs=5e-5)
    assert film.log_force(TWO, at_rest, film.heating(TWO)) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("phi", "B", "soft"),
    [
        (0.3, 5.0, True),
        (0.3, 2.0, False),
        (0.3, 12.0, False),
        (0.45, 5.0, False),
        (0.1, 5.0, False),
    ],
)
def test_a_film_is_soft_where_a_soft_solid_exists(phi: float, B: float, soft: bool) -> None:
    assert solids.is_soft(solids.thresholds(TWO), phi, B) == soft
    assert not solids.is_soft(solids.thresholds(Parameters()), phi, B)


@pytest.mark.parametrize(
    ("B", "low", "high"), [(-100.0, R, 2.0), (3.5, R, 2.0), (3.6, P, Q), (11.4, P, Q)]
)
def test_the_hardest_stable_solid(B: float, low: float, high: float) -> None:
    phi = solids.solid_order_parameter(TWO, B)
    assert low < phi < high
    assert film.log_force(TWO, phi, B) == pytest.approx(0.0, abs=1e-9)
    assert film.log_force_slope(TWO, phi) > 0.0


def test_a_film_without_a_solid_has_the_order_parameter_of_the_last_one() -> None:
    assert solids.solid_order_parameter(TWO, 20.0) == pytest.approx(P, rel=1e-12)
    harder = with_turns(0.2, 0.25, 0.6)  # its hard solid disappears last
    assert solids.solid_order_parameter(harder, 1e4) == pytest.approx(0.6, rel=1e-12)


def test_thresholds_of_a_film_that_freezes_continuously() -> None:
    p = Parameters(cubic_coefficient=0.0, sextic_coefficient=500.0)
    assert solids.solid_threshold(p) == pytest.approx(0.5 * solids.largest_order_parameter(p))


def test_the_sextic_term_limits_the_level_of_the_noise() -> None:
    p = Parameters(
        temperature=290.0, cubic_coefficient=0.0, quartic_coefficient=0.0, sextic_coefficient=500.0
    )
    D_eff = noise.effective_intensity(p)
    assert noise.level(p) == pytest.approx((D_eff / (500.0 * 100.0)) ** (1 / 6), rel=1e-12)
