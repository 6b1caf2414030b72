"""The numbers of NUMERICS_VERSION: a change of any of them, in the last bit even, is a new version.

On the processor and the versions that the table was made with every bit counts, elsewhere nine
digits. At a loose tolerance every change of a method shows: in steps, weights, judgement or order
of operations that matter. Both methods go the way of a sweep.
"""

from __future__ import annotations

import hashlib
from functools import cache

import llvmlite
import numba
import numpy as np
import pytest
from llvmlite.binding import get_host_cpu_name

from stickslip import Options, Parameters
from stickslip.kernels.version import NUMERICS_VERSION
from stickslip.orbit import compute_orbits
from stickslip.variables import RESULT_COLUMNS

VERSION = 0
MADE_ON = ()
"""Processor, numba and llvmlite of the table."""

Changes = tuple[tuple[str, float], ...]

LOOSE = Options(rtol=1e-4, stationary_rtol=1e-4)
COARSE = {"method": "euler-cromer", "stationary_rtol": 1e-4}
VISCOUS = ("elastic_coefficient", 0.0)
SOLID = (("temperature", 250.0), ("viscosity_coefficient", 1e4), ("kinetic_coefficient", 1.0))

# Changes to Fig. 3, options; stress amplitude [Pa], force amplitude [N], periods integrated; and
# the beginning of the SHA-256 of all that comes back.
TABLE: list[tuple[Changes, Options, tuple[float, float, int], str]] = [
    ((), LOOSE, (), ""),
    ((("angular_frequency", 38.0),), LOOSE, (), ""),
    ((("rheological_index", 0.0),), LOOSE, (), ""),
    ((("rheological_index", 2 / 3),), LOOSE, (), ""),
    ((("rheological_index", -0.5), ("temperature", 250.0)), LOOSE, (), ""),
    ((VISCOUS,), Options(dt=2e-5, **COARSE), (), ""),
    ((VISCOUS, ("rheological_index", -0.5)), Options(dt=2e-5, **COARSE), (), ""),
    ((VISCOUS, ("drive_amplitude", -0.5e-6)), Options(dt=2e-5, **COARSE), (), ""),
    ((*SOLID, ("rheological_index", 0.0)), Options(dt=2e-6, **COARSE), (), ""),
    ((("temperature", 300.0), ("rheological_index", 2 / 3), ("viscosity_coefficient", 1e3)),
     Options(dt=5e-7, **COARSE), (), ""),
]  # fmt: skip
ADVICE = "the numbers have changed: raise NUMERICS_VERSION and renew this table"
COLUMNS = [
    RESULT_COLUMNS.index(name)
    for name in ("elastic_stress_amplitude", "friction_force_amplitude", "periods_integrated")
]


@cache
def computed(i: int) -> tuple[tuple[float, ...], str]:
    """What the table has of its row `i`."""
    changes, options, _, _ = TABLE[i]
    results, finals = compute_orbits(np.array(Parameters(**dict(changes))), options)
    digest = hashlib.sha256(results.tobytes() + finals.tobytes()).hexdigest()
    return tuple(results[0, COLUMNS].tolist()), digest[:16]


def this_machine() -> tuple[str, str, str]:
    return get_host_cpu_name(), numba.__version__, llvmlite.__version__


def test_the_version_is_the_one_of_these_numbers() -> None:
    assert NUMERICS_VERSION == VERSION


@pytest.mark.parametrize("i", range(len(TABLE)))
def test_the_numbers_are_those_of_the_version(i: int) -> None:
    numbers = TABLE[i][2]
    assert computed(i)[0] == pytest.approx(numbers, rel=1e-9, abs=1e-20), (ADVICE, computed(i))


@pytest.mark.parametrize("i", range(len(TABLE)))
def test_every_bit_is_that_of_the_version(i: int) -> None:
    if this_machine() != MADE_ON:
        pytest.skip(f"the bits are those of {MADE_ON}, this is {this_machine()}")
    assert computed(i) == (TABLE[i][2], TABLE[i][3]), (ADVICE, computed(i))
