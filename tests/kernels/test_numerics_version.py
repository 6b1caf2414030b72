"""The numbers of NUMERICS_VERSION. Any change in them, even in the last bit, needs a new version.

With the table's processor and versions every bit counts; otherwise, nine digits do. Result
variables newer than the table are not part of its hashes, as the machine of the table may not be
at hand; nine of their digits are compared. At a loose tolerance every relevant change of a method
shows, in steps, weights, judgement or order of operations. Both methods compute as in a sweep.
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

VERSION = 21
MADE_ON = ("znver4", "0.68.1", "0.50.0")
"""Processor, numba and llvmlite of the table."""

Changes = tuple[tuple[str, float], ...]

LOOSE = Options(rtol=1e-4, stationary_rtol=1e-4)
COARSE = {"method": "euler-cromer", "stationary_rtol": 1e-4}
VISCOUS = ("elastic_coefficient", 0.0)
SOLID = (  # a light block under a small film, which needs few and short periods to its orbit
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
     (1853960.9843760256, 0.0025806199685423944, 4), "0f37d6de7a3ca72d"),
    # The film freezes late.
    ((("temperature", 288.46451), ("viscosity_coefficient", 37087.004),
      ("spring_stiffness", 2187.6695), ("rheological_index", 0.0),
      ("angular_frequency", 29.403538)), LOOSE,
     (338282.9817311359, 0.00322355748365377, 25), "cbee4d2157d28918"),
    ((VISCOUS,), Options(dt=2e-5, **COARSE),
     (0.0, 0.000599244918620776, 4), "7bbdc2b68a7f12fc"),
    ((VISCOUS, ("rheological_index", -0.5)), Options(dt=2e-5, **COARSE),
     (0.0, 0.002563630974221664, 4), "11919429ed728cf1"),
    ((VISCOUS, ("drive_amplitude", -0.5e-6)), Options(dt=2e-5, **COARSE),
     (0.0, 0.000513072208716423, 4), "b474c3e490faadc9"),
    ((VISCOUS, ("rheological_index", 0.0), ("viscosity_coefficient", 1e3)),
     Options(dt=2e-5, **COARSE),
     (0.0, 0.003382572951478407, 5), "0b1190e75a5c93e2"),
    ((VISCOUS, ("rheological_index", 2 / 3), ("viscosity_coefficient", 10.0)),
     Options(dt=2e-5, **COARSE),
     (0.0, 0.004277576626034176, 7), "971cfecc931fc0ea"),
    (SOLID, Options(dt=5e-9, **COARSE),
     (1451762.4705735636, 1.0107122299305827e-06, 6), "03c17df13989ea50"),
    ((*SOLID, ("rheological_index", 0.0)), Options(dt=5e-9, **COARSE),
     (431332.763939972, 1.1472177327739435e-06, 12), "fda25e32b4a3b37f"),
    ((*SOLID, ("rheological_index", -0.5)), Options(dt=5e-9, **COARSE),
     (1277325.2321558124, 1.0485902147058282e-06, 6), "bf5d666e6e57a5e3"),
    # Subharmonic, and found where the tolerance hides the limit.
    ((("temperature", 172.2), ("viscosity_coefficient", 14781.0), ("spring_stiffness", 1839.0),
      ("angular_frequency", 34.96)), Options(rtol=1e-4),
     (5864948.885053765, 0.0035892968479467433, 48), "1b0efbf7b578fe2a"),
]  # fmt: skip
# The rows of result variables younger than the table. Empty this when the table is renewed.
YOUNGER: dict[str, tuple[float, ...]] = {
    "friction_force_in_phase": (
        -6.86524953247e-06, -3.75869904238e-05, 0.00476686251167, 0.00476796261054,
        0.00153432285869, 0.00322350377987, 0.000151357860108, 0.00154503128708,
        0.000162230761025, 0.00239970633325, 0.00382881686341, 8.80406786331e-07,
        1.13455922508e-06, 9.48331965308e-07, 0.000249159178589,
    ),
    "friction_force_out_of_phase": (
        0.00133022557629, 0.00118627100533, 7.36364894063e-05, 1.32224665009e-05,
        0.00219416013583, 1.85157825853e-05, 0.000665677026615, 0.002137856321,
        0.000555319997179, 0.00238370830697, 0.00188044370351, 4.9709051538e-07,
        1.69858488754e-07, 4.48383259917e-07, 0.000697622762388,
    ),
    "friction_force_rms": (
        0.00121201824443, 0.000942530744053, 0.00337108247082, 0.00337144638328,
        0.00190137076858, 0.00227939863789, 0.000491611134987, 0.00187059730961,
        0.000415750601249, 0.00239184028245, 0.00301687239672, 7.14943683543e-07,
        8.11202050667e-07, 7.41774271659e-07, 0.000919073153001,
    ),
    "friction_force_mean_abs": (
        0.000920044860779, 0.000816755913038, 0.00303596346376, 0.00303533618521,
        0.0017353573859, 0.00205231200006, 0.000466109891058, 0.00170490012678,
        0.000392160319387, 0.00215341283548, 0.00271340726062, 6.4383726385e-07,
        7.30338013367e-07, 6.67983641884e-07, 0.000554031457368,
    ),
}  # fmt: skip
# Error estimates are small differences, whose digits differ between machines.
BLURRED = ("friction_force_in_phase_error", "friction_force_out_of_phase_error")
HASHED = [i for i, name in enumerate(RESULT_COLUMNS) if name not in (*YOUNGER, *BLURRED)]
ADVICE = "the numbers have changed: raise NUMERICS_VERSION and renew this table"
COLUMNS = [
    RESULT_COLUMNS.index(name)
    for name in ("elastic_stress_amplitude", "friction_force_amplitude", "periods_integrated")
]

# Euler-Cromer for special fluids, whose kernels no other test of the suite compiles.
SPECIAL = (9, 10, 12)
ROWS = [i for i in range(len(TABLE)) if i not in SPECIAL] + marked("stress", SPECIAL)


@cache
def results_of(i: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the result row (columns,) and the final row (columns,) of row `i` of the table."""
    changes, options, _, _ = TABLE[i]
    results, finals = compute_orbits(np.array(Parameters(**dict(changes))), options)
    return results[0], finals[0]


