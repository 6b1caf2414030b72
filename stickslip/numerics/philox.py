"""Counter-based random numbers: Philox4x32-10.

Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy as 1, 2, 3" (SC 2011). A counter and
a key determine four words of 32 bits. The generator has no state, so that a number does not depend
on the lane, block or worker that uses it, nor on previous numbers. Words occupy 64 bits, and the
arithmetic, products of 32-bit halves without branches or calls, vectorises.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from stickslip.compiled.decorators import inline
from stickslip.compiled.elementary import logarithm, sine_and_cosine

_U = np.uint64
_WORD, _HALF = _U(0xFFFFFFFF), _U(32)
_MULTIPLIERS = _U(0xD2511F53), _U(0xCD9E8D57)
_WEYL = _U(0x9E3779B9), _U(0xBB67AE85)  # added to the key from round to round
_ROUNDS = 10

# The bits of 1.0, whose mantissa takes a fraction.
_ONE = _U(0x3FF0000000000000)

# Words of 32 bits in unsigned integers of 64; compiled integers have the type Any.
Words = tuple[Any, Any, Any, Any]


@inline
def word_of(number: float) -> Any:
    """Return a whole number from 0 to 2^32 - 1 as a word."""
    return np.float64(number + 4503599627370496.0).view(np.uint64) & _WORD


@inline
def philox(counter: Words, key: tuple[Any, Any]) -> Words:
    """Return four random words for a counter of four words and a key of two."""
    c0, c1, c2, c3 = counter
    k0, k1 = key
    for _ in range(_ROUNDS):
        first, second = c0 * _MULTIPLIERS[0], c2 * _MULTIPLIERS[1]
        c0, c2 = (second >> _HALF) ^ c1 ^ k0, (first >> _HALF) ^ c3 ^ k1
        c1, c3 = second & _WORD, first & _WORD
        k0, k1 = (k0 + _WEYL[0]) & _WORD, (k1 + _WEYL[1]) & _WORD
    return c0, c1, c2, c3


@inline
def _fraction(high: Any, low: Any) -> float:
    """Return a uniform number in [0, 1), with 52 bits, from two words."""
    mantissa = (high << _U(20)) | (low >> _U(12))
    return np.uint64(mantissa | _ONE).view(np.float64) - 1.0


@inline
def normal(words: Words) -> float:
    """Return a standard normal number from four random words, by the Box-Muller transformation."""
    radius = math.sqrt(-2.0 * logarithm(1.0 - _fraction(words[0], words[1])))
    _, cosine = sine_and_cosine(2.0 * math.pi * _fraction(words[2], words[3]))
    return radius * cosine
