"""The keys of points: the published hash, what they depend on, and that no two points share one."""

from __future__ import annotations

import numpy as np
import pytest
from support.marks import one_then

from stickslip import Parameters
from stickslip import keys as module
from stickslip.keys import Keys, checksums, keys_of_lines, keys_of_points, secret_of
from stickslip.variables import PARAMETERS, RESULT_COLUMNS

# Test vectors of the reference implementation, of 128 bits, by the length of the message 00 01 ...;
# the secret is 00 01 ... 0f.
VECTORS = {
    0: "a3817f04ba25a8e66df67214c7550293",
    1: "da87c1d86b99af44347659119b22fc45",
    2: "8177228da4a45dc7fca38bdef60affe4",
    3: "9c70b60c5267a94e5f33b6b02985ed51",
    8: "3b62a9ba6258f5610f83e264f31497b4",
}

# For an artificial version and settings: these keys must never change.
SECRET = secret_of('{"integrator.rtol": 1e-05}', "golden")
GOLDEN = {
    Parameters(): "7afd928be9fdd249db7451379645d93f",
    Parameters(temperature=250.0, rheological_index=0.0): "4cd8a4afd79195a5352e4a8976e76ce1",
    Parameters(third_harmonic=0.25): "b0b6e875d011b11318f511c6117994b6",
}
GOLDEN_LINE = "74aa60c188bd392bcefb513a45acdedb"  # of the last point, along a line of all three
GOLDEN_SUM = 0x7FA676516A6CC648


def siphash(message: bytes, secret: bytes) -> str:
    """SipHash-2-4 with 128 bits of output, as its authors describe it; slow."""
    mask = (1 << 64) - 1

    def turned(word: int, bits: int) -> int:
        return (word << bits | word >> 64 - bits) & mask

    def rounds(count: int) -> None:
        for _ in range(count):
            v[0], v[2] = (v[0] + v[1]) & mask, (v[2] + v[3]) & mask
            v[1], v[3] = turned(v[1], 13) ^ v[0], turned(v[3], 16) ^ v[2]
            v[0] = turned(v[0], 32)
            v[2], v[0] = (v[2] + v[1]) & mask, (v[0] + v[3]) & mask
            v[1], v[3] = turned(v[1], 17) ^ v[2], turned(v[3], 21) ^ v[0]
            v[2] = turned(v[2], 32)

    keys = [int.from_bytes(secret[:8], "little"), int.from_bytes(secret[8:], "little")] * 2
    text = b"somepseudorandomlygeneratedbytes"
    v = [k ^ int.from_bytes(text[8 * n : 8 * n + 8], "big") for n, k in enumerate(keys)]
    v[1] ^= 0xEE
    padded = message + bytes(7 - len(message) % 8) + bytes([len(message) % 256])
    for first in range(0, len(padded), 8):
        word = int.from_bytes(padded[first : first + 8], "little")
        v[3] ^= word
        rounds(2)
        v[0] ^= word
    halves = []
    for place, constant in ((2, 0xEE), (1, 0xDD)):
        v[place] ^= constant
        rounds(4)
        halves.append((v[0] ^ v[1] ^ v[2] ^ v[3]).to_bytes(8, "little"))
    return b"".join(halves).hex()


def key(secret: Keys = SECRET, **values: float) -> str:
    return hexadecimal(keys_of_points(np.array([Parameters(**values)]), secret)[0])


def record(key: Keys, row: np.ndarray) -> np.ndarray:
    return np.concatenate([key, row.view(np.uint64), np.zeros(1, np.uint64)])[None]


def hexadecimal(key: Keys) -> str:
    return key.astype("<u8").tobytes().hex()


@pytest.mark.parametrize("length", VECTORS)
def test_the_slow_hash_is_the_published_one(length: int) -> None:
    assert siphash(bytes(range(length)), bytes(range(16))) == VECTORS[length]


