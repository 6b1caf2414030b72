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

VERSION = 3
MADE_ON = ("rocketlake", "0.68.1", "0.50.0")
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
    ((), LOOSE, (4304776.587827893, 0.0028121355802466132, 5), "fb950325517ea01f"),
    (
        (("angular_frequency", 38.0),),
        LOOSE,
        (2168525.208727253, 0.0019155295117097696, 6),
        "3ee61e9034dab3da",
    ),
    (
        (("rheological_index", 0.0),),
        LOOSE,
        (1758421.0683559855, 0.004767430919259455, 5),
        "5b9adf3f192c98f7",
    ),
    (
        (("rheological_index", 2 / 3),),
        LOOSE,
        (298046.4137089123, 0.004767964709592723, 5),
        "f03cdccc43d90d2d",
    ),
    (
        (("rheological_index", -0.5), ("temperature", 250.0)),
        LOOSE,
        (1853960.7797157825, 0.0025806200236274638, 4),
        "875910b724f6727f",
    ),
    ((VISCOUS,), Options(dt=2e-5, **COARSE), (0.0, 0.0005992449187231226, 4), "c7826bbc6f968edb"),
    (
        (VISCOUS, ("rheological_index", -0.5)),
        Options(dt=2e-5, **COARSE),
        (0.0, 0.0025636309746984364, 4),
        "25ccd9a50bff6a65",
    ),
    (
        (VISCOUS, ("drive_amplitude", -0.5e-6)),
        Options(dt=2e-5, **COARSE),
        (0.0, 0.0005130722087228641, 4),
        "6367a832defe3e47",
    ),
    (
        (VISCOUS, ("rheological_index", 0.0), ("viscosity_coefficient", 1e3)),
        Options(dt=2e-5, **COARSE),
        (0.0, 0.0033825729514784073, 5),
        "f2b2fc19b5b89ef3",
    ),
    (
        (VISCOUS, ("rheological_index", 2 / 3), ("viscosity_coefficient", 10.0)),
        Options(dt=2e-5, **COARSE),
        (0.0, 0.004277576626034165, 7),
        "702011e0a641f147",
    ),
    (
        SOLID,
        Options(dt=5e-9, **COARSE),
        (1451762.4705775226, 1.0107122299330887e-06, 6),
        "70fca193910a667c",
    ),
    (
        (*SOLID, ("rheological_index", 0.0)),
        Options(dt=5e-9, **COARSE),
        (431332.76393997186, 1.1472177327739443e-06, 12),
        "e1a0c7f79a693a32",
    ),
    (
        (*SOLID, ("rheological_index", -0.5)),
        Options(dt=5e-9, **COARSE),
        (1277325.2321558085, 1.048590214705825e-06, 6),
        "54f809f1395f64cd",
    ),
]
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
    assert computed(i)[0] == pytest.approx(numbers, rel=1e-9, abs=1e-12), (ADVICE, computed(i))


@pytest.mark.parametrize("i", range(len(TABLE)))
def test_every_bit_is_that_of_the_version(i: int) -> None:
    if this_machine() != MADE_ON:
        pytest.skip(f"the bits are those of {MADE_ON}, this is {this_machine()}")
    assert computed(i) == (TABLE[i][2], TABLE[i][3]), (ADVICE, computed(i))
