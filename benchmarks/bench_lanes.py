"""A step in lanes, of either method, beside what takes one trajectory at a time.

Of the adaptive method an attempted step in a search for orbits, and a drive period of one point by
the scalar integrator and in one of the lanes; of Euler-Cromer a step in a loop that is written down
plainly, and in lanes. And of both the part of the peak of the processor that they reach.
"""

from __future__ import annotations

import math
from itertools import product
from typing import Any

import numba
import numpy as np
from inside.fixed import fixed_lanes
from inside.lanes import end_states, searched
from inside.operations import attempted_steps, fixed_step_operations, peak
from inside.scalar import scalar_end
from shared.measuring import measure
from shared.points import parameter, random_points
from shared.timing import fastest, pin

from stickslip.compiled.simd import LANES
from stickslip.options import Options
from stickslip.parameters import Parameters

ADAPTIVE_GAMMAS = (-2 / 3, -1 / 3, 0.0, 1 / 3, 2 / 3, -1 / 2)
SEED, POINTS = 7, 4096
PERIODS = 20  # of a single trajectory
FIXED_GAMMAS = (-2 / 3, 0.0, 2 / 3, -0.5)
WIDTHS = (16, 32, 64)
PAPER_STEP = 1e-10


# --- the adaptive method --------------------------------------------------------------------------


