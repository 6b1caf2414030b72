"""The columns of result rows: what a file holds of them."""

from __future__ import annotations

import numpy as np
import pytest

from stickslip.datasets import result_values
from stickslip.status import Status
from stickslip.variables import RESULT_COLUMNS, RESULTS
from sweeps.files.columns import STATUS, STATUS_CODES, status_counts


@pytest.mark.parametrize("name", RESULT_COLUMNS)
def test_a_point_that_is_not_computed_has_the_missing_value_of_its_variable(name: str) -> None:
    found = result_values(name, np.array([np.nan, 3.0]))
    assert found.dtype.str[1:] == RESULTS[name].dtype
    np.testing.assert_array_equal(found, [RESULTS[name].missing, 3])


def test_the_sign_of_a_nan_stays() -> None:
    column = np.array([np.copysign(np.nan, -1.0)])
    assert result_values("asymmetry", column).tobytes() == column.tobytes()


def test_statuses_are_counted_by_code() -> None:
    counts = status_counts(np.array([[0, 0, 5], [127, 1, 0]], dtype=np.int8))
    assert counts.shape == (STATUS_CODES,)
    assert counts[[0, 1, 5, Status.PENDING]].tolist() == [3, 1, 1, 1]
    assert RESULT_COLUMNS[STATUS] == "status"
