"""Every parameter reaches the lanes of every method, and changes their results correctly.

A lane holds scaled parameters, written out by hand for each method. If one was forgotten or scaled
wrongly, the numbers would still be finite and plausible. The twins take parameters in SI units.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from support.marches import FAST_DT, fast, period
from support.scalar_twins import adaptive_periods, euler_cromer_period

from stickslip import Parameters, Status
from stickslip.kernels.adaptive.passes import MEASURE, TRAVEL, work_through
from stickslip.kernels.orbits.conversion import conversion_of
from stickslip.kernels.orbits.motions import CYCLE, OUTCOME, motions_of
from stickslip.kernels.trajectories import start_kernel
from stickslip.measure.accumulate import (
    FORCE,
    PHI_MAX,
    RECORD,
    RECORD_TABLE,
    STRESS,
    WORK,
)
from stickslip.model.state import STATE
from stickslip.options import DEFAULTS, METHODS
from stickslip.variables import PARAMETERS

BASE = fast(
    rheological_index=0.4,  # a general power: the kernels of special fluids have it as a literal
    initial_order_parameter=0.5,
    noise_intensity=0.5,
    quintic_coefficient=300.0,
    sextic_coefficient=500.0,
    third_harmonic=0.1,
    fifth_harmonic=0.1,
)
"""A point at which every parameter matters, since a period is too short to forget the start. All
points are of one family, so that one kernel is compiled."""

RTOL = 1e-6
"""Agreement of lanes and twin, in the scales that tolerances refer to. The motion does not close,
and only the twin records an extremum at the start."""


def changed(name: str) -> Parameters:
    value = getattr(BASE, name)
    return BASE._replace(**{name: 1.1 * value if value else 0.1})


POINTS = {"base": BASE, **{name: changed(name) for name in PARAMETERS}}

TOLERANCE = 1e-8
STEP = 10 * FAST_DT  # s; lanes and twin of Euler-Cromer take the same steps, whatever their length

# States (x, v, phi) after a period, and records.
Measured = dict[str, tuple[np.ndarray, np.ndarray]]


@cache
def by_lanes(method: str) -> Measured:
    found = {"adaptive": adaptive_lanes, "euler-cromer": euler_cromer_lanes}[method]()
    return dict(zip(POINTS, zip(*found, strict=True), strict=True))


def adaptive_lanes() -> tuple[np.ndarray, np.ndarray]:
    points = np.array(list(POINTS.values()))
    motions = motions_of(points, DEFAULTS.physics)
    motions.counts[:, CYCLE] = 2
    for mode in (TRAVEL, MEASURE):  # first a period without a record, which omits the start
        work_through(motions, mode, TOLERANCE, 10**7, DEFAULTS.physics)
    assert np.all(motions.counts[:, OUTCOME] == Status.OK)
    records = np.empty((len(points), RECORD))
    conversion = conversion_of(DEFAULTS.physics)
    conversion.write_records(points, motions.counts[:, CYCLE], motions.measured, records)
    conversion.restore_states(points, motions.states)
    states = motions.states[:, :-1]
    return np.column_stack([states[:, :2], np.exp(states[:, 2])]), records


def euler_cromer_lanes() -> tuple[np.ndarray, np.ndarray]:
    states, records, statuses = period(list(POINTS.values()), STEP)
    assert np.all(statuses == Status.OK)
    return states, records


def by_twin(method: str, p: Parameters) -> tuple[np.ndarray, np.ndarray]:
    if method == "euler-cromer":
        return euler_cromer_period(p, STEP)[:2]
    start = np.empty(len(STATE))
    start_kernel(DEFAULTS.physics)(np.array(p), start)
    begin = adaptive_periods(p, start, 1, TOLERANCE)[0][-1]
    states, record = adaptive_periods(p, begin, 1, TOLERANCE)
    return np.array([*states[-1, :2], np.exp(states[-1, 2])]), record


def differences(
    p: Parameters, ours: tuple[np.ndarray, np.ndarray], theirs: tuple[np.ndarray, np.ndarray]
) -> np.ndarray:
    """Return differences of states and records, relative to the scales of their quantities."""
    X_m, record = abs(p.drive_amplitude), theirs[1]
    units = np.array([slot.unit for slot in RECORD_TABLE])
    size_of = {unit: np.max(np.abs(record[units == unit])) for unit in (STRESS, FORCE, WORK)}
    # Counts and times are known only to a sample.
    slots = np.append(np.flatnonzero(np.isin(units, list(size_of))), PHI_MAX)
    sizes = [X_m, X_m * p.angular_frequency, 1.0, *(size_of.get(units[s], 1.0) for s in slots)]
    both = [np.concatenate([state, record[slots]]) for state, record in (ours, theirs)]
    return np.abs(both[0] - both[1]) / sizes


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", PARAMETERS)
def test_a_parameter_changes_a_result(name: str, method: str) -> None:
    found = by_lanes(method)
    assert np.max(differences(BASE, found[name], found["base"])) > 1e-6


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", POINTS)
def test_the_result_agrees_with_the_scalar_twin(name: str, method: str) -> None:
    p = POINTS[name]
    assert np.max(differences(p, by_lanes(method)[name], by_twin(method, p))) < RTOL
