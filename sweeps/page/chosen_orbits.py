"""The orbits in a page: the choice of their points, the nearest orbit to a point, their courses."""

from __future__ import annotations

from collections.abc import Callable
from html import escape
from typing import Any

import numpy as np
import xarray as xr
from bokeh.models import ColumnDataSource
from numpy.typing import NDArray

from stickslip.status import Status
from stickslip.variables import PARAMETERS
from sweeps.charts.axes import MANY, is_scattered
from sweeps.charts.colours import code_name
from sweeps.charts.labels import parameters_along
from sweeps.charts.missing import RESULT_STATUSES
from sweeps.grid import CASE, DIRECTION
from sweeps.human import counted
from sweeps.page.turns import columns_of, drive_periods
from sweeps.points import Motion, motions

Numbers = NDArray[np.int64]

_WIDE = 20.0  # distances between cases use the logarithm of a parameter that varies by more
_SHORT_WEIGHT = 2.0  # how much farther away a point of another slice, or of another fluid, is

_TRIES = 50  # for each point; most places that are tried are free and have a result


def failed_points(ds: xr.Dataset) -> Numbers:
    """Return the computed points that have no result, as their numbers in C order."""
    return np.flatnonzero(~np.isin(ds["status"].values, [*RESULT_STATUSES, Status.PENDING]))


def places_of(ds: xr.Dataset, numbers: Numbers) -> list[dict[str, int]]:
    """Return the indices of points along the dimensions from their numbers in C order."""
    dims = list(map(str, ds["status"].dims))
    if not dims:
        return [{} for _ in numbers]
    places = np.stack(np.unravel_index(numbers, ds["status"].shape), axis=-1)
    return [dict(zip(dims, place, strict=True)) for place in places.tolist()]


def start_along(ds: xr.Dataset, dim: str) -> int:
    """Return the index at which a page opens: the paper's value, or the middle of the axis."""
    values, usual = ds[dim].values, PARAMETERS[dim].default if dim in PARAMETERS else np.nan
    if dim in PARAMETERS and values.min() <= usual <= values.max():
        return int(np.argmin(np.abs(values - usual)))
    return ds.sizes[dim] // 2


