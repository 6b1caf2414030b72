"""Problems in three variables with known difficulties for the steps of an implicit method."""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate import solve_ivp

from stickslip.compiled.decorators import inline

# The problem -u_s is a cusp that is rounded below the speed u_s.
CUSP, SMOOTH, STIFF, BECOMES_NAN, ESCAPES, IS_NAN, OVERFLOWS, UNANNOUNCED = map(float, range(8))

START = (0.4, 1.0, 0.7)


@inline
def rhs(p, t, y):
    a, b, c = y
    if p == SMOOTH:
        return (
            b * c + math.cos(t),
            -a * c + 0.5 * b * math.sin(2.0 * t),
            -0.5 * a * b - 0.3 * c * c * c + math.exp(-t),
        )
    if p == STIFF:
        return -1e9 * a, -1e6 * (b - math.cos(t)), a - c
    if p <= CUSP:  # the viscous force of a pseudoplastic fluid
        return 1.0 - a * max(a * a + p * p, 1e-180) ** (-1.0 / 3.0), 0.0, 0.0
    if p in (BECOMES_NAN, UNANNOUNCED):
        return math.sqrt(0.5 - t), -b, -c
    if p == ESCAPES:
        return a * a, -b, -c
    if p == OVERFLOWS:
        return math.exp(1e3 * a), -b, -c
    return math.nan, -b, -c


@inline
def jacobian(p, t, y):
    a, b, c = y
    zero = (0.0, 0.0, 0.0)
    decay = (0.0, -1.0, 0.0), (0.0, 0.0, -1.0), zero
    if p == SMOOTH:
        return (
            (0.0, c, b),
            (-c, 0.5 * math.sin(2.0 * t), -a),
            (-0.5 * b, -0.5 * a, -0.9 * c * c),
            (-math.sin(t), b * math.cos(2.0 * t), -math.exp(-t)),
        )
    if p == STIFF:
        rate = -1e6 * math.sin(t)
        return (-1e9, 0.0, 0.0), (0.0, -1e6, 0.0), (1.0, 0.0, -1.0), (0.0, rate, 0.0)
    if p <= CUSP:
        square = max(a * a + p * p, 1e-180)
        slope = square ** (-1.0 / 3.0) * (1.0 - (2.0 / 3.0) * a * a / square)
        return (-slope, 0.0, 0.0), zero, zero, zero
    if p == ESCAPES:
        return (2.0 * a, 0.0, 0.0), decay[0], decay[1], zero
    if p == OVERFLOWS:
        return (1e3 * math.exp(1e3 * a), 0.0, 0.0), decay[0], decay[1], zero
    if p == BECOMES_NAN:
        return zero, decay[0], decay[1], (-0.5 / math.sqrt(0.5 - t), 0.0, 0.0)
    return zero, decay[0], decay[1], zero


def smooth_solution(times: np.ndarray) -> np.ndarray:
    """Return the smooth problem from `START` at these times, shape (n, 3), to about 1e-13."""
    solution = solve_ivp(
        lambda t, y: rhs.py_func(SMOOTH, t, y),
        (0.0, float(times[-1])),
        START,
        method="DOP853",
        t_eval=times,
        rtol=1e-13,
        atol=1e-15,
    )
    return solution.y.T
