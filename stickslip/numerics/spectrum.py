"""Spectral radii of small matrices."""

from __future__ import annotations

import math

import numpy as np

from stickslip.compiled.decorators import jit, kernel

# With 2^24 factors the norm of a power tells the radius to 1e-6 even where eigenvectors are nearly
# parallel.
_SQUARINGS = 24


@jit
def _norm(matrix: np.ndarray) -> float:
    total = 0.0
    for i in range(matrix.shape[0]):
        for j in range(matrix.shape[1]):
            total += matrix[i, j] * matrix[i, j]
    return math.sqrt(total)


@jit
def _square(matrix: np.ndarray, norm: float, squared: np.ndarray) -> None:
    """Write the square of `matrix` (m, m) over `norm` into `squared` (m, m)."""
    for i in range(matrix.shape[0]):
        for j in range(matrix.shape[1]):
            total = 0.0
            for k in range(matrix.shape[0]):
                total += matrix[i, k] * matrix[k, j]
            squared[i, j] = total / (norm * norm)


@kernel
def spectral_radii(matrices: np.ndarray) -> np.ndarray:
    """Moduli (n,) of the largest eigenvalues of `matrices` (n, m, m); NaN where one holds NaN.

    By Gelfand's formula, ||A^k||^(1/k) for large k, with powers by repeated squaring: faster than a
    general solver, which finds all eigenvalues.
    """
    radii = np.empty(matrices.shape[0])
    power, squared = np.empty(matrices.shape[1:]), np.empty(matrices.shape[1:])
    for index in range(matrices.shape[0]):
        power[:] = matrices[index]
        logarithm, part = 0.0, 1.0
        for _ in range(_SQUARINGS):
            norm = _norm(power)
            logarithm += part * math.log(norm)
            if not norm > 0.0:
                break
            _square(power, norm, squared)
            power[:] = squared
            part *= 0.5
        radii[index] = math.exp(logarithm)
    return radii