def chosen_points(ds: xr.Dataset, most: int) -> Numbers:
    """Return up to `most` computed points of a result, as their numbers in C order.

    The point at which the page opens is chosen first, then points without a result. Both sides of
    the boundaries between regimes take up to half of the rest, shared by all kinds of boundary. The
    others are spread evenly over the axes, or drawn at random if cases are in no order.
    """
    place = tuple(start_along(ds, str(dim)) for dim in ds["status"].dims)
    first = np.arange(ds["status"].size).reshape(ds["status"].shape)[place]
    is_pending = ds["status"].values[place] == Status.PENDING
    chosen = np.array([] if is_pending else [first], np.int64)[:most]
    failed = np.setdiff1d(failed_points(ds), chosen)
    chosen = np.union1d(chosen, _evenly(failed, most - chosen.size))
    chosen = np.union1d(chosen, _both_sides(_boundaries(ds), (most - chosen.size) // 2))
    free = np.isin(ds["status"].values, RESULT_STATUSES)
    free.ravel()[chosen] = False
    unordered = CASE in ds.dims and is_scattered(ds, CASE)
    spread = _drawn if unordered else _spread
    return np.union1d(chosen, spread(free, most - chosen.size))


def _evenly(numbers: NDArray[Any], most: int) -> NDArray[Any]:
    """Return up to `most` evenly chosen numbers, or pairs of numbers."""
    if len(numbers) <= most:
        return numbers
    return numbers[np.linspace(0, len(numbers) - 1, most).round().astype(np.int64)]


def _boundaries(ds: xr.Dataset) -> list[Numbers]:
    """Return the pairs (n, 2) of neighbours on both sides of each kind of boundary."""
    if "regime" not in ds:
        return []
    # Neighbours along the long axes or, if there are none, along all axes.
    dims = [str(dim) for dim in ds["regime"].dims]
    near = [d for d in dims if d != DIRECTION and not (d == CASE and is_scattered(ds, d))]
    axes = [dims.index(d) for d in [d for d in near if ds.sizes[d] > MANY] or near]
    if not axes:
        return []
    regime = np.where(
        np.isin(ds["status"].values, RESULT_STATUSES), ds["regime"].values, -1
    ).astype(int)
    numbers = np.arange(regime.size).reshape(regime.shape)
    lines = [np.moveaxis(numbers, axis, 0) for axis in axes]
    pairs = np.concatenate([np.stack([n[:-1].ravel(), n[1:].ravel()], axis=-1) for n in lines])
    sides = np.sort(regime.ravel()[pairs], axis=1)
    parted = (sides[:, 0] != sides[:, 1]) & (sides[:, 0] >= 0)
    kinds = np.unique(sides[parted], axis=0, return_inverse=True)[1].ravel()
    return [pairs[parted][kinds == kind] for kind in range(kinds.max(initial=-1) + 1)]


def _both_sides(boundaries: list[Numbers], most: int) -> Numbers:
    """Return up to `most` points of all boundaries; a short boundary leaves room for others."""
    chosen = np.empty(0, dtype=np.int64)
    for left, pairs in enumerate(sorted(boundaries, key=len)):
        room = (most - chosen.size) // (len(boundaries) - left)
        chosen = np.union1d(chosen, _evenly(pairs, room // 2))
    return chosen


def _spread(free: NDArray[np.bool_], most: int) -> Numbers:
    """Return up to `most` of the free points, spread evenly over the axes of the grid."""
    known = np.flatnonzero(free)
    if known.size <= most or most == 0:
        return known[:most]
    from scipy.stats import qmc  # slow to load, and not every page needs it

    places = qmc.Halton(free.ndim, scramble=False).random(_TRIES * most) * free.shape
    numbers = np.ravel_multi_index(tuple(places.astype(np.int64).T), free.shape)
    _, first = np.unique(numbers, return_index=True)
    drawn = numbers[np.sort(first)]
    return np.asarray(drawn[free.ravel()[drawn]][:most])


def _drawn(free: NDArray[np.bool_], most: int) -> Numbers:
    """Return up to `most` of the free points, drawn at random but the same each time.

    An even choice of case numbers would not be spread evenly: every fourth point of a Sobol
    sequence lies in one part of its box.
    """
    known = np.flatnonzero(free)
    return np.random.default_rng(0).permutation(known)[:most]


def nearest_chosen(ds: xr.Dataset, chosen: Numbers) -> NDArray[np.uint16]:
    """Return, for every point in C order, the index of the nearest chosen point of its kind.

    If no chosen point is of its kind, return the nearest of all.
    """
    from scipy.spatial import KDTree  # pages without orbits do not need it

    if ds["status"].size == 1:
        return np.zeros(1, dtype=np.uint16)
    points, kinds = _points(ds), _kinds(ds)
    nearest = KDTree(points[chosen]).query(points)[1]
    for kind in np.unique(kinds[chosen]):
        own, alike = kinds == kind, np.flatnonzero(kinds[chosen] == kind)
        nearest[own] = alike[KDTree(points[chosen[alike]]).query(points[own])[1]]
    return np.asarray(nearest, dtype=np.uint16)


def _kinds(ds: xr.Dataset) -> NDArray[np.int64]:
    """Return the regime of every point; a number below 0 encodes a status without a result."""
    status = ds["status"].values.astype(np.int64)
    regime = ds["regime"].values if "regime" in ds else np.zeros_like(status)
    kinds = np.where(np.isin(status, RESULT_STATUSES), regime, -1 - status)
    return kinds.ravel().astype(np.int64)  # a masked regime is NaN, but not here


def _points(ds: xr.Dataset) -> NDArray[np.float64]:
    """Return the positions of all points, in C order.

    All axes have the same length, except that points are farther apart along short ones. For cases
    in no order each parameter is an axis.
    """
    columns = []
    for dim, places in zip(ds["status"].dims, np.indices(ds["status"].shape), strict=True):
        size = ds.sizes[dim]
        weight = _SHORT_WEIGHT if size <= MANY else 1.0
        columns += [weight * along[places.ravel()] for along in _measures(ds, str(dim))]
    return np.stack(columns, axis=-1)


def _measures(ds: xr.Dataset, dim: str) -> list[NDArray[np.float64]]:
    """Return the positions of the points of a dimension, from 0 to 1, on one axis or several."""
    linked = parameters_along(ds, dim) if dim == CASE else []
    if not linked or not is_scattered(ds, dim):
        return [np.linspace(0.0, 1.0, ds.sizes[dim])]
    columns = [ds[name].values.astype(float) for name in linked]
    scaled = [np.log(v) if 0.0 < _WIDE * v.min() < v.max() else v for v in columns]
    return [(values - values.min()) / (np.ptp(values) or 1.0) for values in scaled]


# --- the motions at chosen points: thinned, with sentences about them -----------------------------


def packed_orbits(
    ds: xr.Dataset,
    chosen: Numbers,
    *,
    workers: int | None = None,
    on_motion: Callable[[], None] = lambda: None,
) -> tuple[list[ColumnDataSource], list[dict[str, Any]]]:
    """Return the motions at some points, and what the script needs to know of each of them.

    `chosen` are the numbers of the points in C order. The last source has the number of the nearest
    orbit for every point of the result.
    """
    if not chosen.size:
        return [], []
    sources, about = [], []
    found = motions(ds, places_of(ds, chosen), workers=workers, on_motion=on_motion)
    for number, motion in enumerate(found):
        about.append(
            {
                "point": int(chosen[number]),
                "words": _words(motion),
                "drawn": motion.courses is not None,
                "periods": drive_periods(motion.courses),
            }
        )
        if motion.courses is not None:
            columns = columns_of(motion.courses)
            kept = thinned(np.stack([*columns.values()]))
            thin = {name: np.float32(column[kept]) for name, column in columns.items()}
            sources.append(ColumnDataSource(thin, name=f"orbit {number}"))
    nearest = {"values": nearest_chosen(ds, chosen)}
    return [*sources, ColumnDataSource(nearest, name="values of nearest orbit")], about


def _words(motion: Motion) -> str:
    """Return sentences on a motion, as HTML: the time over which it is drawn, and its status."""
    status = motion.point.status
    repeats = bool(motion.obstacle) and status.sentence.endswith(motion.obstacle)
    words = f"<span>{escape(_sentence(motion))}</span>"
    if status is Status.OK or repeats:
        return words
    return f"{words}<em>{escape(code_name('status', status))}: {escape(status.sentence)}</em>"


def _sentence(motion: Motion) -> str:
    if motion.courses is None:
        return f"The motion cannot be followed: {motion.obstacle}"
    periods = counted(round(drive_periods(motion.courses)), "drive period")
    status = motion.point.orbit().status
    if not status.is_result:
        return f"There is no stationary orbit: {periods} from the initial state are drawn."
    if status is Status.APERIODIC:
        return f"The orbit does not close: {periods} of it are drawn."
    return f"The stationary orbit, which closes after {periods}."


def thinned(
    columns: NDArray[np.float64], tolerance: float = 1e-3, most: int = 6000
) -> NDArray[np.int64]:
    """Return the indices of samples between which straight lines reproduce the columns (m, n).

    The error of a column does not exceed `tolerance` of its range, unless that takes more than
    about `most` samples. The first column, the time, is the abscissa.
    """
    across, heights = columns[0], columns[1:]
    spans = np.ptp(heights, axis=1)
    heights = heights / np.where(spans > 0, spans, 1.0)[:, None]
    kept = np.union1d([0, across.size - 1], [heights.argmin(1), heights.argmax(1)])
    while kept.size < most:
        drawn = np.stack([np.interp(across, across[kept], height[kept]) for height in heights])
        missed = np.abs(heights - drawn).max(axis=0)
        # The sample with the largest error in each gap that has samples inside.
        wide = np.diff(kept) > 1
        gaps = zip(kept[:-1][wide] + 1, kept[1:][wide], strict=True)
        worst = np.array([b + missed[b:e].argmax() for b, e in gaps], dtype=np.int64)
        worst = worst[missed[worst] > tolerance]
        if not worst.size:
            break
        kept = np.union1d(kept, worst)
    return kept
