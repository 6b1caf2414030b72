"""Time of a step of Euler-Cromer in lanes, against the plain loop and against the machine's peak.

Nanoseconds of one core for a step of one trajectory: minima of several runs, in CPU time of the
thread. Operations are counted in the machine code of the hot loop; the peak is the least time in
which the machine can do as many, by rates measured in the same run.

`--quick` takes seconds. `--full` takes some ten minutes more: a whole period at the paper's step
of 1e-10 s for 64 temperatures, with every step measured, against the adaptive method.
"""

from __future__ import annotations

import math
import time
from itertools import product

import numba
import numpy as np
from common import arguments, finish
from inside import (
    first_period,
    fixed_amplitudes,
    fixed_lanes,
    march_assembly,
    scalar_steps,
)
from parts.machine_code import counted_in_loop, fastest, least_time, rates

from stickslip.compiled.simd import VECTOR
from stickslip.options import Options
from stickslip.parameters import Parameters

WIDTHS = (16, 32, 64)
GAMMAS = (-2 / 3, 0.0, 2 / 3, -0.5)
PAPER_STEP = 1e-10


def main() -> None:
    options = arguments(__doc__, full="a whole period at the paper's step")
    steps = 20_000 if options.quick else 200_000
    results = {"rates": rates(), "plain": {}, "scalar": {}, "lanes": []}
    for gamma in GAMMAS[:1] if options.quick else GAMMAS:
        results["plain"][f"{gamma:.2f}"] = plain_loop(gamma, steps)
        results["scalar"][f"{gamma:.2f}"] = scalar_kernel(gamma, steps)
        results["lanes"] += lane_rows(gamma, steps, results, quick=options.quick)
    if options.full:
        results["full_period"] = full_period()
    finish("fixed_lanes", results, quick=options.quick)


# --- the machine code -----------------------------------------------------------------------------


def counted_operations(gamma: float) -> dict[tuple[bool, bool], dict[str, float]]:
    """Vector operations in a step of eight lanes for (noise, measured), by kind."""
    lanes = fixed_lanes(points_of(gamma, 1, noise=True), PAPER_STEP)
    return {
        (noise, measured): counted_in_loop(march_assembly(gamma, noise, measured, lanes))
        for noise in (False, True)
        for measured in (False, True)
    }


# --- the scalar loops -----------------------------------------------------------------------------


@numba.njit
def _plain(n, dt, T, k, K, gamma, omega, X_m, M, h, tau, A, delta, alpha, T_c, a, b, c, x, v, phi):
    """The scheme as it stands in the paper, written down plainly."""
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


def plain_loop(gamma: float, steps: int) -> float:
    p = Parameters(rheological_index=gamma)
    arguments = (
        p.temperature, p.viscosity_coefficient, p.spring_stiffness, gamma, p.angular_frequency,
        p.drive_amplitude, p.block_mass, p.film_thickness, p.strain_relaxation_time,
        p.contact_area, p.kinetic_coefficient, p.thermal_coefficient, p.critical_temperature,
        p.elastic_coefficient, p.cubic_coefficient, p.quartic_coefficient, 0.0, 0.0, 0.3,
    )  # fmt: skip
    _plain(1, PAPER_STEP, *arguments)
    return fastest(lambda: _plain(steps, PAPER_STEP, *arguments), steps)


def scalar_kernel(gamma: float, steps: int) -> float:
    point = np.array(Parameters(rheological_index=gamma))
    options = Options(method="euler-cromer", dt=PAPER_STEP)
    scalar_steps(point, options, 1)
    return fastest(lambda: scalar_steps(point, options, steps), steps)


# --- lanes ----------------------------------------------------------------------------------------


def points_of(gamma: float, count: int, *, noise: bool) -> np.ndarray:
    """Temperatures of the solid and of the stick-slip region."""
    D = Parameters().noise_intensity if noise else 0.0
    return np.array(
        [
            Parameters(temperature=T, rheological_index=gamma, noise_intensity=D)
            for T in np.linspace(155.0, 280.0, count).tolist()
        ]
    )


def lane_rows(gamma: float, steps: int, results: dict, *, quick: bool) -> list[dict]:
    """Time of a step for some numbers of lanes, with and without noise and record.

    Beside it what it is of a plain loop and of the machine's peak, both as `results` has them.
    """
    plain, can = results["plain"][f"{gamma:.2f}"], results["rates"]
    operations = {} if quick else counted_operations(gamma)
    rows = []
    for noise, measured, width in product(
        (False, True), (False, True), WIDTHS[-1 if quick else 0 :]
    ):
        ns = lane_step(gamma, width, steps, noise=noise, measured=measured)
        row = {"gamma": round(gamma, 2), "lanes": width, "noise": noise, "measured": measured}
        row |= {"ns_per_step": ns, "times_faster_than_plain": plain / ns}
        if operations:
            counts = operations[noise, measured]
            row |= {"operations": counts, "part_of_peak": least_time(counts, can) / (VECTOR * ns)}
        rows.append(row)
        print("   " + "  ".join(f"{key} {_text(value)}" for key, value in row.items()))
    return rows


def lane_step(gamma: float, width: int, steps: int, *, noise: bool, measured: bool) -> float:
    """Nanoseconds of a step of one of so many lanes."""
    lanes = fixed_lanes(points_of(gamma, width, noise=noise), PAPER_STEP, phi=0.3)
    every, limits = np.arange(width), np.full(width, steps)

    def run() -> None:
        lanes.start(every, limits)
        lanes.march(measured)

    run()
    return fastest(run, steps * width)


def _text(value: object) -> str:
    return f"{value:.3g}" if isinstance(value, float) else str(value)


# --- a whole period -------------------------------------------------------------------------------


def full_period() -> dict:
    """A period from rest at the paper's step, 64 temperatures at once, against the adaptive one."""
    points = points_of(-2 / 3, 64, noise=True)
    lanes = fixed_lanes(points, PAPER_STEP)
    lanes.start(np.arange(len(points)))
    wall, cpu = time.perf_counter(), time.process_time()
    lanes.march(measured=True)
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    ends, exact = first_period(points, Options(rtol=1e-11))
    p = Parameters()
    scale = np.array([p.drive_amplitude, p.drive_amplitude * p.angular_frequency])
    errors = np.abs(lanes.states()[:, :2] - ends[:, :2]) / scale
    amplitudes = np.abs(fixed_amplitudes(lanes) / exact - 1.0)
    steps = int(lanes.steps.sum())
    return {
        "steps": steps,
        "statuses": lanes.tasks.status.tolist(),
        "wall_s": wall,
        "cpu_s": cpu,
        "ns_per_step": cpu * 1e9 / steps,
        "largest_error_x": float(errors[:, 0].max()),
        "largest_error_v": float(errors[:, 1].max()),
        "median_error_x": float(np.median(errors[:, 0])),
        "median_error_v": float(np.median(errors[:, 1])),
        "largest_error_stress_amplitude": float(amplitudes[:, 0].max()),
        "largest_error_force_amplitude": float(amplitudes[:, 1].max()),
    }


if __name__ == "__main__":
    main()