def adaptive(quick: bool) -> dict[str, Any]:
    """Time an attempted step of all lanes in a search, and a period of one point."""
    drawn = random_points(POINTS // 16 if quick else POINTS, SEED)
    gammas, rows = parameter(drawn, "rheological_index"), {}
    for gamma in ADAPTIVE_GAMMAS[:1] if quick else ADAPTIVE_GAMMAS:
        points = drawn[np.isclose(gammas, gamma)]
        rows[f"{gamma:.2f}"] = row = {"search": _search(points), "single": _single(points[0])}
        print(f"gamma = {gamma:.2f}", row)
    return {"lanes": LANES, "fluids": rows}


def _search(points: np.ndarray) -> dict[str, float]:
    """Time an attempted step of all lanes in the search for orbits of many points."""
    options = Options(rtol=1e-4, max_periods=64)
    attempts = searched(points, options)
    ns = fastest(lambda: searched(points, options), attempts / LANES, 3)
    return {"points": len(points), "ns": ns}


def _single(point: np.ndarray) -> dict[str, float]:
    """Time a drive period of one point by either way, and see that the ends agree."""
    options = Options(rtol=1e-6)

    def by_scalar() -> float:
        return scalar_end(point, options, PERIODS)[0]

    def by_lanes() -> float:
        return end_states(point[None], PERIODS, options)[0][0, 0]

    size = parameter(point[None], "drive_amplitude")[0]
    assert abs(by_scalar() - by_lanes()) < 1e-4 * size
    scalar, lanes = (fastest(run, PERIODS, 9) for run in (by_scalar, by_lanes))
    return {"scalar_ns": scalar, "one_lane_ns": lanes, "ratio": lanes / scalar}


# --- Euler-Cromer ---------------------------------------------------------------------------------


def fixed(quick: bool) -> dict[str, Any]:
    """Time a step of one trajectory in a plain loop and in lanes."""
    steps = 20_000 if quick else 200_000
    plain, lanes = {}, []
    for gamma in FIXED_GAMMAS[:1] if quick else FIXED_GAMMAS:
        name = f"{gamma:.2f}"
        plain[name] = _plain_loop(gamma, steps)
        print(f"gamma = {name}: plain loop {plain[name]:.3g} ns")
        lanes += _lane_rows(gamma, steps, plain[name], WIDTHS[-1:] if quick else WIDTHS)
    return {"plain": plain, "lanes": lanes}


@numba.njit
def _plain(n, dt, T, k, K, gamma, omega, X_m, M, h, tau, A, delta, alpha, T_c, a, b, c, x, v, phi):
    """Follow the scheme as it stands in the paper, written down plainly."""
    for i in range(n):
        V = -X_m * omega * math.sin(omega * i * dt)
        u = V - v
        eps = tau * u / h
        sigma_el = a * phi**2 * eps
        sigma_v = k * (abs(u) / h) ** (gamma + 1) * np.sign(u)
        F = (sigma_el + sigma_v) * A
        B = a * eps**2 + 2 * alpha * (T - T_c)
        v += dt * (F - 2 * K * x) / M
        x += dt * v
        phi = abs(phi - dt * delta * phi * (B - b * phi + c * phi**2))
    return x, v, phi


def _plain_loop(gamma: float, steps: int) -> float:
    p = Parameters(rheological_index=gamma)
    arguments = (*p[:7], *p[10:19], 0.0, 0.0, 0.3)  # without the start; then x, v and phi
    _plain(1, PAPER_STEP, *arguments)
    return fastest(lambda: _plain(steps, PAPER_STEP, *arguments), steps)


def _lane_rows(gamma: float, steps: int, plain: float, widths: tuple[int, ...]) -> list[dict]:
    """Time a step for some numbers of lanes, with and without noise and record."""
    rows = []
    for noise, measured, width in product((False, True), (False, True), widths):
        ns = _lane_step(gamma, width, steps, noise=noise, measured=measured)
        row = {"gamma": round(gamma, 2), "lanes": width, "noise": noise, "measured": measured}
        rows.append(row | {"ns_per_step": ns, "times_faster_than_plain": plain / ns})
        print("   ", rows[-1])
    return rows


def _lane_step(gamma: float, width: int, steps: int, *, noise: bool, measured: bool) -> float:
    """Return the nanoseconds of a step of one of so many lanes, between solid and stick-slip."""
    points = np.tile(Parameters(rheological_index=gamma), (width, 1))
    parameter(points, "temperature")[:] = np.linspace(155.0, 280.0, width)
    parameter(points, "noise_intensity")[:] *= noise
    lanes = fixed_lanes(points, PAPER_STEP, phi=0.3)

    def run() -> None:
        lanes.start(np.arange(width), np.full(width, steps))
        lanes.march(measured)

    run()
    return fastest(run, steps * width)


# --- parts of the peak ----------------------------------------------------------------------------

PEAK_GAMMAS = (-2 / 3, 0.0, 2 / 3)
_ATTEMPTS = 5000


def of_peak(quick: bool) -> dict[str, Any]:
    """Time a step by itself, of either method, and a search, as parts of the peak of a core."""
    pin()
    highest = peak()
    drawn = random_points(POINTS // 16 if quick else POINTS, SEED)
    gammas, rows = parameter(drawn, "rheological_index"), {}
    for gamma in PEAK_GAMMAS[:1] if quick else PEAK_GAMMAS:
        points = drawn[np.isclose(gammas, gamma)]
        own, attempts = attempted_steps(points[0], gamma, 1e-4, _ATTEMPTS)
        attempts()
        fixed_own = fixed_step_operations(gamma)
        row = {
            "attempt": _part(own * LANES, fastest(attempts, _ATTEMPTS), highest),
            "search": _part(own * LANES, _search(points)["ns"], highest),
            "fixed": _part(
                fixed_own,
                _lane_step(gamma, WIDTHS[-1], 200_000, noise=False, measured=False),
                highest,
            ),
        }
        rows[f"{gamma:.2f}"] = row
        print(f"gamma = {gamma:.2f}", row)
    return {"operations_per_ns": max(highest, peak()), "lanes": LANES, "fluids": rows}


def _part(operations: float, ns: float, highest: float) -> dict[str, float]:
    return {"operations": operations, "ns": ns, "of_peak": operations / ns / highest}


if __name__ == "__main__":
    measure("lanes", __doc__, {"adaptive": adaptive, "fixed": fixed, "peak": of_peak})
