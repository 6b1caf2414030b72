"""The numbers of NUMERICS_VERSION: a change of any of them, in the last bit even, is a new version.

On the processor and the versions that the table was made with every bit counts, elsewhere nine
digits. Result variables younger than the table are no part of its hashes, which may come from a
machine that is not at hand: nine digits of theirs are compared. At a loose tolerance every change
of a method shows: in steps, weights, judgement or order of operations that matter. Both methods go
the way of a sweep.
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

VERSION = 17
MADE_ON = ("znver4", "0.68.1", "0.50.0")
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
    ((), LOOSE,
     (4304776.498179575, 0.0028121354885805917, 5), "fd6b7709f51ec412"),
    ((("angular_frequency", 38.0),), LOOSE,
     (2168513.9489145773, 0.0019155288501430147, 6), "77db1c551c23546b"),
    ((("rheological_index", 0.0),), LOOSE,
     (1758421.445564812, 0.004767431955384434, 6), "0265a087eaa36bd1"),
    ((("rheological_index", 2 / 3),), LOOSE,
     (298047.06230990024, 0.004767981760352885, 6), "9c5b7594c639f177"),
    ((("rheological_index", -0.5), ("temperature", 250.0)), LOOSE,
     (1853960.9843760256, 0.0025806199685423944, 4), "463d2331d5920ff8"),
    # The film freezes late.
    ((("temperature", 288.46451), ("viscosity_coefficient", 37087.004),
      ("spring_stiffness", 2187.6695), ("rheological_index", 0.0),
      ("angular_frequency", 29.403538)), LOOSE,
     (338282.9817311359, 0.00322355748365377, 25), "cbee4d2157d28918"),
    ((VISCOUS,), Options(dt=2e-5, **COARSE),
     (0.0, 0.000599244918620776, 4), "7bbdc2b68a7f12fc"),
    ((VISCOUS, ("rheological_index", -0.5)), Options(dt=2e-5, **COARSE),
     (0.0, 0.002563630974221664, 4), "279a630a214c59ed"),
    ((VISCOUS, ("drive_amplitude", -0.5e-6)), Options(dt=2e-5, **COARSE),
     (0.0, 0.000513072208716423, 4), "a8096cde1839bd4f"),
    ((VISCOUS, ("rheological_index", 0.0), ("viscosity_coefficient", 1e3)),
     Options(dt=2e-5, **COARSE),
     (0.0, 0.003382572951478407, 5), "dbbacd34e5252ecd"),
    ((VISCOUS, ("rheological_index", 2 / 3), ("viscosity_coefficient", 10.0)),
     Options(dt=2e-5, **COARSE),
     (0.0, 0.004277576626034176, 7), "971cfecc931fc0ea"),
    (SOLID, Options(dt=5e-9, **COARSE),
     (1451762.4705735636, 1.0107122299305827e-06, 6), "f6b7a1dbbb72b050"),
    ((*SOLID, ("rheological_index", 0.0)), Options(dt=5e-9, **COARSE),
     (431332.763939972, 1.1472177327739435e-06, 12), "fda25e32b4a3b37f"),
    ((*SOLID, ("rheological_index", -0.5)), Options(dt=5e-9, **COARSE),
     (1277325.2321558124, 1.0485902147058282e-06, 6), "bf5d666e6e57a5e3"),
    # Subharmonic, and found where the tolerance hides the limit.
    ((("temperature", 172.2), ("viscosity_coefficient", 14781.0), ("spring_stiffness", 1839.0),
      ("angular_frequency", 34.96)), Options(rtol=1e-4),
     (5864948.885053765, 0.0035892968479467415, 48), "e9ad859af905618f"),
]  # fmt: skip
# The table's rows of result variables that it is older than; to be emptied when it is renewed.
YOUNGER: dict[str, tuple[float, ...]] = {}
# Results on request are NaN here.
HASHED = [RESULT_COLUMNS.index(name) for name in RESULT_COLUMNS if name not in YOUNGER]
ADVICE = "the numbers have changed: raise NUMERICS_VERSION and renew this table"
COLUMNS = [
    RESULT_COLUMNS.index(name)
    for name in ("elastic_stress_amplitude", "friction_force_amplitude", "periods_integrated")
]

# Euler-Cromer for special fluids: kernels that nothing else in the suite compiles.
SPECIAL = (9, 10, 12)
ROWS = [i for i in range(len(TABLE)) if i not in SPECIAL] + marked("stress", SPECIAL)


@cache
def results_of(i: int) -> tuple[np.ndarray, np.ndarray]:
    """The result row (columns,) and the final row (columns,) of row `i` of the table."""
    changes, options, _, _ = TABLE[i]
    results, finals = compute_orbits(np.array(Parameters(**dict(changes))), options)
    return results[0], finals[0]


def computed(i: int) -> tuple[tuple[float, ...], str]:
    """What the table has of its row `i`."""
    result, final = results_of(i)
    digest = hashlib.sha256(result[HASHED].tobytes() + final.tobytes()).hexdigest()
    return tuple(result[COLUMNS].tolist()), digest[:16]


def this_machine() -> tuple[str, str, str]:
    return get_host_cpu_name(), numba.__version__, llvmlite.__version__


def test_the_version_is_the_one_of_these_numbers() -> None:
    assert NUMERICS_VERSION == VERSION


@pytest.mark.parametrize("i", ROWS)
def test_the_numbers_are_those_of_the_version(i: int) -> None:
    numbers = TABLE[i][2]
    assert computed(i)[0] == pytest.approx(numbers, rel=1e-9, abs=1e-12), (ADVICE, computed(i))


@pytest.mark.parametrize("name", YOUNGER)
@pytest.mark.parametrize("i", ROWS)
def test_the_numbers_of_younger_variables_are_those_of_the_version(i: int, name: str) -> None:
    found, p = results_of(i)[0], Parameters(**dict(TABLE[i][0]))
    value = found[RESULT_COLUMNS.index(name)]
    # Of a locked film it is a small difference of large numbers: the digits are those of F V.
    largest = found[RESULT_COLUMNS.index("friction_force_max")] * 4.0 * abs(p.drive_amplitude)
    assert value == pytest.approx(YOUNGER[name][i], rel=1e-9, abs=1e-9 * largest), (ADVICE, value)


@pytest.mark.parametrize("i", ROWS)
def test_every_bit_is_that_of_the_version(i: int) -> None:
    if this_machine() != MADE_ON:
        pytest.skip(f"the bits are those of {MADE_ON}, this is {this_machine()}")
    assert computed(i) == (TABLE[i][2], TABLE[i][3]), (ADVICE, computed(i))
