"""The orbits of chosen points in a page: thinned, and what is said of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from html import escape

import numpy as np
import xarray as xr
from bokeh.models import ColumnDataSource
from numpy.typing import NDArray

from stickslip.status import Status
from sweeps.charts.colours import code_name
from sweeps.page.chosen_points import Numbers, places_of
from sweeps.page.orbit_figures import DRAWN, columns_of
from sweeps.points import Motion, motions


@dataclass(frozen=True)
class PackedOrbit:
    """The motion at a point: its courses, none where it cannot be followed, and sentences on it.

    The courses last so many `periods` of the drive.
    """

    courses: ColumnDataSource | None
    words: str
    periods: float


def packed_orbits(
    ds: xr.Dataset,
    chosen: Numbers,
    *,
    workers: int | None = None,
    on_motion: Callable[[], None] = lambda: None,
) -> list[PackedOrbit]:
    """Return the motion at some points, given as their numbers in C order."""
    found = motions(ds, places_of(ds, chosen), workers=workers, on_motion=on_motion)
    return [
        PackedOrbit(_courses(motion, f"orbit {number}"), _words(motion), drive_periods(motion))
        for number, motion in enumerate(found)
    ]


def _courses(motion: Motion, name: str) -> ColumnDataSource | None:
    if motion.courses is None:
        return None
    columns = columns_of(motion.courses)
    kept = thinned(np.stack([columns[name] for name in DRAWN]))
    thin = {name: np.float32(column[kept]) for name, column in columns.items()}
    return ColumnDataSource(thin, name=name)


def _words(motion: Motion) -> str:
    """Return sentences on a motion, as HTML: over which time it is drawn, and its status."""
    status = motion.point.status
    repeats = bool(motion.obstacle) and status.sentence.endswith(motion.obstacle)
    words = f"<span>{escape(_sentence(motion))}</span>"
    if status is Status.OK or repeats:
        return words
    return f"{words}<em>{escape(code_name('status', status))}: {escape(status.sentence)}</em>"


def drive_periods(motion: Motion) -> float:
    """Return how many periods of the drive the courses of a motion last."""
    if motion.courses is None:
        return 1.0
    omega = float(motion.courses["angular_frequency"])
    return float(motion.courses["elapsed_time"][-1]) * omega / (2 * np.pi)


def _sentence(motion: Motion) -> str:
    if motion.courses is None:
        return f"The motion cannot be followed: {motion.obstacle}"
    count = round(drive_periods(motion))
    periods = f"{count} drive period" + "s" * (count != 1)
    status = motion.point.orbit().status
    if not status.is_result:
        return f"There is no stationary orbit: {periods} from the initial state are drawn."
    if status is Status.APERIODIC:
        return f"The orbit does not close: {periods} of it are drawn."
    return f"The stationary orbit, which closes after {periods}."


def thinned(
    columns: NDArray[np.float64], tolerance: float = 1e-3, most: int = 6000
) -> NDArray[np.int64]:
    """Return samples (n,) of which straight lines between the chosen ones give columns (m, n).

    No column is missed by more than `tolerance` of its range, unless that takes more than about
    `most` samples. The first column, the time, is what lies across.
    """
    across, heights = columns[0], columns[1:]
    spans = np.ptp(heights, axis=1)
    heights = heights / np.where(spans > 0, spans, 1.0)[:, None]
    kept = np.union1d([0, across.size - 1], [heights.argmin(1), heights.argmax(1)])
    while kept.size < most:
        drawn = np.stack([np.interp(across, across[kept], height[kept]) for height in heights])
        missed = np.abs(heights - drawn).max(axis=0)
        worst = _worst_of_each_gap(missed, kept)
        worst = worst[missed[worst] > tolerance]
        if not worst.size:
            break
        kept = np.union1d(kept, worst)
    return kept


def _worst_of_each_gap(missed: NDArray[np.float64], kept: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return where the most is missed in each gap between kept samples that has samples inside."""
    begins = kept[:-1][np.diff(kept) > 1] + 1
    ends = kept[1:][np.diff(kept) > 1]
    return np.array(
        [begin + missed[begin:end].argmax() for begin, end in zip(begins, ends, strict=True)],
        dtype=np.int64,
    )
