"""The columns of result rows: what a file holds of them, and rows of other versions."""

from __future__ import annotations

import numpy as np
import pytest

from stickslip.status import Status
from stickslip.variables import RESULT_COLUMNS, RESULTS
from sweeps.files.columns import (
    FIRST_COLUMNS,
    STATUS,
    STATUS_CODES,
    conformed,
    lacking,
    result_values,
    status_counts,
)

ROWS = np.arange(4.0 * len(RESULT_COLUMNS)).reshape(4, -1)


@pytest.mark.parametrize("name", RESULT_COLUMNS)
def test_a_point_that_is_not_computed_has_the_missing_value_of_its_variable(name: str) -> None:
    found = result_values(name, np.array([np.nan, 3.0]))
    assert found.dtype.str[1:] == RESULTS[name].dtype
    np.testing.assert_array_equal(found, [RESULTS[name].missing, 3])


def test_the_sign_of_a_nan_stays() -> None:
    column = np.array([np.copysign(np.nan, -1.0)])
    assert result_values("asymmetry", column).tobytes() == column.tobytes()


def test_rows_of_this_version_are_handed_through() -> None:
    assert conformed(ROWS, RESULT_COLUMNS) is ROWS


def test_rows_of_another_version_are_read_by_name() -> None:
    shuffled = ["status", "unknown", *RESULT_COLUMNS[:-1][::-1]]
    shuffled.remove("asymmetry")
    columns = {name: ROWS[:, RESULT_COLUMNS.index(name)] for name in shuffled if name in RESULTS}
    old = np.column_stack([columns.get(name, np.full(4, 77.0)) for name in shuffled])
    found = conformed(old, shuffled)
    for place, name in enumerate(RESULT_COLUMNS):
        expected = np.full(4, np.nan) if name == "asymmetry" else ROWS[:, place]
        np.testing.assert_array_equal(found[:, place], expected)


def test_what_rows_of_another_version_lack_is_told_in_order() -> None:
    assert lacking(RESULT_COLUMNS) == ()
    assert lacking(["status", "unknown"]) == tuple(n for n in RESULT_COLUMNS if n != "status")


def test_the_first_version_had_thirteen_columns_that_are_still_known() -> None:
    assert len(FIRST_COLUMNS) == 13
    assert [name for name in RESULT_COLUMNS if name in FIRST_COLUMNS] == list(FIRST_COLUMNS)


def test_statuses_are_counted_by_code() -> None:
    counts = status_counts(np.array([[0, 0, 5], [127, 1, 0]], dtype=np.int8))
    assert counts.shape == (STATUS_CODES,)
    assert counts[[0, 1, 5, Status.PENDING]].tolist() == [3, 1, 1, 1]
    assert RESULT_COLUMNS[STATUS] == "status"
