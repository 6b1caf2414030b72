"""Random numbers that are a function of a counter and a key."""

import math

import numpy as np
import pytest

from stickslip.compiled.decorators import jit
from stickslip.numerics.philox import normal, philox, word_of

_COUNT = 200_000


@jit
def _words(counter: np.ndarray, key: np.ndarray, out: np.ndarray) -> None:
    c0, c1, c2, c3 = counter[0], counter[1], counter[2], counter[3]
    words = philox((c0, c1, c2, c3), (key[0], key[1]))
    for i in range(4):
        out[i] = words[i]


@jit
def _normals(out: np.ndarray, key: float) -> None:
    nought = word_of(0.0)
    for i in range(out.shape[0]):
        out[i] = normal(philox((word_of(float(i)), nought, nought, nought), (word_of(key), nought)))


def words(counter: list[int], key: list[int]) -> list[int]:
    out = np.empty(4, np.uint64)
    _words.alone(np.array(counter, np.uint64), np.array(key, np.uint64), out)
    return [int(word) for word in out]


def normals(key: float = 1.0) -> np.ndarray:
    out = np.empty(_COUNT)
    _normals.alone(out, key)
    return out


# The known answers that come with Random123, the authors' own library.
@pytest.mark.parametrize(
    ("counter", "key", "expected"),
    [
        ([0] * 4, [0] * 2, [0x6627E8D5, 0xE169C58D, 0xBC57AC4C, 0x9B00DBD8]),
        ([0xFFFFFFFF] * 4, [0xFFFFFFFF] * 2, [0x408F276D, 0x41C83B0E, 0xA20BC7C6, 0x6D5451FD]),
        (
            [0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344],
            [0xA4093822, 0x299F31D0],
            [0xD16CFE09, 0x94FDCCEB, 0x5001E420, 0x24126EA1],
        ),
    ],
)
def test_the_words_agree_with_the_reference_implementation(
    counter: list[int], key: list[int], expected: list[int]
) -> None:
    assert words(counter, key) == expected


@pytest.mark.parametrize("number", [0, 1, 2**31, 2**32 - 1])
def test_a_whole_number_is_a_word(number: int) -> None:
    assert int(word_of(float(number))) == number


def test_normal_numbers_are_distributed_as_they_should() -> None:
    ordered = np.sort(normals(2.0))
    expected = 0.5 * (1.0 + np.array([math.erf(x / math.sqrt(2.0)) for x in ordered]))
    steps = np.arange(_COUNT) / _COUNT
    assert np.abs(expected - steps).max() < 1.95 / math.sqrt(_COUNT)  # Kolmogorov, one in 1000


def test_numbers_of_neighbouring_counters_and_keys_are_uncorrelated() -> None:
    one, other = normals(1.0), normals(2.0)
    allowed = 4.0 / math.sqrt(_COUNT)
    assert abs(np.mean(one[1:] * one[:-1])) < allowed
    assert abs(np.mean(one * other)) < allowed
