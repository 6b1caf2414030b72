"""Rosenbrock methods as tables of coefficients, with a check of their order."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

Rows = tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class RosenbrockTableau:
    """A stiffly accurate Rosenbrock method, in the form without matrix products.

    With W = I/(h gamma) - J, stage i solves
    W u_i = f(t + c_i h, y + sum a_ij u_j) + sum (C_ij/h) u_j + h d_i df/dt.
    The argument of the last stage is the embedded solution, and y_new = y_embedded + u_last, so
    that u_last is the error estimate. `dense` has the rows of the two coefficients of the
    continuous extension (Hairer & Wanner, Solving ODEs II, IV.7). Raises ValueError if the order
    conditions fail.
    """

    name: str
    order: int
    gamma: float
    a: Rows
    C: Rows
    c: tuple[float, ...]
    d: tuple[float, ...]
    dense: Rows

    def __post_init__(self) -> None:
        for what, miss in self._misses().items():
            if abs(miss) > 1e-11:  # the published coefficients carry 13 to 16 digits
                raise ValueError(f"{self.name}: {what} is off by {miss:.1e}")

    def _misses(self) -> dict[str, float]:
        """Return the errors of consistency, stiff accuracy and the order conditions up to 4."""
        stages = len(self.c)
        a, C = _lower(self.a, stages), _lower(self.C, stages)
        Gamma = np.linalg.inv(np.eye(stages) / self.gamma - C)
        alpha = a @ Gamma
        b = (a[-1] + np.eye(stages)[-1]) @ Gamma
        beta = alpha + Gamma
        c, e = alpha.sum(axis=1), beta.sum(axis=1)
        strict = beta - self.gamma * np.eye(stages)
        f = strict.sum(axis=1)
        g = self.gamma
        return {
            "c": float(np.abs(c - self.c).max()),
            "d": float(np.abs(Gamma.sum(axis=1) - self.d).max()),
            "stiff accuracy": float(np.abs(b - beta[-1]).max()),
            "sum b": float(b.sum() - 1),
            "sum b beta": float(b @ e - 1 / 2),
            "sum b c^2": float(b @ c**2 - 1 / 3),
            "sum b beta beta": float(b @ strict @ f - (1 / 6 - g + g**2)),
            "sum b c^3": float(b @ c**3 - 1 / 4),
            "sum b c alpha beta": float(b @ (c * (alpha @ f)) - (1 / 8 - g / 3)),
            "sum b beta c^2": float(b @ strict @ c**2 - (1 / 12 - g / 3)),
            "sum b beta beta beta": float(
                b @ strict @ strict @ f - (1 / 24 - g / 2 + 3 / 2 * g**2 - g**3)
            ),
        }


def _lower(rows: Rows, stages: int) -> np.ndarray:
    """Return the strictly lower triangular matrix with these rows, padded with zeros."""
    matrix = np.zeros((stages, stages))
    for i, row in enumerate(rows):
        matrix[i, : len(row)] = row
    return matrix


RODAS4P2 = RosenbrockTableau(
    name="RODAS4P2",
    order=4,
    gamma=0.25,
    a=(
        (),
        (3.0,),
        (0.906377755268814, -0.189707390391685),
        (3.758617027739064, 1.161741776019525, -0.849258085312803),
        (7.089566927282776, 4.573591406461604, -8.423496976860259, -0.959280113459775),
        (7.089566927282776, 4.573591406461604, -8.423496976860259, -0.959280113459775, 1.0),
    ),
    C=(
        (),
        (-12.0,),
        (-6.354581592719008, 0.338972550544623),
        (-8.575016317114033, -7.606483992117508, 12.224997650124820),
        (-5.888975457523102, -8.157396617841821, 24.805546872612922, 12.790401512796979),
        (-4.408651676063871, -6.692003137674639, 24.625568527593117, 16.627521966636085,
         -5.714285714285718),
    ),
    c=(0.0, 0.75, 0.321448134013046, 0.519745732277726, 1.0, 1.0),
    d=(0.25, -0.5, -0.189532918363016, 0.085612108792769, 0.0, 0.0),
    dense=(
        (-5.323528268423303, -10.042123754867493, 17.175254928256965, -5.079931171878093,
         -0.016185991706112),
        (6.984505741529879, 6.914061169603662, -0.849178943070653, 18.104410789349338,
         -3.516963011559032),
    ),
)  # fmt: skip
"""Steinebach's RODAS4P2 (2020): like RODASP, but still of second order with an inexact Jacobian."""
