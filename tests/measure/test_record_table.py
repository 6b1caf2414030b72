"""The table of a record, which is read by all code that handles its slots."""

from __future__ import annotations

import numpy as np
import pytest

from stickslip.measure import accumulate
from stickslip.measure.accumulate import (
    FORCE,
    HIGHEST,
    IMPULSE,
    LARGEST,
    LOWEST,
    NUMBER,
    PHASE,
    RECORD,
    RECORD_TABLE,
    SIZE,
    SQUARE,
    STRESS,
    SUM,
    TIME,
    WORK,
    Moment,
    Slot,
    accumulator,
    slots_of,
)
from stickslip.measure.results import RecordUnits, write_stretch
from stickslip.measure.window import Window

UNITS = RecordUnits(length=2.0, stress=3.0, force=5.0, time=11.0)
FACTORS = {
    STRESS: 3.0, FORCE: 5.0, WORK: 10.0, TIME: 11.0, NUMBER: 1.0, IMPULSE: 55.0, SIZE: 55.0,
    SQUARE: 275.0,
}  # fmt: skip


def test_every_slot_has_one_name_and_a_meaning() -> None:
    assert len({slot.meaning for slot in RECORD_TABLE}) == RECORD
    assert accumulate.FORCE_SIZE == RECORD - 1


def test_the_least_value_follows_the_largest_in_the_same_unit() -> None:
    for slot in slots_of(HIGHEST):
        pair = RECORD_TABLE[slot : slot + 2]
        assert [each.reducer for each in pair] == [HIGHEST, LOWEST]
        assert pair[0].unit == pair[1].unit


@pytest.mark.parametrize(
    "slot", [slot for slot in RECORD_TABLE if slot.integrand], ids=lambda slot: slot.meaning
)
def test_an_integrand_is_the_same_in_the_mirror_image_of_a_motion(slot: Slot) -> None:
    """Lanes integrate every other half period in it."""
    seen = Moment(
        x=0.7, V=0.3, u=-0.2, phi=0.4, sigma_el=-1.5, F=-2.5, power=0.6, loss=0.9, motion=1.7,
        phase=0.4,
    )  # fmt: skip
    turned = seen.phase + np.pi
    mirrored = Moment(
        x=-0.7, V=-0.3, u=0.2, phi=0.4, sigma_el=1.5, F=2.5, power=0.6, loss=0.9, motion=-1.7,
        phase=turned,
    )  # fmt: skip
    assert slot.reducer == SUM
    assert slot.integrand(mirrored) == pytest.approx(slot.integrand(seen), rel=1e-15)
    assert slot.integrand(seen) != 0.0


@pytest.mark.parametrize("slot", range(RECORD))
@pytest.mark.parametrize("passes", [1, 2])
def test_every_slot_is_written_in_its_unit(slot: int, passes: int) -> None:
    record, target = np.zeros(RECORD), np.full(RECORD, np.nan)
    record[slot] = 1.0 if RECORD_TABLE[slot].reducer != LOWEST else -1.0
    write_stretch(record, UNITS, passes, target)
    expected = record[slot] * FACTORS[RECORD_TABLE[slot].unit]
    if RECORD_TABLE[slot].reducer == SUM:
        expected *= passes
    assert target[slot] == expected
    assert not np.isnan(target).any()


def test_units_that_change_sign_with_the_drive_leave_sizes_positive() -> None:
    turned, target = UNITS._replace(length=-2.0, stress=-3.0, force=-5.0), np.empty(RECORD)
    write_stretch(np.ones(RECORD), turned, 1, target)
    signs = {IMPULSE: -1.0, SIZE: 1.0, SQUARE: 1.0, WORK: 1.0}
    for slot in range(RECORD):
        if (unit := RECORD_TABLE[slot].unit) in signs:
            assert np.sign(target[slot]) == signs[unit]


def test_a_window_reduces_every_slot_as_the_table_says() -> None:
    window, rng = Window(1), np.random.default_rng(1)
    records = rng.uniform(1.0, 2.0, (3, 1, RECORD))
    records[:, :, list(slots_of(PHASE))] = 0.0  # no phase is known
    for each in records:
        window.add(each)
    for reducer, reduce in ((HIGHEST, np.max), (LARGEST, np.max), (LOWEST, np.min), (SUM, np.sum)):
        for slot in slots_of(reducer):
            assert window.record[0, slot] == pytest.approx(reduce(records[:, 0, slot]), rel=1e-15)


def test_any_value_replaces_that_of_an_empty_record() -> None:
    lanes = np.full(RECORD, np.nan)
    accumulator(1, 0).clear(lanes, 0)
    assert (lanes[list(slots_of(HIGHEST))] == -np.inf).all()
    assert (lanes[list(slots_of(LOWEST))] == np.inf).all()
    assert (lanes[list(slots_of(SUM, LARGEST, PHASE))] == 0.0).all()
