"""Elementary functions in plain arithmetic, without library calls, so that loops vectorise.

They operate on the bits of a double where a library would branch, use only integer operations of
AVX2, and propagate NaN. Errors are in units of the last place (ulp, 1.1e-16).
"""

from __future__ import annotations

import math

import numpy as np

from stickslip.compiled.decorators import inline

# Adding this to a number below 2^51 leaves the nearest integer in the lowest bits of the sum. That
# depends on the order of summation, so these functions must never be compiled with `reassoc`.
_ROUND = 6755399441055744.0  # 1.5 * 2^52

_U = np.uint64

# The high word of the bits of 1.0, times 4/3, minus a correction that balances the linear guess.
_CUBE_SEED = _U(0x553EF0FF)
_LOW_WORD, _ONE_THIRD = _U(0xFFFFFFFF), _U(0xAAAAAAAB)  # (n * 0xAAAAAAAB) >> 33 is n/3

# ln 2 and pi/2, each in two parts; the first has so few digits that its small multiples are exact.
_LN2 = 6.93147180369123816490e-01, 1.90821492927058770002e-10
_HALF_PI = 1.57079632673412561417e00, 6.07710050650619224932e-11

_LARGEST_EXPONENT = 345.0
"""Up to here exp(x), exp(-x) and their squares are normal numbers."""


@inline
def inverse_cube_root(x: float) -> float:
    """x^(-1/3) for normal `x` > 0, to 2 ulp; large and finite for 0.

    The exponent bits give a guess to 4 %. Two steps of a fourth-order iteration without a division
    make it exact to rounding.
    """
    bits = np.float64(x).view(np.uint64)
    third = (((bits >> _U(32)) & _LOW_WORD) * _ONE_THIRD) >> _U(33)
    r = np.uint64((_CUBE_SEED - third) << _U(32)).view(np.float64)
    for _ in range(2):
        miss = 1.0 - (x * r) * (r * r)
        r += r * miss * (1.0 / 3.0 + miss * (2.0 / 9.0 + miss * (14.0 / 81.0)))
    return r


@inline
def cube_root(x: float) -> float:
    """Cube root of `x` >= 0, to 5 ulp for 0 and normal numbers."""
    r = inverse_cube_root(x)
    return x * (r * r)


@inline
def exponentials(x: float) -> tuple[float, float]:
    """exp(x) and exp(-x), to 4 ulp; `x` is cut off at +-345.

    The even and the odd part of the series serve both, so the second result is nearly free.
    """
    x = max(x, -_LARGEST_EXPONENT)
    x = min(x, _LARGEST_EXPONENT)
    shifted = x * (1.0 / math.log(2.0)) + _ROUND
    power = shifted - _ROUND
    r = (x - power * _LN2[0]) - power * _LN2[1]
    s = r * r
    even = 1.0 + s * (1 / 2 + s * (1 / 24 + s * (1 / 720 + s * (1 / 40320 + s * _even_tail(s)))))
    odd = r * (
        1.0 + s * (1 / 6 + s * (1 / 120 + s * (1 / 5040 + s * (1 / 362880 + s * _odd_tail(s)))))
    )
    exponent = np.int64(np.float64(shifted).view(np.int64) << 52)
    return _scaled(even + odd, exponent), _scaled(even - odd, -exponent)


@inline
def _even_tail(s: float) -> float:
    return 1 / 3628800 + s * (1 / 479001600)


@inline
def _odd_tail(s: float) -> float:
    return 1 / 39916800 + s * (1 / 6227020800)


@inline
def _scaled(x: float, exponent: int) -> float:
    """x times a power of two, which is given by the bits of its exponent field."""
    return np.int64(np.float64(x).view(np.int64) + exponent).view(np.float64)


@inline
def sine_and_cosine(x: float) -> tuple[float, float]:
    """sin(x) and cos(x), to an absolute 2e-16 for |x| < 100, growing to 1e-15 at 1e5."""
    shifted = x * (2.0 / math.pi) + _ROUND
    quarters = shifted - _ROUND
    r = (x - quarters * _HALF_PI[0]) - quarters * _HALF_PI[1]
    s = r * r
    sine = r + r * s * (-1 / 6 + s * (1 / 120 + s * (-1 / 5040 + s * _sine_tail(s))))
    cosine = 1.0 + s * (-1 / 2 + s * (1 / 24 + s * (-1 / 720 + s * _cosine_tail(s))))
    bits = np.float64(shifted).view(np.int64)
    swapped = (bits & 1) == 1
    a, b = (cosine, sine) if swapped else (sine, cosine)
    return _negated(a, bits), _negated(b, np.int64(bits + 1))


@inline
def _sine_tail(s: float) -> float:
    return 1 / 362880 + s * (-1 / 39916800 + s * (1 / 6227020800 - s * (1 / 1307674368000)))


@inline
def _cosine_tail(s: float) -> float:
    tail = 1 / 479001600 + s * (-1 / 87178291200 + s * (1 / 20922789888000))
    return 1 / 40320 + s * (-1 / 3628800 + s * tail)


@inline
def _negated(x: float, quarter: int) -> float:
    """x, or -x if the quarter belongs to the second half of a turn."""
    sign = np.int64((quarter & 2) << 62)
    return np.int64(np.float64(x).view(np.int64) ^ sign).view(np.float64)


@inline
def logarithm(x: float) -> float:
    """ln(x) for normal `x` > 0, to an absolute 2e-16 or 2 ulp; about -709 for 0."""
    bits = np.float64(x).view(np.uint64)
    # The mantissa is reduced to [1/sqrt 2, sqrt 2), so that the logarithm of 1 is exact.
    offset = _U(0x3FE6A09E667F3BCD)
    steps = np.uint64(np.uint64(bits - offset) >> _U(52))
    mantissa = np.uint64(bits - np.uint64(steps << _U(52))).view(np.float64)
    signed = np.uint64(((steps + _U(1024)) & _U(0xFFF)) | _U(0x4330000000000000)).view(np.float64)
    power = signed - (4503599627370496.0 + 1024.0)
    s = (mantissa - 1.0) / (mantissa + 1.0)
    q = s * s
    tail = 1 / 13 + q * (1 / 15 + q * (1 / 17 + q * (1 / 19 + q * (1 / 21))))
    series = 1 / 3 + q * (1 / 5 + q * (1 / 7 + q * (1 / 9 + q * (1 / 11 + q * tail))))
    result = power * _LN2[0] + (power * _LN2[1] + 2.0 * (s + s * q * series))
    return result if x == x else x


@inline
def power(x: float, exponent: float) -> float:
    """x^exponent for `x` >= 0 and exponent > 0, to 4e-16 (1 + |ln(result)|).

    Nonzero results below 1e-149 come out as about 1e-149, which is 0 for any physical purpose.
    """
    result, _ = exponentials(exponent * logarithm(x))
    return result if x > 0.0 else x  # 0 and NaN


# Twice the bits of 1.0, minus a correction that balances the error of the linear guess.
_RECIPROCAL_SEED = _U(0x7FDE623822FC16E6)


@inline
def reciprocal(x: float) -> float:
    """1/x for `x` between 1e-300 and 1e300, to 1 ulp, for loops in which a division is too slow.

    The exponent bits give a guess to 5 %. Two steps of a fourth-order iteration do the rest.
    """
    r = np.uint64(_RECIPROCAL_SEED - np.float64(x).view(np.uint64)).view(np.float64)
    for _ in range(2):
        miss = 1.0 - x * r
        closer = r + r * miss
        r = closer + closer * (miss * miss)
    return r
