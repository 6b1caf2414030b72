"""Refinement: axes computed coarsely first, then finer only where it matters.

The refined axes are cut into cells of 2^levels steps. The corners and the middle of each cell are
computed; if they disagree, the cell is halved along each axis, down to single steps. The remaining
points are interpolated. A cell is judged again whenever a neighbour has computed a value on its
border.

Which points are computed depends only on the values computed before, round by round: not on how the
rounds were cut into blocks, nor on interruptions.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.model.drive import full_forces
from stickslip.parameters import Parameters
from stickslip.status import Status
from stickslip.variables import RESULT_COLUMNS, RESULTS
from sweeps.config.load import Config
from sweeps.config.refinement import Refine
from sweeps.files.journal import Journal
from sweeps.files.result_rows import Memory
from sweeps.grid import Grid

Floats = NDArray[np.float64]
Rows = Floats
Kinds = NDArray[np.int64]
Mask = NDArray[np.bool_]
Corners = dict[tuple[int, ...], Floats]
"""Values at the corners of each cell, keyed by the end of each axis, 0 or 1."""

# The columns that distinguish kinds of motion, with more bits than each needs.
_KINDS = {
    RESULT_COLUMNS.index(name): bits
    for name, bits in (("status", 8), ("regime", 8), ("orbit_periods", 16), ("melting_count", 31))
}
_AREA = Parameters._fields.index("contact_area")
_AMPLITUDES = [
    RESULT_COLUMNS.index(n) for n in ("elastic_stress_amplitude", "friction_force_amplitude")
]
_EXTREMA = [
    [RESULT_COLUMNS.index(f"{n}_{end}") for end in ("max", "min")]
    for n in ("elastic_stress", "friction_force")
]
_STATUS, _ERROR, _PERIODS = (
    RESULT_COLUMNS.index(n) for n in ("status", "amplitude_error", "periods_integrated")
)
# Columns of quantities that have their own error, and of these errors, in the same unit.
_STATED = [
    (RESULT_COLUMNS.index(n), RESULT_COLUMNS.index(f"{n}_error"))
    for n in RESULT_COLUMNS
    if f"{n}_error" in RESULTS
]
_COUNTED = [i for i, n in enumerate(RESULT_COLUMNS) if RESULTS[n].dtype != "f8"]
_GOOD = [status for status in Status if status.is_result]

_NO_RESULT = -1  # the kind of a point without a result

# Errors of an amplitude below this fraction of the springs' full force are relative to that
# fraction, as in `amplitude_error`.
_FLOOR = 0.01

# The error of an interpolated value, in units of the largest miss of its cell and its neighbours: a
# middle can be right by accident, and a cell may miss more elsewhere than in its middle.
_SAFETY = 3.0


@dataclass
class _Level:
    """The cells of one size, with `stride` steps a side.

    The arrays have the shape (slices, cells along each axis): `active` cells exist on this level,
    `cut` cells are halved; `misses` is the largest miss of interpolation at a computed value in the
    cell, as a fraction of the amplitude.
    """

    stride: int
    active: Mask
    cut: Mask
    misses: Floats


class Refinement:
    """Chooses the points of a grid to compute, and interpolates the others."""

    def __init__(self, refine: Refine, grid: Grid) -> None:
        axes = [grid.dims.index(name) for name in refine.axes]
        inner = tuple(grid.shape[axis] for axis in axes)
        moved = np.moveaxis(np.arange(grid.size).reshape(grid.shape), axes, range(-len(axes), 0))
        self._numbers = moved.reshape(-1, *inner)
        self._chosen = np.zeros(self._numbers.shape, dtype=bool)
        self._limit = np.inf if refine.miss is None else refine.miss
        self._floors = _floors(grid)[self._numbers]
        self._levels = []
        for stride in (2**level for level in range(refine.levels + 1)):
            cells = (len(self._numbers), *((length - 1) // stride for length in inner))
            new = np.zeros(cells, bool), np.zeros(cells, bool), np.zeros(cells)
            self._levels.append(_Level(stride, *new))
        self._levels[-1].active[:] = True

    def rounds(self, rows_of: Callable[[], Rows]) -> Iterator[Mask]:
        """Yield the points (size,) that each round needs; `rows_of` returns the rows so far.

        Rows (size, columns) are NaN for points not computed yet. A round ends when all points that
        it needs are computed.
        """
        while True:
            needed = self.needed()
            rows = rows_of()
            if np.isnan(rows[needed, _STATUS]).any():
                yield needed
                rows = rows_of()
            if np.isnan(rows[needed, _STATUS]).any() or not self._cut(rows):
                return

    def needed(self) -> Mask:
        """Return the points (size,) known to be needed, at first the coarse ones."""
        self._choose()
        needed = np.zeros(self._numbers.size, dtype=bool)
        needed[self._numbers[self._chosen]] = True
        return needed

    def interpolated(self, rows: Rows) -> tuple[NDArray[np.int64], Rows]:
        """Return the interpolated points: their numbers (n,) and rows (n, columns)."""
        known = ~np.isnan(rows[:, _STATUS])[self._numbers]
        filled = rows[self._numbers]
        for level in reversed(self._levels[1:]):
            self._fill(level, filled)
        missing = ~known
        return self._numbers[missing], filled[missing]

    # --- which points ---

    def _choose(self) -> None:
        """Choose the corners and the middle of each active cell."""
        for level in self._levels:
            half = level.stride // 2
            offsets = list(itertools.product((0, level.stride), repeat=self._axes))
            for offset in [*offsets, *([(half,) * self._axes] if half else [])]:
                self._chosen[self._at(level, offset)] |= level.active

    def _cut(self, rows: Rows) -> bool:
        """Cut the cells whose values disagree; return whether there were any."""
        kinds, amplitudes = self._kinds(rows), rows[:, _AMPLITUDES][self._numbers]
        cut = [self._judge(level, kinds, amplitudes) for level in self._levels[1:]]
        for finer, level, new in zip(self._levels, self._levels[1:], cut, strict=False):
            level.cut |= new
            halves = new
            for axis in range(1, halves.ndim):
                halves = halves.repeat(2, axis=axis)
            finer.active |= halves
        return any(new.any() for new in cut)

    def _kinds(self, rows: Rows) -> Kinds:
        """Return the kinds of motion as numbers, `_NO_RESULT` for points without a result."""
        good, kinds = np.isin(rows[:, _STATUS], _GOOD), np.zeros(len(rows), dtype=np.int64)
        for column, bits in _KINDS.items():
            kinds = (kinds << bits) + np.where(good, rows[:, column], 0).astype(np.int64)
        return np.where(good, kinds, _NO_RESULT)[self._numbers]

    def _judge(self, level: _Level, kinds: Kinds, amplitudes: Floats) -> Mask:
        """Return the cells of a level to cut now, and note how far interpolation is off there."""
        whole = level.active & ~level.cut
        own = kinds[self._at(level, (0,) * self._axes)]
        bad = own == _NO_RESULT
        level.misses[:] = 0.0
        corners = self._corners(level, amplitudes)
        for offset in itertools.product(range(level.stride + 1), repeat=self._axes):
            place = self._at(level, offset)
            computed = self._chosen[place] & whole
            if not computed.any():
                continue
            bad |= computed & (kinds[place] != own)
            expected = _blend(corners, offset, level.stride)
            miss = _part(amplitudes[place] - expected, amplitudes[place], self._floors[place])
            np.maximum(level.misses, np.where(computed, miss, 0.0), out=level.misses)
        return np.asarray(whole & (bad | (level.misses > self._limit)))

    # --- interpolated points ---

    def _fill(self, level: _Level, filled: Rows) -> None:
        """Interpolate within the whole cells of a level; finer levels overwrite it later."""
        whole = level.active & ~level.cut
        if not whole.any():
            return
        corners = _one_way_round(self._corners(level, filled))
        error = np.max([corner[..., _ERROR] for corner in corners.values()], axis=0)
        error = error + _SAFETY * _around(np.where(whole, level.misses, 0.0))
        first = next(iter(corners.values()))
        own = [_range_and_error(corners, value, column) for value, column in _STATED]
        for offset in itertools.product(range(level.stride + 1), repeat=self._axes):
            place = self._at(level, offset)
            missing = whole & ~self._chosen[place]
            if not missing.any():
                continue
            values = _blend(corners, offset, level.stride)
            values[..., _COUNTED] = first[..., _COUNTED]
            values[..., _ERROR] = error
            for (_, column), stated in zip(_STATED, own, strict=True):
                values[..., column] = stated
            values[..., _STATUS], values[..., _PERIODS] = Status.INTERPOLATED, 0.0
            target = filled[place]  # a view
            target[missing] = values[missing]

    # --- places ---

    @property
    def _axes(self) -> int:
        return self._numbers.ndim - 1

    def _at(self, level: _Level, offset: tuple[int, ...]) -> tuple[slice, ...]:
        """Return an index of the points at this offset from the first corner of each cell."""
        cells = zip(offset, level.active.shape[1:], strict=True)
        s = level.stride
        return (slice(None), *(slice(o, o + s * (n - 1) + 1, s) for o, n in cells))

    def _corners(self, level: _Level, values: Floats) -> Corners:
        """Return the values at the corners of each cell."""
        ends = itertools.product((0, 1), repeat=self._axes)
        return {end: values[self._at(level, tuple(level.stride * e for e in end))] for end in ends}


def refinement_of(refine: Refine | None, grid: Grid) -> Refinement | None:
    """Return the refinement of a grid, None if it is not refined."""
    return Refinement(refine, grid) if refine else None


def interpolate(config: Config, grid: Grid, store: Journal | Memory) -> None:
    """Add the interpolated points of a refined grid to a store with all of its computed points."""
    refinement = refinement_of(config.refine, grid)
    if refinement and not any(True for _ in refinement.rounds(store.rows)):
        store.append(*refinement.interpolated(store.rows()))


def _floors(grid: Grid) -> Floats:
    """Return lower bounds (size, 2) for the amplitudes of stress and force in relative errors."""
    points = grid.points(0, grid.size)
    force = _FLOOR * full_forces(points)
    return np.column_stack([force / points[:, _AREA], force])


def _blend(corners: Corners, offset: tuple[int, ...], stride: int) -> Floats:
    """Return the multilinear interpolation between corners, at an offset from the first one."""
    total = np.zeros_like(next(iter(corners.values())))
    for ends, values in corners.items():
        parts = [o / stride if e else 1.0 - o / stride for o, e in zip(offset, ends, strict=True)]
        if weight := float(np.prod(parts)):
            total += weight * values
    return total


def _range_and_error(corners: Corners, value: int, error: int) -> Floats:
    """Return the error of interpolated values in a column for which no miss is known.

    It is the range of the corner values plus their largest error.
    """
    values, errors = ([corner[..., c] for corner in corners.values()] for c in (value, error))
    return np.asarray(np.ptp(values, axis=0) + np.max(errors, axis=0))


def _part(difference: Floats, value: Floats, floor: Floats) -> Floats:
    """Return the larger relative difference of two amplitudes (..., 2); 0 for NaN."""
    part = np.abs(difference) / np.maximum(np.abs(value), floor)
    return np.asarray(np.nan_to_num(part, nan=0.0).max(axis=-1))


def _one_way_round(corners: Corners) -> Corners:
    """Return the corners, mirrored where needed so that all lean to the side of the first one.

    An asymmetric orbit and its mirror image are the same motion, but an interpolation between the
    two would mean nothing.
    """
    lean = [corner[..., _EXTREMA[0]].sum(axis=-1) for corner in corners.values()]
    turned = {}
    for (ends, corner), own in zip(corners.items(), lean, strict=True):
        other = (own * lean[0] < 0.0)[..., None]
        corner = corner.copy()
        for pair in _EXTREMA:
            corner[..., pair] = np.where(other, -corner[..., pair[::-1]], corner[..., pair])
        turned[ends] = corner
    return turned


def _around(misses: Floats) -> Floats:
    """Return the largest miss of each cell and its neighbours in the same slice."""
    for axis in range(1, misses.ndim):
        padded = np.pad(misses, [(0, 0)] * axis + [(1, 1)] + [(0, 0)] * (misses.ndim - axis - 1))
        sides = [
            np.take(padded, range(shift, shift + misses.shape[axis]), axis) for shift in range(3)
        ]
        misses = np.max(sides, axis=0)
    return misses
