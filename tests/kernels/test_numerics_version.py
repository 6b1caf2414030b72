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
from support.marks import marked

from stickslip import Options, Parameters
from stickslip.kernels.version import NUMERICS_VERSION
from stickslip.orbit import compute_orbits
from stickslip.variables import RESULT_COLUMNS

VERSION = 15
MADE_ON = ("emeraldrapids", "0.68.1", "0.50.0")
"""Processor, numba and llvmlite of the table."""

Changes = tuple[tuple[str, float], ...]

LOOSE = Options(rtol=1e-4, stationary_rtol=1e-4)
COARSE = {"method": "euler-cromer", "stationary_rtol": 1e-4}
VISCOUS = ("elastic_coefficient", 0.0)
SOLID = (  # a light block under a small film: few and short periods to an orbit
    ("angular_frequency", 2e4),
    ("drive_amplitude", 1e-11),
    ("contact_area", 6e-13),
    ("block_mass", 1e-5),
    ("spring_stiffness", 6e4),
    ("initial_order_parameter", 0.6),
)

# Changes to Fig. 3, options; stress amplitude [Pa], force amplitude [N], periods integrated; and
# the beginning of the SHA-256 of all that comes back.
TABLE: list[tuple[Changes, Options, tuple[float, float, int], str]] = [
    ((), LOOSE, (4304776.7626851145, 0.0028121348892043395, 5), "a8f9c1d6bdb23c48"),
    (
        (("angular_frequency", 38.0),),
        LOOSE,
        (2168518.2746554543, 0.0019155292186684735, 6),
        "352711eb312cc7da",
    ),
    (
        (("rheological_index", 0.0),),
        LOOSE,
        (1758421.4664479666, 0.004767432008341979, 6),
        "f9e42e98769bdbef",
    ),
    (
        (("rheological_index", 2 / 3),),
        LOOSE,
        (298047.0613451167, 0.004767981734963769, 6),
        "1a92191c32994acd",
    ),
    (
        (("rheological_index", -0.5), ("temperature", 250.0)),
        LOOSE,
        (1853961.0631200199, 0.0025806199241216374, 4),
        "9b5d2dd590d1c271",
    ),
    (
        (
            ("temperature", 288.46451),  # the film freezes late
            ("viscosity_coefficient", 37087.004),
            ("spring_stiffness", 2187.6695),
            ("rheological_index", 0.0),
            ("angular_frequency", 29.403538),
        ),
        LOOSE,
        (338283.831865529, 0.003223557487533542, 26),
        "e27113b7f249935e",
    ),
    ((VISCOUS,), Options(dt=2e-5, **COARSE), (0.0, 0.0005992449187231228, 4), "0174e915d7a5512d"),
    (
        (VISCOUS, ("rheological_index", -0.5)),
        Options(dt=2e-5, **COARSE),
        (0.0, 0.0025636309746984373, 4),
        "d689ded6a5a94bef",
    ),
    (
        (VISCOUS, ("drive_amplitude", -0.5e-6)),
        Options(dt=2e-5, **COARSE),
        (0.0, 0.0005130722087228642, 4),
        "f6ab5135f3a1f126",
    ),
    (
        (VISCOUS, ("rheological_index", 0.0), ("viscosity_coefficient", 1e3)),
        Options(dt=2e-5, **COARSE),
        (0.0, 0.003382572951478408, 5),
        "ac89e9ea4e85ad19",
    ),
    (
        (VISCOUS, ("rheological_index", 2 / 3), ("viscosity_coefficient", 10.0)),
        Options(dt=2e-5, **COARSE),
        (0.0, 0.004277576626034167, 7),
        "ba45da7240335e35",
    ),
    (
        SOLID,
        Options(dt=5e-9, **COARSE),
        (1451762.4705775229, 1.010712229933089e-06, 6),
        "7a89aa9d0c09df68",
    ),
    (
        (*SOLID, ("rheological_index", 0.0)),
        Options(dt=5e-9, **COARSE),
        (431332.7639399719, 1.1472177327739448e-06, 12),
        "307c1d507c2f3f78",
    ),
    (
        (*SOLID, ("rheological_index", -0.5)),
        Options(dt=5e-9, **COARSE),
        (1277325.2321558087, 1.0485902147058254e-06, 6),
        "7795ca2e3c8a400c",
    ),
    (
        (
            ("temperature", 172.2),  # subharmonic, and found where the tolerance hides the limit
            ("viscosity_coefficient", 14781.0),
            ("spring_stiffness", 1839.0),
            ("angular_frequency", 34.96),
        ),
        Options(rtol=1e-4),
        (5864948.775263247, 0.0035892968778039724, 57),
        "e06dfd4019a6180a",
    ),
]
ADVICE = "the numbers have changed: raise NUMERICS_VERSION and renew this table"
COLUMNS = [
    RESULT_COLUMNS.index(name)
    for name in ("elastic_stress_amplitude", "friction_force_amplitude", "periods_integrated")
]

# Euler-Cromer for special fluids: kernels that nothing else in the suite compiles.
SPECIAL = (9, 10, 12)
ROWS = [i for i in range(len(TABLE)) if i not in SPECIAL] + marked("stress", SPECIAL)


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


@pytest.mark.parametrize("i", ROWS)
def test_the_numbers_are_those_of_the_version(i: int) -> None:
    numbers = TABLE[i][2]
    assert computed(i)[0] == pytest.approx(numbers, rel=1e-9, abs=1e-12), (ADVICE, computed(i))


@pytest.mark.parametrize("i", ROWS)
def test_every_bit_is_that_of_the_version(i: int) -> None:
    if this_machine() != MADE_ON:
        pytest.skip(f"the bits are those of {MADE_ON}, this is {this_machine()}")
    assert computed(i) == (TABLE[i][2], TABLE[i][3]), (ADVICE, computed(i))
