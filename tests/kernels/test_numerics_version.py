"""The numbers of NUMERICS_VERSION: a change of any of them is a new version.

At a loose tolerance every change of the method shows: in steps, weights, judgement or order of
operations that matter. Rounding on another processor stays far below 1e-7.
"""

from __future__ import annotations

import numpy as np
import pytest

from stickslip import Options, Parameters, kernels, simulate
from stickslip.orbit import compute_orbits

LOOSE = Options(rtol=1e-4, stationary_rtol=1e-4)

VERSION = 2
ADAPTIVE = {  # changes to Fig. 3: stress amplitude [Pa], force amplitude [N], periods integrated
    (): (4304776.4276714185, 0.0028121353929894694, 5),
    (("angular_frequency", 38.0),): (2168527.4824972446, 0.0019155293607899207, 6),
    (("rheological_index", 0.0),): (1758421.0683527358, 0.0047674309192542565, 5),
    (("rheological_index", 2 / 3),): (298047.0142212811, 0.004767980496753435, 5),
    (("rheological_index", -0.5), ("temperature", 250.0)): (
        1853960.7797157825,
        0.0025806200236274638,
        4,
    ),
}
FIXED = [
    0.0,
    -1.3892201560506942e-09,
    -5.954981754207489e-09,
    -8.953177163223061e-09,
    -7.891468064051829e-09,
]


def test_the_version_is_the_one_of_these_numbers() -> None:
    assert kernels.NUMERICS_VERSION == VERSION


@pytest.mark.parametrize("changes", ADAPTIVE)
def test_the_adaptive_numbers_are_those_of_the_version(
    changes: tuple[tuple[str, float], ...],
) -> None:
    results, _ = compute_orbits(np.array(Parameters(**dict(changes))), LOOSE)
    stress, force, periods = ADAPTIVE[changes]
    advice = "the numbers have changed: raise NUMERICS_VERSION and renew this table"
    assert results[0, :2] == pytest.approx([stress, force], rel=1e-7), advice
    assert results[0, 11] == periods, advice


def test_the_fixed_step_numbers_are_those_of_the_version() -> None:
    p = Parameters(angular_frequency=1000.0, drive_amplitude=1e-8)
    ds = simulate(p, periods=1, samples_per_period=4, method="euler-cromer", dt=1e-8)
    assert ds.lower_displacement.values == pytest.approx(FIXED, rel=1e-9, abs=1e-20)