def computed(i: int) -> tuple[tuple[float, ...], str]:
    """Return the numbers and the hash for row `i` of the table."""
    result, final = results_of(i)
    digest = hashlib.sha256(result[HASHED].tobytes() + final.tobytes()).hexdigest()
    return tuple(result[COLUMNS].tolist()), digest[:16]


def this_machine() -> tuple[str, str, str]:
    return get_host_cpu_name(), numba.__version__, llvmlite.__version__


def test_the_version_is_the_one_of_these_numbers() -> None:
    assert NUMERICS_VERSION == VERSION


@pytest.mark.parametrize("i", ROWS)
def test_the_numbers_agree_with_the_version(i: int) -> None:
    numbers = TABLE[i][2]
    assert computed(i)[0] == pytest.approx(numbers, rel=1e-9, abs=1e-12), (ADVICE, computed(i))


@pytest.mark.parametrize("name", YOUNGER)
@pytest.mark.parametrize("i", ROWS)
def test_the_numbers_of_younger_variables_agree_with_the_version(i: int, name: str) -> None:
    found = results_of(i)[0]
    value = found[RESULT_COLUMNS.index(name)]
    # For a locked film this is a small difference of large numbers, with the digits of F.
    largest = found[RESULT_COLUMNS.index("friction_force_max")]
    assert value == pytest.approx(YOUNGER[name][i], rel=1e-9, abs=1e-9 * largest), (ADVICE, value)


@pytest.mark.parametrize("i", ROWS)
def test_every_bit_agrees_with_the_version(i: int) -> None:
    if this_machine() != MADE_ON:
        pytest.skip(f"the bits are those of {MADE_ON}, this is {this_machine()}")
    assert computed(i) == (TABLE[i][2], TABLE[i][3]), (ADVICE, computed(i))
