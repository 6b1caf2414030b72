"""Spectral radii of small matrices, and fixed points of affine maps."""

from __future__ import annotations

import math

import numpy as np

from stickslip.compiled.decorators import jit, kernel_making_arrays

# With 2^24 factors the norm of a power gives the radius to 1e-6 even if eigenvectors are nearly
# parallel.
_SQUARINGS = 24

# If a normalised power and its square agree to this precision, they differ by a factor, the largest
# eigenvalue. A factor below the second number proves nothing: eigenvectors are nearly parallel.
_SAME = 1e-9
_SMALLEST_FACTOR = 1e-3

# The square of a smaller norm would underflow.
_FORGOTTEN = 1e-150


@jit
def _copy(matrix: np.ndarray, target: np.ndarray) -> None:
    # `target[:] = matrix` would take seconds to compile, for the message of an impossible error.
    for i in range(matrix.shape[0]):
        for j in range(matrix.shape[1]):
            target[i, j] = matrix[i, j]


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


@jit
def _replace(power: np.ndarray, norm: float, squared: np.ndarray, size: float) -> float:
    """Copy `squared` into `power`; return the distance of the two at norm 1, up to a sign."""
    apart, opposite = 0.0, 0.0
    for i in range(power.shape[0]):
        for j in range(power.shape[1]):
            before, after = power[i, j] / norm, squared[i, j] / size
            apart = max(apart, abs(after - before))
            opposite = max(opposite, abs(after + before))
            power[i, j] = squared[i, j]
    return min(apart, opposite)


@jit
def _spectral_radius(power: np.ndarray, squared: np.ndarray) -> float:
    """Return the spectral radius of `power` (m, m); overwrites `power` and `squared` (m, m)."""
    logarithm, part, norm = 0.0, 1.0, _norm(power)
    for _ in range(_SQUARINGS):
        logarithm += part * math.log(norm)
        if not norm > _FORGOTTEN:
            break
        _square(power, norm, squared)
        size = _norm(squared)
        if _replace(power, norm, squared, size) < _SAME and size > _SMALLEST_FACTOR:
            return math.exp(logarithm + part * math.log(size))
        norm, part = size, 0.5 * part
    return math.exp(logarithm)


@kernel_making_arrays
def spectral_radii(matrices: np.ndarray) -> np.ndarray:
    """Return the moduli (n,) of the largest eigenvalues of `matrices` (n, m, m); NaN for NaN.

    It uses Gelfand's formula, ||A^k||^(1/k) for large k, by repeated squaring, which is faster than
    a general solver for all eigenvalues.
    """
    count, size = matrices.shape[0], matrices.shape[1]
    radii, power, squared = np.empty(count), np.empty((size, size)), np.empty((size, size))
    for index in range(count):
        _copy(matrices[index], power)
        radii[index] = _spectral_radius(power, squared)
    return radii


@jit
def _eliminate(matrix: np.ndarray, target: np.ndarray) -> None:
    """Solve `matrix` (m, m) y = `target` (m,) in place; inf or NaN if there is no solution."""
    size = len(target)
    for column in range(size):
        pivot = column
        for row in range(column + 1, size):
            if abs(matrix[row, column]) > abs(matrix[pivot, column]):
                pivot = row
        for j in range(size):
            matrix[column, j], matrix[pivot, j] = matrix[pivot, j], matrix[column, j]
        target[column], target[pivot] = target[pivot], target[column]
        for row in range(size):
            if row != column:
                factor = matrix[row, column] / matrix[column, column]
                for j in range(column, size):
                    matrix[row, j] -= factor * matrix[column, j]
                target[row] -= factor * target[column]
    for row in range(size):
        target[row] /= matrix[row, row]


@kernel_making_arrays
def rest_points(maps: np.ndarray, shifts: np.ndarray) -> np.ndarray:
    """Return the fixed points (n, m) of y -> A y + s, for `maps` A (n, m, m) and `shifts` s (n, m).

    They are NaN if A contains NaN.
    """
    found, matrix = shifts.copy(), np.empty(maps.shape[1:])
    for index in range(len(maps)):
        for i in range(maps.shape[1]):
            for j in range(maps.shape[1]):
                matrix[i, j] = (1.0 if i == j else 0.0) - maps[index, i, j]
        _eliminate(matrix, found[index])
    return found
