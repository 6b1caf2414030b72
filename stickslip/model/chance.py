"""The weak additive noise of Eq. 26 as a random process, and its effect in a step.

phi = |X| with dX = -delta f'(|X|) sgn(X) dt + sqrt(2 D) dW solves Eq. 26 with reflection at 0: the
drift of X is odd, so that X itself needs no reflection. If a step without noise takes phi_0 to
phi_1, X is phi_1 + S xi, where xi is a standard normal number and S^2 the variance that the
linearised equation accumulates along that path. Where the drift is linear, as it is while phi is
small, this is the exact transition for a step of any length (an Ornstein-Uhlenbeck process).
Elsewhere its weak error is of first order in the step, and small for small D (docs/equations.md).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any

from stickslip.compiled.decorators import inline
from stickslip.compiled.elementary import exponentials, logarithm
from stickslip.compiled.fields import make_function
from stickslip.model import film
from stickslip.model.state import FILM
from stickslip.parameters import Parameters

# A step is divided into this many pieces, each with its own rate of growth.
_PIECES = 4

# Below this exponent the mean of an exponential is computed from its series.
_SMALL_EXPONENT = 0.1

# Floors of ln(phi), and of the factor by which the noise changes phi.
_LEAST_LOG_PHI, _SMALLEST = -300.0, 1e-300


@inline
def _log_slope(p: Parameters, psi: float) -> float:
    """Derivative of the rate of psi = ln(phi) with respect to psi [1/s]."""
    return -p.kinetic_coefficient * film.log_force_slope(p, exponentials(psi)[0])


@inline
def variance_after(variance: float, growth: float, curvature: float, added: float) -> float:
    """Variance after a time t in which small displacements grow by exp(`growth`).

    Their growth rate is linear in time; `curvature` is the second difference of the exponent.
    `added` is the variance that noise alone would add in this time, 2 D t.
    """
    grown, _ = exponentials(growth)
    squared, z = grown * grown, 2.0 * growth
    inverse = 1.0 / z
    # Means of exp(z s) and of s (1 - s) exp(z s) over the remaining time s, from 0 to 1.
    mean = (squared - 1.0) * inverse
    bump = (squared + 1.0 - 2.0 * mean) * (inverse * inverse)
    series = 1 / 40 + z * (1 / 180 + z * (1 / 1008 + z * (1 / 6720)))
    small_bump = 1 / 6 + z * (1 / 12 + z * series)
    small = abs(z) < _SMALL_EXPONENT
    series = 1 / 24 + z * (1 / 120 + z * (1 / 720 + z * (1 / 5040 + z * (1 / 40320))))
    small_mean = 1.0 + z * (0.5 + z * (1 / 6 + z * series))
    mean, bump = (small_mean, small_bump) if small else (mean, bump)
    return variance * squared + added * (mean + curvature * bump)


@cache
def make_deviation(interpolate: Callable[..., Any], pieces: int = _PIECES) -> Any:
    """Return the function (p, h, y0, y1, d1, d2) of the standard deviation S of X after a step.

    The step of length h leads from y0 to y1; d1 and d2 are the coefficients of its continuous
    extension, which `interpolate` evaluates.
    """
    each = range(pieces)
    lines = [
        f"psi{i} = interpolate({i / pieces!r}, y0, y1, d1, d2)[{FILM}]" for i in range(pieces + 1)
    ]
    lines += [f"slope{i} = log_slope(p, psi{i})" for i in range(pieces + 1)]
    lines += [f"half, added = {0.5 / pieces!r} * h, {2.0 / pieces!r} * (p.noise_intensity * h)"]
    # Second differences at the nodes, and from these in the middle of the pieces, because the
    # extension is of third order.
    lines += [f"bend{i} = psi{i + 1} - 2.0 * psi{i} + psi{i - 1}" for i in each if i > 0]
    lines += [f"curve{i} = 0.5 * (bend{i} + bend{i + 1})" for i in each if 0 < i < pieces - 1]
    lines += ["curve0 = 1.5 * bend1 - 0.5 * bend2"]
    lines += [f"curve{pieces - 1} = 1.5 * bend{pieces - 1} - 0.5 * bend{pieces - 2}"]
    lines += ["variance = 0.0"]
    for i in each:
        # A displacement of phi = exp(psi) grows with phi, and with the slope of the rate of psi.
        growth = f"psi{i + 1} - psi{i} + half * (slope{i} + slope{i + 1})"
        lines += [f"variance = variance_after(variance, {growth}, curve{i}, added)"]
    lines += ["return sqrt(variance if variance > 0.0 else 0.0)"]
    names = {
        "interpolate": interpolate,
        "log_slope": _log_slope,
        "variance_after": variance_after,
        "sqrt": math.sqrt,
    }
    name = f"deviation[{interpolate.__name__},{pieces}]"
    return make_function(name, "p, h, y0, y1, d1, d2", lines, names)


@inline
def disturbed(psi: float, deviation: float, xi: float) -> float:
    """ln|X| for X = exp(psi) + `deviation` xi."""
    base = psi if psi > _LEAST_LOG_PHI else _LEAST_LOG_PHI
    _, inverse_phi = exponentials(base)
    moved = abs(1.0 + (deviation * inverse_phi) * xi)
    moved = moved if moved > _SMALLEST else _SMALLEST
    after = base + logarithm(moved)
    return after if deviation > 0.0 else psi


@inline
def bending(p: Parameters, psi: float, deviation: float, h: float) -> float:
    """Change of the drift over the width of the noise, times a step `h`: 0 for a linear drift."""
    phi, _ = exponentials(psi)
    force, displaced = film.log_force(p, phi, 0.0), film.log_force(p, phi + deviation, 0.0)
    return p.kinetic_coefficient * h * abs(displaced - force)
