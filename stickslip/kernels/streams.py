"""The random numbers of stochastic paths, and how kernels draw them.

A number is a function of the point's key, the realization, the drive period and the step within it.
It does not depend on any other computation.
"""

from __future__ import annotations

import hashlib
import math

import numpy as np

from stickslip.compiled.decorators import inline
from stickslip.numerics.philox import Words, normal, philox, word_of
from stickslip.options import Options
from stickslip.parameters import Parameters
from stickslip.variables import PARAMETERS

KEY_LOW, KEY_HIGH, PATH, PERIOD, STREAM = range(5)
"""The STREAM numbers of a stream are two words of the key, the realization and the drive period."""

SIGNS = 32
"""Number of steps whose random signs come from one word."""

_WORD = 2**32


def keys_of(points: np.ndarray, seed: int) -> np.ndarray:
    """Return the keys (n, 2) of points (n, parameters), each of two 32-bit words.

    A mirror image has the key of its original. A parameter that the paper does not have enters only
    if it is not at its default; tolerances and versions never enter.
    """
    return np.array([_key(Parameters(*point), seed) for point in points]).reshape(-1, 2)


def _key(parameters: Parameters, seed: int) -> tuple[float, float]:
    sign = math.copysign(1.0, parameters.drive_amplitude)
    digest = hashlib.blake2b(seed.to_bytes(8, "little"), digest_size=8)
    for name, value in parameters._asdict().items():
        if PARAMETERS[name].in_paper or value != PARAMETERS[name].default:
            mirrored = sign * value + 0.0 if PARAMETERS[name].directed else value  # no -0
            digest.update(f"{name}={mirrored!r}\0".encode())
    high, low = divmod(int.from_bytes(digest.digest(), "little"), _WORD)
    return float(low), float(high)


def streams_of(points: np.ndarray, options: Options) -> np.ndarray:
    """Return the streams (n*realizations, STREAM) of points (n, parameters) at their first period.

    The realizations of a point are in consecutive rows.
    """
    paths = int(options.realizations)
    keys = np.repeat(keys_of(points, int(options.seed)), paths, axis=0)
    numbers = np.tile(np.arange(paths, dtype=float), len(points))
    return np.column_stack([keys, numbers, np.zeros(len(keys))])


@inline
def _words(low: float, high: float, path: float, period: float, count: float) -> Words:
    counter = word_of(count), word_of(period), word_of(path), np.uint64(0)
    return philox(counter, (word_of(low), word_of(high)))


@inline
def normal_number(low: float, high: float, path: float, period: float, step: float) -> float:
    """Standard normal variate of a step, from a stream's numbers and the step's index."""
    return normal(_words(low, high, path, period, step))


@inline
def signs(low: float, high: float, path: float, period: float, count: float) -> float:
    """Signs of SIGNS steps, as the bits of a number; `count` is the index of their group."""
    return np.uint64(_words(low, high, path, period, count)[0]).view(np.float64)


@inline
def first_sign(bits: float) -> tuple[float, float]:
    """First sign in `bits`, as 1 or -1, and the remaining bits."""
    held = np.float64(bits).view(np.uint64)
    negative = np.uint64(held << np.uint64(63))
    one = np.uint64(negative | np.uint64(0x3FF0000000000000)).view(np.float64)
    return one, np.uint64(held >> np.uint64(1)).view(np.float64)
