"""Pseudoplastic films that lock the block, and the closed form of their loss without slip.

This is plain NumPy and shares nothing with `model`.
"""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from stickslip import Parameters

_POINTS, _HALVINGS = 400, 80  # points of the quadrature, halvings of the interval of ln u


def films(count: int, seed: int = 4303) -> np.ndarray:
    """Return rows (count, parameters) of solid films whose block starts where the drive does."""
    rng, rows = np.random.default_rng(seed), []

    def log_uniform(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    for _ in range(count):
        X_m = log_uniform(4e-8, 8e-7)
        rows.append(
            Parameters(
                rheological_index=rng.uniform(-0.9, -0.3),
                viscosity_coefficient=log_uniform(1e4, 1e6),
                spring_stiffness=log_uniform(300.0, 3000.0),
                drive_amplitude=X_m,
                temperature=rng.uniform(150.0, 280.0),
                angular_frequency=log_uniform(3.0, 60.0),
                initial_displacement=X_m,
                initial_order_parameter=0.6,
            )
        )
    return np.array(rows)


def no_slip(points: np.ndarray) -> SimpleNamespace:
    """Return the `work` [J] in a period of blocks that move with the drive, and their `slip`/X_m.

    Both are arrays (n,). F = (2K - M omega^2) X_m cos(omega t). The film has the order parameter of
    a solid at rest, and slips with the u at which it carries F.
    """
    p = dict(zip(Parameters._fields, points.T[:, :, None], strict=True))
    heating = 2.0 * p["thermal_coefficient"] * (p["temperature"] - p["critical_temperature"])
    b, c = p["cubic_coefficient"], p["quartic_coefficient"]
    phi = (b + np.sqrt(b * b - 4.0 * c * heating)) / (2.0 * c)
    elastic = p["elastic_coefficient"] * phi**2 * p["strain_relaxation_time"]
    omega, h, X_m = p["angular_frequency"], p["film_thickness"], np.abs(p["drive_amplitude"])
    nodes, weights = np.polynomial.legendre.leggauss(_POINTS)
    phases, weights = 0.25 * np.pi * (nodes + 1.0), 0.25 * np.pi * weights  # a quarter period
    stiffness = np.abs(2.0 * p["spring_stiffness"] - p["block_mass"] * omega**2)
    F = stiffness * X_m * np.cos(phases)
    low, high = np.full(F.shape, -2000.0), np.full(F.shape, 60.0)  # of the logarithm of u/h
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        viscous = p["viscosity_coefficient"] * np.exp((p["rheological_index"] + 1.0) * middle)
        above = (elastic * np.exp(middle) + viscous) * p["contact_area"] > F
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    u = h * np.exp(0.5 * (low + high))
    work = 4.0 * (weights * F * u).sum(axis=1) / omega[:, 0]
    return SimpleNamespace(work=work, slip=2.0 * (weights * u).sum(axis=1) / (omega * X_m)[:, 0])
