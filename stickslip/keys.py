"""Keys of points: a 128-bit hash of everything that determines the numbers of a point.

The place of the point in a grid does not enter. The hash is SipHash-2-4 with 128 bits of output
(Aumasson and Bernstein, "SipHash: a fast short-input PRF", INDOCRYPT 2012; their reference
implementation has the longer output). Its secret is a digest of the settings and the numerics
version. Its message has the parameters of the paper, then all others that are not at their
defaults, sorted by name, each after a number that stands for the name. So a new parameter at its
default changes no key. Along a followed line the message begins with the key of the previous point.

The checksum of a row is the same hash of its numbers, with the key of its point as the secret.
"""

from __future__ import annotations

import hashlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.compiled.decorators import inline, kernel
from stickslip.kernels.version import NUMERICS_VERSION
from stickslip.parameters import Parameters
from stickslip.variables import PARAMETERS

Keys = NDArray[np.uint64]
"""Keys (..., 2) of points: two words of 64 bits each."""

_WORD = 8  # bytes

# Constants of the reference implementation: the state before the secret is mixed in, and the words
# that distinguish an output of 128 bits from one of 64.
_START = tuple(
    map(np.uint64, (0x736F6D6570736575, 0x646F72616E646F6D, 0x6C7967656E657261, 0x7465646279746573))
)
_LONG, _LONG_SECOND = np.uint64(0xEE), np.uint64(0xDD)
_LENGTH_BITS, _BITS = np.uint64(56), np.uint64(64)

_NAMES = Parameters._fields
_NEWER = sorted(name for name in _NAMES if not PARAMETERS[name].in_paper)

State = tuple[Any, Any, Any, Any]


def secret_of(settings: str, version: object = NUMERICS_VERSION) -> Keys:
    """Return the secret (2,) of keys under these settings, given as a canonical text."""
    return _words_of(f"{version}\0{settings}", 2)


def keys_of_points(points: NDArray[np.float64], secret: Keys) -> Keys:
    """Return the keys (n, 2) of independent points (n, parameters)."""
    return keys_of_lines(np.asarray(points)[:, None], secret)[:, 0]


def keys_of_lines(lines: NDArray[np.float64], secret: Keys) -> Keys:
    """Return the keys (lines, n, 2) of points (lines, n, parameters) along followed lines."""
    keys = np.empty((*lines.shape[:2], 2), dtype=np.uint64)
    # -0.0 is the same value as 0.0.
    _fill_keys(_bits(lines + 0.0), _PAPER, _OTHERS, _NUMBERS, _DEFAULTS, secret, keys)
    return keys


def checksums(records: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """Return the checksums (n,) of records (n, 2 + columns + 1).

    A record is a key, the numbers of a row as words, and a word for the checksum.
    """
    sums = np.empty(len(records), dtype=np.uint64)
    _fill_sums(records, sums)
    return sums


@kernel
def _fill_keys(
    lines: Any, paper: Any, others: Any, numbers: Any, defaults: Any, secret: Any, keys: Any
) -> None:
    """Fill the keys (lines, n, 2) of points (lines, n, parameters), given as words."""
    for line in range(lines.shape[0]):
        for point in range(lines.shape[1]):
            words, count = lines[line, point], 0
            state = _begun(secret[0], secret[1])
            if point > 0:
                state = _taken_in(state, keys[line, point - 1, 0])
                state = _taken_in(state, keys[line, point - 1, 1])
                count += 2
            for column in paper:
                state = _taken_in(state, words[column])
                count += 1
            for other, column in enumerate(others):
                if words[column] != defaults[other]:
                    state = _taken_in(_taken_in(state, numbers[other]), words[column])
                    count += 2
            keys[line, point, 0], keys[line, point, 1] = _ended(state, _WORD * count)


@kernel
def _fill_sums(records: Any, sums: Any) -> None:
    """Fill the checksums (n,) of records (n, 2 + columns + 1)."""
    end = records.shape[1] - 1
    for number in range(records.shape[0]):
        words = records[number]
        state = _begun(words[0], words[1])
        for column in range(2, end):
            state = _taken_in(state, words[column])
        sums[number] = _ended(state, _WORD * (end - 2))[0]


@inline
def _begun(low: Any, high: Any) -> State:
    """Return the state of the hash for a secret, before any message."""
    s0, s1, s2, s3 = _START
    return low ^ s0, high ^ s1 ^ _LONG, low ^ s2, high ^ s3


@inline
def _taken_in(state: State, word: Any) -> State:
    """Return the state after one more word of the message."""
    v0, v1, v2, v3 = state
    v0, v1, v2, v3 = _round(_round((v0, v1, v2, v3 ^ word)))
    return v0 ^ word, v1, v2, v3


@inline
def _ended(state: State, length: int) -> tuple[Any, Any]:
    """Return both words of the hash of a message of whole words, `length` bytes in all."""
    v0, v1, v2, v3 = _taken_in(state, np.uint64(length) << _LENGTH_BITS)
    v0, v1, v2, v3 = _round(_round(_round(_round((v0, v1, v2 ^ _LONG, v3)))))
    first = v0 ^ v1 ^ v2 ^ v3
    v0, v1, v2, v3 = _round(_round(_round(_round((v0, v1 ^ _LONG_SECOND, v2, v3)))))
    return first, v0 ^ v1 ^ v2 ^ v3


@inline
def _round(state: State) -> State:
    v0, v1, v2, v3 = state
    v0 += v1
    v1 = _turned(v1, np.uint64(13)) ^ v0
    v0 = _turned(v0, np.uint64(32))
    v2 += v3
    v3 = _turned(v3, np.uint64(16)) ^ v2
    v0 += v3
    v3 = _turned(v3, np.uint64(21)) ^ v0
    v2 += v1
    v1 = _turned(v1, np.uint64(17)) ^ v2
    v2 = _turned(v2, np.uint64(32))
    return v0, v1, v2, v3


@inline
def _turned(word: Any, bits: Any) -> Any:
    """Return a word rotated to the left by some bits."""
    return (word << bits) | (word >> (_BITS - bits))


def _bits(values: NDArray[np.float64]) -> NDArray[np.uint64]:
    """Return numbers as words."""
    return np.ascontiguousarray(values, dtype=np.float64).view(np.uint64)


def _words_of(text: str, count: int = 1) -> NDArray[np.uint64]:
    """Return a hash (count,) of a string as words."""
    digest = hashlib.blake2b(text.encode(), digest_size=_WORD * count).digest()
    return np.frombuffer(digest, "<u8").astype(np.uint64)


# The columns of points, in the order in which they enter the message.
_PAPER = np.array([column for column, name in enumerate(_NAMES) if PARAMETERS[name].in_paper])
_OTHERS = np.array([_NAMES.index(name) for name in _NEWER])
_NUMBERS = np.concatenate([_words_of(name) for name in _NEWER])
_DEFAULTS = _bits(np.array([PARAMETERS[name].default for name in _NEWER]))
