"""The stochastic film by the plainest means: Euler-Maruyama in SI units, written from the paper.

An independent check of the ensembles: it shares no code with the package.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit


@njit(nogil=True)
def single_periods(
    p: np.ndarray, dt: float, start: np.ndarray, kicks: np.random.Generator, periods: int
) -> np.ndarray:
    """Return largest and smallest elastic stress [Pa] of each drive period, (periods, 2).

    `p` (parameters,) as `stickslip.Parameters`; `dt` [s] a step; `start` (3,) the state (x, v, phi)
    at phase 0; `kicks` gives the increments.
    """
    T, k, K, gamma, omega, X_m, M = p[0], p[1], p[2], p[3], p[4], p[5], p[6]
    h, tau, A, delta, alpha, T_c = p[10], p[11], p[12], p[13], p[14], p[15]
    a, b, c, D = p[16], p[17], p[18], p[19]
    steps = math.ceil(2.0 * math.pi / omega / dt)
    dt = 2.0 * math.pi / omega / steps
    x, v, phi = start[0], start[1], start[2]
    kick, heating = math.sqrt(2.0 * D * dt), 2.0 * alpha * (T - T_c)
    turn_cosine, turn_sine = math.cos(omega * dt), math.sin(omega * dt)
    found = np.empty((periods, 2))
    for period in range(periods):
        cosine, sine = 1.0, 0.0  # of the drive's phase, set right again each period
        high, low = -np.inf, np.inf
        for _ in range(steps):
            u = -X_m * omega * sine - v
            eps = u * tau / h
            viscous = math.copysign(k * (abs(u) / h) ** (gamma + 1.0), u)
            elastic = a * phi * phi * eps
            force = (elastic + viscous) * A
            slope = (a * eps * eps + heating - b * phi + c * phi * phi) * phi
            high, low = max(high, elastic), min(low, elastic)
            v += dt * (force - 2.0 * K * x) / M
            x += dt * v
            phi = abs(phi - dt * delta * slope + kick * kicks.standard_normal())
            cosine, sine = (
                cosine * turn_cosine - sine * turn_sine,
                sine * turn_cosine + cosine * turn_sine,
            )
        found[period] = high, low
    return found
