"""Stochastic noise over a step: exact where the drift is linear, of first order elsewhere."""

import math
from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import quad
from scipy.linalg import expm
from scipy.special import erf

from stickslip import Parameters
from stickslip.compiled.decorators import jit
from stickslip.model import film
from stickslip.model.chance import bending, disturbed, make_deviation
from stickslip.numerics.linear import algebra

PAPER = Parameters()
deviation = make_deviation(algebra(3).interpolate)


@jit
def _film_step(p: Parameters, psi0: float, B: float, h: float) -> tuple[float, float]:
    """ln(phi) after a step at a fixed melting function without noise, and the deviation S there."""
    rate, pieces = -p.kinetic_coefficient, 200
    k, psi = h / pieces, psi0
    for _ in range(pieces):
        k1 = rate * film.log_force(p, math.exp(psi), B)
        k2 = rate * film.log_force(p, math.exp(psi + 0.5 * k * k1), B)
        k3 = rate * film.log_force(p, math.exp(psi + 0.5 * k * k2), B)
        k4 = rate * film.log_force(p, math.exp(psi + k * k3), B)
        psi += k / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)
    f0 = h * rate * film.log_force(p, math.exp(psi0), B)
    f1 = h * rate * film.log_force(p, math.exp(psi), B)
    d1 = f0 - (psi - psi0)  # of the cubic with these slopes
    d2 = (psi - psi0) - d1 - f1
    S = deviation(p, h, (0.0, 0.0, psi0), (0.0, 0.0, psi), (0.0, 0.0, d1), (0.0, 0.0, d2))
    return psi, S


def spread(p: Parameters, h: float, change: float, d1: float = 0.0, d2: float = 0.0) -> float:
    """S after a step from a very small phi, in which ln(phi) changes by `change`."""
    y0, y1 = (0.0, 0.0, -200.0), (0.0, 0.0, -200.0 + change)
    return float(deviation(p, h, y0, y1, (0.0, 0.0, d1), (0.0, 0.0, d2)))


# --- linear drift --------------------------------------------------------------------------------


@pytest.mark.parametrize("growth", [-3e4, -50.0, -1.0, -1e-3, 1e-9, 0.5, 20.0])
def test_the_noise_of_an_ornstein_uhlenbeck_process_is_exact(growth: float) -> None:
    h = 1e-3
    exact = PAPER.noise_intensity * h * math.expm1(2.0 * growth) / growth
    assert spread(PAPER, h, growth) ** 2 == pytest.approx(exact, rel=1e-13, abs=0.0)


@pytest.mark.parametrize(
    ("change", "d1", "d2", "allowed"),
    [
        (-3.0, 1.0, 0.5, 5e-4),
        (2.0, -1.0, 1.0, 5e-4),
        (-300.0, 30.0, 10.0, 2e-3),
        (-2e4, 4e3, 1e3, 2e-3),
        (0.0, -6.0, 0.0, 5e-3),  # melts, then freezes
    ],
)
def test_the_noise_at_a_changing_rate(change: float, d1: float, d2: float, allowed: float) -> None:
    h = 1e-3

    def psi(s: float) -> float:
        return (1.0 - s) * 0.0 + s * (change + (1.0 - s) * (d1 + s * d2))

    def integrand(s: float) -> float:
        return math.exp(2.0 * (psi(1.0) - psi(s)))

    ends = [0.0, 0.5, 0.9, 0.99, 0.999, 0.9999, 1.0]
    total = sum(quad(integrand, a, b)[0] for a, b in pairwise(ends))
    exact = math.sqrt(2.0 * PAPER.noise_intensity * h * total)
    assert spread(PAPER, h, change, d1, d2) == pytest.approx(exact, rel=allowed, abs=0.0)


def test_no_noise_has_no_spread() -> None:
    assert spread(PAPER._replace(noise_intensity=0.0), 1e-3, -700.0) == 0.0


