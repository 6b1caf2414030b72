"""Pulls of the upper block: its velocity as a function of time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias, TypeGuard

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    import pandas as pd

    Pull: TypeAlias = float | Mapping[str, ArrayLike] | pd.DataFrame

COLUMNS = ("elapsed_time", "velocity")
"""The columns of a table that describes a pull."""

PULL_SAMPLES = 12_000
"""The default number of samples of a pull, the same as for six drive periods."""


class PullError(ValueError):
    """An invalid pull.

    `what` describes the fault; `row` is the faulty row of the table, from 0, or None.
    """

    def __init__(self, what: str, row: int | None = None) -> None:
        super().__init__(what if row is None else f"row {row}: {what}")
        self.what, self.row = what, row


class Course(NamedTuple):
    """The velocity [m/s] of the upper block at some times [s], (n,) each; linear in between.

    It is constant before the first and after the last time. Where a time occurs twice, it jumps.
    """

    time: NDArray[np.float64]
    velocity: NDArray[np.float64]

    def after(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the velocities (n,) just after some times (n,)."""
        return np.interp(times, self.time, self.velocity)

    def before(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the velocities (n,) just before some times (n,); they differ where it jumps."""
        first = np.searchsorted(self.time, times).clip(max=len(self.time) - 1)
        return np.where(self.time[first] == times, self.velocity[first], self.after(times))


def course_of(pull: Pull) -> Course:
    """Return the course of a pull: a velocity, or a table with the columns of `COLUMNS`.

    Raises PullError, with the faulty row of the table.
    """
    if _is_number(pull):
        time, velocity = np.zeros(1), np.array([float(pull)])
    else:
        time, velocity = _columns(pull)
    if len(time) != len(velocity) or not len(time):
        raise PullError(
            f"a pull needs as many velocities as times, and at least one of each, not "
            f"{len(velocity)} and {len(time)}"
        )
    for name, values in zip(COLUMNS, (time, velocity), strict=True):
        if len(bad := np.flatnonzero(~np.isfinite(values))):
            raise PullError(f"{name} is {values[bad[0]]}, but must be finite", int(bad[0]))
    if time[0] < 0.0:
        raise PullError(f"elapsed_time is {time[0]:g} s, but must not be negative", 0)
    _refuse_disorder(time)
    if not velocity.any():
        raise PullError("the velocity is 0 throughout: nothing would be pulled")
    return Course(time, velocity)


def _refuse_disorder(time: NDArray[np.float64]) -> None:
    """Raise PullError for a time that is before the previous one, or occurs more than twice."""
    if len(early := np.flatnonzero(np.diff(time) < 0.0)):
        row = int(early[0]) + 1
        fall = f"from {time[row - 1]:g} s to {time[row]:g} s"
        raise PullError(f"elapsed_time falls {fall}; times must not decrease", row)
    if len(third := np.flatnonzero(time[2:] == time[:-2])):
        row = int(third[0]) + 2
        raise PullError(
            f"elapsed_time is {time[row]:g} s in three rows; two rows with the same time mean that "
            "the velocity jumps from the first to the second",
            row,
        )


def _is_number(pull: Any) -> TypeGuard[float]:
    """Return whether a pull is a number, of Python or NumPy, or an array without dimensions."""
    if getattr(pull, "ndim", None) == 0:
        return str(pull.dtype.kind) in "iuf"
    return isinstance(pull, (int, float)) and not isinstance(pull, bool)


def _columns(pull: Any) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    wanted = " and ".join(COLUMNS)
    try:
        missing = [] if isinstance(pull, str) else [n for n in COLUMNS if n not in pull]
        if missing:
            raise PullError(f"a pull needs the columns {wanted}; {', '.join(missing)} is missing")
        if masked := [name for name in COLUMNS if np.ma.is_masked(pull[name])]:
            raise PullError(f"{' and '.join(masked)} must not contain masked values")
        time, velocity = (np.asarray(pull[name], dtype=float) for name in COLUMNS)
    except PullError:
        raise
    except (TypeError, ValueError):
        raise PullError(
            f"a pull is a velocity in m/s, or a table with the columns {wanted}, not {pull!r}"
        ) from None
    if time.ndim != 1 or velocity.ndim != 1:
        raise PullError(f"the columns {wanted} must be lists of numbers")
    return time, velocity
