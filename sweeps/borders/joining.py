"""Crossings of the edges of a grid, joined cell by cell to lines: marching squares of many kinds.

A cell lies between two values of each axis. Its rim is walked counter-clockwise, the first axis
pointing right and the second up, and is cut by crossings into stretches of one kind each. Two
crossings are joined; three or more between kinds that occur once each meet in their middle. Where a
kind occurs twice, as in a saddle, the kind of the cell's centre goes through the cell, and what
lies on either side of it is cut off.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Cell = tuple[int, int]


class Cut(NamedTuple):
    """A crossing on the rim of a cell: its number, and the kinds before and after it."""

    crossing: int
    before: int
    after: int


class Line(NamedTuple):
    """Points in order, with the kind of the lower number on the left and the other on the right.

    Points below the number of crossings are these; the others are meeting points. A closed line
    ends with its first point.
    """

    points: list[int]
    kinds: tuple[int, int]


class Piece(NamedTuple):
    """A part of a line, from point to point, with a kind on either side."""

    begin: int
    end: int
    left: int
    right: int

    @property
    def directed(self) -> Piece:
        """The same with the lower kind on the left."""
        if self.left <= self.right:
            return self
        return Piece(self.end, self.begin, self.right, self.left)


class Rims:
    """The rims of the cells that borders cross, and the lines within them.

    Parameters
    ----------
    kinds
        Kinds at the points of the grid, (n, m); `no_kind` where there is none.
    axis, corner, ends, order
        Of each crossing, (c,) of them: the axis along which its edge lies, the indices (c, 2) of
        the edge's lower end, the kinds (c, 2) toward lower and higher indices, and a number that
        rises along the edge.
    """

    def __init__(
        self,
        kinds: NDArray[np.int64],
        axis: NDArray[np.int64],
        corner: NDArray[np.int64],
        ends: NDArray[np.int64],
        order: NDArray[np.float64],
        no_kind: int,
    ) -> None:
        self._edges: dict[tuple[int, int, int], list[Cut]] = defaultdict(list)
        for crossing in np.argsort(order, kind="stable").tolist():
            i, j = corner[crossing].tolist()
            cut = Cut(crossing, *ends[crossing].tolist())
            self._edges[int(axis[crossing]), i, j].append(cut)
        whole = kinds != no_kind
        self._whole = whole[:-1, :-1] & whole[1:, :-1] & whole[:-1, 1:] & whole[1:, 1:]
        self._count = len(axis)

    def cells(self) -> list[Cell]:
        """Return the cells that are crossed and have a kind at each corner, in order."""
        beside = {
            cell
            for axis, i, j in self._edges
            for cell in ((i, j), (i - (axis == 1), j - (axis == 0)))
        }
        rows, columns = self._whole.shape
        inside = (c for c in sorted(beside) if 0 <= c[0] < rows and 0 <= c[1] < columns)
        return [cell for cell in inside if self._whole[cell]]

    def doubtful(self) -> list[Cell]:
        """Return the cells in which a kind occurs twice: their centres decide."""
        return [cell for cell in self.cells() if _repeated(self._rim(cell)) is not None]

    def lines(self, centres: Mapping[Cell, int]) -> tuple[list[Line], list[list[int]]]:
        """Return the lines, and of each meeting point the crossings that meet there.

        `centres` has the kind at the centre of each doubtful cell, if any.
        """
        pieces: list[Piece] = []
        meetings: list[list[int]] = []
        for cell in self.cells():
            for group in _groups(self._rim(cell), centres.get(cell)):
                if len(group) == 2:
                    pieces.append(_across(group))
                else:
                    pieces += _meeting(group, self._count + len(meetings))
                    meetings.append([cut.crossing for cut in group])
        alone = {cut.crossing: cut for cuts in self._edges.values() for cut in cuts}
        for piece in pieces:
            alone.pop(piece.begin, None)
            alone.pop(piece.end, None)
        single = [Line([cut.crossing], (cut.before, cut.after)) for cut in alone.values()]
        return [*_chained(pieces), *single], meetings

    def _rim(self, cell: Cell) -> list[Cut]:
        """Return the crossings around a cell, counter-clockwise."""
        i, j = cell
        back = [*reversed(self._edges.get((0, i, j + 1), []))]
        back += reversed(self._edges.get((1, i, j), []))
        return [
            *self._edges.get((0, i, j), []),
            *self._edges.get((1, i + 1, j), []),
            *(Cut(cut.crossing, cut.after, cut.before) for cut in back),
        ]


def _repeated(rim: Sequence[Cut]) -> int | None:
    """Return the first kind that has several stretches of a rim, None if there is none."""
    kinds = [cut.before for cut in rim]
    return next((kind for kind in kinds if kinds.count(kind) > 1), None)


def _groups(rim: list[Cut], centre: int | None) -> Iterator[list[Cut]]:
    """Yield the crossings that are to be joined with each other.

    The stretches of the kind at the centre are one region, which parts the others; where it leaves
    a kind with two stretches, these are one region, too. A centre of a kind that is not on the rim
    decides nothing: all meet.
    """
    starts = [place for place, cut in enumerate(rim) if cut.before == centre]
    if _repeated(rim) is None or not starts:
        yield rim
        return
    for start, stop in zip(starts, [*starts[1:], starts[0] + len(rim)], strict=True):
        group = [rim[place % len(rim)] for place in range(start, stop)]
        yield from _groups(group, _repeated(group))


def _across(group: Sequence[Cut]) -> Piece:
    """Join two crossings: what is after the first of them is on the right on the way across."""
    first, second = group
    return Piece(first.crossing, second.crossing, first.before, first.after).directed


def _meeting(group: Sequence[Cut], point: int) -> list[Piece]:
    """Join crossings with the point in which they meet; inward, `before` is on the left."""
    return [Piece(cut.crossing, point, cut.before, cut.after).directed for cut in group]


def _chained(pieces: Sequence[Piece]) -> list[Line]:
    """Return pieces that follow each other as lines; these end where three or more meet."""
    degree = Counter(point for piece in pieces for point in (piece.begin, piece.end))
    follows = {piece.begin: piece for piece in pieces if degree[piece.begin] == 2}
    open_ends = [piece for piece in pieces if piece.begin not in follows]
    lines: list[Line] = []
    used: set[Piece] = set()
    for first in [*open_ends, *pieces]:  # what is left after the open lines is closed
        points, piece = [first.begin], first
        while piece not in used:
            used.add(piece)
            points.append(piece.end)
            piece = follows.get(piece.end, piece)
        if len(points) > 1:
            lines.append(Line(points, (first.left, first.right)))
    return lines
