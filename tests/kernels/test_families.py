"""Points go to the kernels of their fluids, and the choice of kernel makes no difference."""

from __future__ import annotations

import numpy as np
import pytest
from support.marches import FAST_DT, fast, period
from support.marks import one_then
from support.points import GAMMAS, rows

from stickslip import Options, Status
from stickslip.kernels.families import KIND, Family, families
from stickslip.measure.results import STATUS
from stickslip.model.laws import friction_law
from stickslip.options import COSINE, FRICTION_LAWS, HARMONICS, Physics
from stickslip.orbit import compute_orbits
from stickslip.variables import RESULT_COLUMNS

LAW = "power-law"
PHYSICS = Physics(LAW)
EXTREMA = [i for i, name in enumerate(RESULT_COLUMNS) if name.endswith(("_max", "_min"))]
COUNTS = [RESULT_COLUMNS.index(name) for name in ("orbit_periods", "melting_count")]


def members(indices: list[float]) -> dict[float | None, list[int]]:
    found = families(PHYSICS, np.array([(index, 0.0) for index in indices]).reshape(-1, 2))
    return {family.gamma: positions.tolist() for family, positions in found}


SPECIAL = friction_law(LAW).special_indices


def test_every_point_goes_to_the_kernel_of_its_fluid() -> None:
    found = members([0.0, -2 / 3, 0.4, 2 / 3, -2 / 3, -0.5, 0.0, 0.4])
    assert found == {-2 / 3: [1, 4], 0.0: [0, 6], 2 / 3: [3], None: [2, 5, 7]}


def test_any_coefficient_beyond_the_paper_makes_another_family() -> None:
    rows = np.eye(len(KIND))  # the index alone, then each coefficient alone, then each harmonic
    rows[:, 0] = 0.0
    found = {
        (family.higher, family.physics.drive): positions.tolist()
        for family, positions in families(PHYSICS, rows)
    }
    energy, harmonics = list(range(1, len(KIND) - 2)), [len(KIND) - 2, len(KIND) - 1]
    assert found == {
        (False, COSINE): [0], (True, COSINE): energy, (False, HARMONICS): harmonics
    }  # fmt: skip


def test_only_the_very_index_is_special() -> None:
    # A kernel has its index as a literal and would compute a neighbouring fluid as its own.
    for gamma in SPECIAL:
        beside = [float(np.nextafter(gamma, direction)) for direction in (-1.0, 1.0)]
        assert members(beside) == {None: [0, 1]}
    assert members([-0.0]) == {0.0: [0]}


@pytest.mark.parametrize("law", FRICTION_LAWS)
def test_each_family_has_another_name(law: str) -> None:
    # Kernels and their entries in the cache bear the name of their family.
    gammas = [*friction_law(law).special_indices, None]
    assert len({str(Family(Physics(law), gamma)) for gamma in gammas}) == len(gammas)
    assert str(Family(Physics(law), 0.1)) == f"{law},gamma=0.10000000000000001"


@pytest.mark.parametrize("gamma", GAMMAS)
def test_general_and_special_kernels_find_the_same_orbits(gamma: float) -> None:
    # The second fluid is so close to the special one that only its kernel differs.
    points = rows("rheological_index", [gamma, gamma + 1e-12], temperature=230.0)
    special, general = compute_orbits(points, Options(rtol=1e-7, stationary_rtol=1e-7))[0]
    assert special[STATUS] == general[STATUS] == Status.OK
    np.testing.assert_array_equal(general[COUNTS], special[COUNTS])
    assert special[0] != general[0]
    np.testing.assert_allclose(general[EXTREMA], special[EXTREMA], rtol=1e-7)


@pytest.mark.parametrize("gamma", one_then("stress", GAMMAS))
def test_general_and_special_marches_find_the_same_periods(gamma: float) -> None:
    points = [fast(rheological_index=index) for index in (gamma, gamma + 1e-12)]
    states, records, statuses = period(points, FAST_DT)
    assert statuses.tolist() == [Status.OK, Status.OK]
    assert np.all(states[0] != states[1])
    np.testing.assert_allclose(states[1], states[0], rtol=1e-8)
    np.testing.assert_allclose(records[1], records[0], rtol=1e-8)