def test_a_solid_suppresses_the_noise() -> None:
    # Around the minimum small displacements decay at the rate delta f''.
    psi = math.log(0.6)
    rate = PAPER.kinetic_coefficient * film.log_force_slope(PAPER, math.exp(psi))
    h = 100.0 / rate
    y = (0.0, 0.0, psi)
    S = deviation(PAPER, h, y, y, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    assert pytest.approx(math.sqrt(PAPER.noise_intensity / rate), rel=1e-12) == S


# --- a displacement ------------------------------------------------------------------------------


@pytest.mark.parametrize("psi", [-400.0, -26.0, -0.5])
@pytest.mark.parametrize("xi", [-2.0, 0.0, 1.5])
def test_the_order_parameter_after_the_noise(psi: float, xi: float) -> None:
    S = 1e-11
    phi = abs(math.exp(max(psi, -300.0)) + S * xi)  # -300 is the floor of ln(phi)
    assert disturbed(psi, S, xi) == pytest.approx(math.log(phi))


def test_without_noise_nothing_is_displaced() -> None:
    assert disturbed(-5000.0, 0.0, 1.0) == -5000.0


@pytest.mark.parametrize("xi", [-1e11, -1.0])
def test_an_order_parameter_near_0_has_a_finite_logarithm(xi: float) -> None:
    assert math.isfinite(disturbed(0.0, 1.0, xi))


def test_the_drift_is_linear_over_noise_as_weak_as_in_the_paper() -> None:
    assert bending(PAPER, -26.0, 1e-11, 1e-3) < 1e-4
    assert bending(PAPER, -3.0, 0.1, 1e-3) > 0.1


# --- nonlinear drift: the weak order -------------------------------------------------------------

# A film at a fixed strain under a strong noise: temperature, intensity, strain, time, start.
SCENES = {
    "freezing": (200.0, 100.0, 0.0, 1e-4, 0.05),
    "hardly solid": (295.0, 10.0, 0.0, 2e-4, 0.3),
    "under strain": (200.0, 20.0, 6e-6, 4e-4, 0.05),
}
_CELLS, _LARGEST = 400, 1.6
Array = NDArray[np.float64]


def by_steps(p: Parameters, B: float, h: float, steps: int, grid: Array, density: Array) -> Array:
    """The density after some steps of the scheme, from its Gaussian transitions."""
    edges = np.concatenate([[0.0], 0.5 * (grid[1:] + grid[:-1]), [_LARGEST]])
    transition = np.empty((_CELLS, _CELLS))
    for column, phi in enumerate(grid):
        psi, S = _film_step.alone(p, math.log(phi), B, h)
        at = (edges[:, None] + np.array([-1.0, 1.0]) * math.exp(psi)) / (S * math.sqrt(2.0))
        transition[:, column] = np.diff(0.5 * erf(at).sum(axis=1))
    for _ in range(steps):
        density = transition @ density
    return density


def exactly(p: Parameters, B: float, time: float, grid: Array, density: Array) -> Array:
    """The density from the Fokker-Planck equation, in exponentially fitted finite volumes."""
    D, width = p.noise_intensity, grid[1] - grid[0]
    b, c = p.cubic_coefficient, p.quartic_coefficient
    energy = 0.5 * B * grid**2 - b / 3.0 * grid**3 + 0.25 * c * grid**4
    drop = np.diff(energy) * p.kinetic_coefficient / D
    up, down = drop / np.expm1(drop) * D / width**2, -drop / np.expm1(-drop) * D / width**2
    rates = np.diag(up, -1) + np.diag(down, 1)
    rates -= np.diag(rates.sum(axis=0))
    return np.asarray(expm(rates * time) @ density)


@pytest.mark.parametrize("scene", SCENES)
def test_the_weak_order_is_one(scene: str) -> None:
    T, D, eps, time, start = SCENES[scene]
    p = Parameters(temperature=T, noise_intensity=D)
    B = film.melting_function(p, eps)
    grid = (np.arange(_CELLS) + 0.5) * _LARGEST / _CELLS
    density = np.exp(-0.5 * ((grid - start) / 0.03) ** 2)
    density /= density.sum()
    reference = exactly(p, B, time, grid, density)
    assert reference.sum() == pytest.approx(1.0)
    errors = []
    for steps in (4, 8, 16):
        found = by_steps(p, B, time / steps, steps, grid, density)
        errors.append([abs((found - reference) @ grid**power) for power in (1, 2)])
    slopes = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    np.testing.assert_allclose(slopes, 1.0, atol=0.2)