def test_compiled_keys_and_checksums_are_this_hash() -> None:
    paper = [name for name, variable in PARAMETERS.items() if variable.in_paper]
    point = Parameters(temperature=250.0, fifth_harmonic=0.5)
    message = np.array([getattr(point, name) for name in paper]).tobytes()
    number = module._words_of("fifth_harmonic").tobytes()
    message += number + np.float64(0.5).tobytes()
    secret = SECRET.tobytes()
    assert key(temperature=250.0, fifth_harmonic=0.5) == siphash(message, secret)
    row = np.arange(len(RESULT_COLUMNS)) / 3.0
    (found,) = checksums(record(SECRET, row))
    assert found.tobytes().hex() == siphash(row.tobytes(), secret)[:16]


def test_keys_never_change() -> None:
    points = np.array([*GOLDEN])
    assert [*map(hexadecimal, keys_of_points(points, SECRET))] == [*GOLDEN.values()]
    along = keys_of_lines(points[None], SECRET)[0]
    assert hexadecimal(along[0]) == GOLDEN[Parameters()]
    assert hexadecimal(along[2]) == GOLDEN_LINE
    (found,) = checksums(record(keys_of_points(points[:1], SECRET)[0], np.arange(28.0)))
    assert found == GOLDEN_SUM


def test_a_new_parameter_at_its_default_changes_no_key() -> None:
    (point,) = module._bits(np.array([Parameters()]))
    older = slice(1, None)  # as if the first of them did not exist
    keys = np.empty((1, 1, 2), dtype=np.uint64)
    others = (module._OTHERS[older], module._NUMBERS[older], module._DEFAULTS[older])
    module._fill_keys(point[None, None], module._PAPER, *others, SECRET, keys)
    assert hexadecimal(keys[0, 0]) == key()


@pytest.mark.parametrize("name", PARAMETERS)
def test_every_parameter_enters_to_the_last_bit(name: str) -> None:
    before = getattr(Parameters(), name)
    for value in (np.nextafter(before, np.inf), before + 0.5):
        points = np.array([Parameters()])
        points[0, Parameters._fields.index(name)] = value
        assert hexadecimal(keys_of_points(points, SECRET)[0]) != key()


def test_a_zero_has_no_sign() -> None:
    for name in ("rheological_index", "third_harmonic"):
        assert key(**{name: -0.0}) == key(**{name: 0.0})


def test_settings_and_version_enter() -> None:
    secrets = [SECRET, secret_of("{}", "golden"), secret_of("{}", 1), secret_of("{}", 11)]
    assert len({key(secret) for secret in secrets}) == 4


def test_keys_along_a_line_depend_on_the_way() -> None:
    points = np.array([Parameters(temperature=t) for t in (200.0, 210.0, 220.0, 230.0)])
    whole = keys_of_lines(points[None], SECRET)[0]
    np.testing.assert_array_equal(keys_of_lines(points[None, :2], SECRET)[0], whole[:2])
    shorter = keys_of_lines(points[None, 1:], SECRET)[0]
    assert not (shorter[:, None] == whole[None]).all(axis=-1).any()
    both = keys_of_lines(np.stack([points, points[::-1]]), SECRET)
    np.testing.assert_array_equal(both[0], whole)


@pytest.mark.parametrize("count", one_then("stress", [100_000, 10_000_000]))
def test_near_points_have_different_keys(count: int) -> None:
    point = np.array([Parameters()])
    words = np.empty(count, dtype=np.uint64)
    for first in range(0, count, 100_000):
        points = np.repeat(point, 100_000, axis=0)
        points[:, 0] = (200.0 + np.spacing(200.0) * np.arange(first, first + 100_000)).ravel()
        words[first : first + 100_000] = keys_of_points(points, SECRET)[:, 0]
    assert len(np.unique(words)) == count  # half of a key is enough to distinguish them
    ones = np.unpackbits(words[:100_000].view(np.uint8)).reshape(100_000, 64).mean(axis=0)
    assert np.abs(ones - 0.5).max() < 0.01
