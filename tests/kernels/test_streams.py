"""The random numbers of a path depend on its point, its seed and its place, and on nothing else."""

from typing import Any

import numpy as np
import pytest

from stickslip import Parameters
from stickslip.compiled.decorators import jit
from stickslip.kernels.streams import SIGNS, first_sign, keys_of, signs, streams_of
from stickslip.options import Options
from stickslip.variables import PARAMETERS


def key(seed: int = 1, **changes: float) -> tuple[float, ...]:
    return tuple(keys_of(np.array([Parameters(**changes)]), seed)[0].tolist())


def test_a_key_is_two_words_and_stays_the_same() -> None:
    # A change of these numbers changes every stochastic result.
    assert key() == (3775397130.0, 4136475804.0)
    assert all(0 <= word < 2**32 and word == int(word) for word in key())


def test_another_seed_is_another_key() -> None:
    assert len({key(seed) for seed in (0, 1, 2, 2**64 - 1)}) == 4


@pytest.mark.parametrize("name", PARAMETERS)
def test_every_parameter_makes_another_key(name: str) -> None:
    default = getattr(Parameters(), name)
    other = {
        "rheological_index": 0.25, "initial_order_parameter": 0.5,
    }.get(name, 2.0 * default + (default == 0.0))  # fmt: skip
    changes = {name: other}
    if name == "quintic_coefficient":
        changes |= {"sextic_coefficient": 5.0}
        assert key(**changes) != key(sextic_coefficient=5.0)
    assert key(**changes) != key()


def test_a_mirror_image_has_the_key_of_its_original() -> None:
    twin = {"drive_amplitude": 8e-7, "initial_displacement": 1e-7, "initial_velocity": -2e-6}
    assert key(**twin) == key(**{name: -value for name, value in twin.items()})
    assert key(drive_amplitude=-8e-7) == key(drive_amplitude=8e-7)  # x_0 = v_0 = 0 either way
    assert key(**twin) != key(**twin | {"drive_amplitude": -8e-7})


def test_the_number_of_paths_does_not_change_their_streams() -> None:
    points = np.array([Parameters(), Parameters(temperature=250.0)])
    few, many = (streams_of(points, Options(noise="stochastic", realizations=n)) for n in (2, 5))
    np.testing.assert_array_equal(few.reshape(2, 2, -1), many.reshape(2, 5, -1)[:, :2])
    assert len(np.unique(many, axis=0)) == 10


@jit
def _drawn(out: np.ndarray, word: float) -> None:
    bits = signs(1.0, 2.0, 3.0, 4.0, word)
    for i in range(out.shape[0]):
        out[i], bits = first_sign(bits)


def drawn(count: int, words: int) -> np.ndarray[Any, Any]:
    out = np.empty((words, count))
    for word in range(words):
        _drawn.alone(out[word], float(word))
    return out


def test_signs_are_balanced_and_independent() -> None:
    found = drawn(SIGNS, 4000)
    allowed = 4.0 / np.sqrt(found.size)
    assert set(np.unique(found)) == {-1.0, 1.0}
    assert abs(found.mean()) < allowed
    assert np.abs(found.mean(axis=0)).max() < 4.5 / np.sqrt(len(found))
    assert abs(np.mean(found.ravel()[1:] * found.ravel()[:-1])) < allowed
