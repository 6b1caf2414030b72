"""Crossings of borders with the edges of a map, bisected side by side, and joined into lines.

A map has one axis or two. Its edges join neighbours along an axis; a border crosses an edge where
the kind changes along it. Kinds are whole numbers, `NO_KIND` for none; their meaning does not
matter here.

Crossings are joined cell by cell, by marching squares for many kinds. A cell lies between two
neighbouring values of each axis. We walk along its rim counter-clockwise, with the first axis
pointing right and the second up; crossings cut the rim into stretches of one kind each. Two
crossings are joined; three or more meet in their middle if each kind occurs once. If a kind occurs
twice, as in a saddle, the kind at the cell's centre fills a band through the cell, which cuts off
what lies on either side.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Kinds = NDArray[np.int64]
Cell = tuple[int, int]

NO_KIND = -1


@dataclass(frozen=True)
class Axis:
    """The values of an axis, increasing; bisected geometrically where it is `geometric`."""

    values: Floats
    geometric: bool = False

    def middles(self, low: Floats, high: Floats) -> Floats:
        """Return the midpoints between values, on the axis's own scale."""
        return np.asarray(np.sqrt(low * high) if self.geometric else low + 0.5 * (high - low))

    def parts(self, low: Floats, high: Floats) -> Floats:
        """Return the distances between values as parts of the axis's length, on its own scale."""
        first, last = self.values[0], self.values[-1]
        if self.geometric:
            return np.asarray(np.log(high / low) / np.log(last / first))
        return np.asarray((high - low) / (last - first))


@dataclass(frozen=True)
class Crossings:
    """Where borders cross the edges of a map: a bracket for each, (n,) of them.

    Attributes
    ----------
    axis
        The axis (n,) along which the edge lies.
    corner
        The indices (n, axes) of the edge's lower end.
    low, high
        The ends (n, axes) of the bracket.
    kinds, numbers
        The kinds (n, 2) of the two ends, and a number of each end, which is only passed on.
    """

    axis: NDArray[np.int64]
    corner: NDArray[np.int64]
    low: Floats
    high: Floats
    kinds: Kinds
    numbers: Floats

    def __len__(self) -> int:
        return len(self.axis)

    def part(self, which: NDArray[np.bool_] | NDArray[np.int64] | slice) -> Crossings:
        """Return some of the crossings."""
        return Crossings(*(getattr(self, field.name)[which] for field in fields(self)))

    @staticmethod
    def joined(parts: Sequence[Crossings]) -> Crossings:
        """Return the crossings of several parts together."""
        names = [field.name for field in fields(Crossings)]
        return Crossings(*(np.concatenate([getattr(p, name) for p in parts]) for name in names))

    def places(self, axes: Sequence[Axis]) -> Floats:
        """Return the middles (n, axes) of the brackets."""
        columns = zip(axes, self.low.T, self.high.T, strict=True)
        middles = [axis.middles(low, high) for axis, low, high in columns]
        # The root of a square may miss the value of a grid line by its last bit.
        return np.where(self.low == self.high, self.low, np.column_stack(middles))

    def widths(self, axes: Sequence[Axis]) -> Floats:
        """Return the widths (n,) of the brackets as parts of the length of their axis."""
        columns = zip(axes, self.low.T, self.high.T, strict=True)
        return np.asarray(np.max([a.parts(low, high) for a, low, high in columns], axis=0))

    def are_narrow(self, axes: Sequence[Axis], accuracy: float) -> NDArray[np.bool_]:
        """Return which brackets (n,) are as narrow as `accuracy`, or as floats allow."""
        middles = self.places(axes)
        between = ((middles != self.low) & (middles != self.high)).any(axis=1)
        return np.asarray((self.widths(axes) <= accuracy) | ~between)


class Bisection:
    """The bisection of all edges of a map that borders cross, into brackets of at most `accuracy`.

    `kinds` and `numbers` have the shape of the map, `accuracy` is a fraction of the length of an
    axis. The middles of brackets are numbered from 0; the final brackets do not depend on the order
    in which the kinds of middles become known. A middle of a third kind splits an edge in two. A
    middle without a kind ends the bisection of its edge, whose bracket stays wide. Brackets no
    wider than `pause` wait for `resume`.
    """

    def __init__(
        self,
        axes: Sequence[Axis],
        kinds: Kinds,
        numbers: Floats,
        accuracy: float,
        pause: float = 0.0,
    ) -> None:
        self._axes, self._accuracy, self._pause = axes, accuracy, pause
        edges = _unlike_edges(axes, kinds, numbers)
        self._brackets = self._waiting = edges.part(slice(0))
        self._found = [self._brackets]
        self._halvings = np.zeros(0, dtype=np.int64)  # that each bracket still needs, at least
        self._goes_on(edges)

    def __len__(self) -> int:
        """Return the number of middles so far."""
        return len(self._brackets)

    @property
    def left(self) -> int:
        """The number of middles still to be found, apart from edges that will be split."""
        return int(self._halvings.sum() + self._halvings_of(self._waiting).sum())

    def middles(self, first: int) -> Floats:
        """Return the middles (n, axes) from number `first` on."""
        return self._brackets.part(slice(first, None)).places(self._axes)

    def take_in(self, which: NDArray[np.int64], kinds: Kinds, numbers: Floats) -> None:
        """Take in the kinds (n,) of the middles `which` (n,); new middles may follow."""
        brackets = self._brackets.part(which)
        known = kinds != NO_KIND
        self._halvings[which] = 0
        self._found.append(brackets.part(~known))
        brackets = brackets.part(known)
        middles = brackets.places(self._axes)
        self._goes_on(_halved(brackets, middles, kinds[known], numbers[known]))

    def resume(self) -> None:
        """Continue with the waiting brackets; new middles may follow."""
        waiting, self._pause = self._waiting, 0.0
        self._waiting = waiting.part(slice(0))
        self._goes_on(waiting)

    def crossings(self) -> Crossings:
        """Return the crossings of borders with edges, sorted by edge and by place on it."""
        found = Crossings.joined(self._found)
        order = np.lexsort((*found.low.T, *found.corner.T, found.axis))
        return found.part(order)

    def _goes_on(self, brackets: Crossings) -> None:
        """Keep narrow brackets, let those below `pause` wait, and bisect the others."""
        narrow = brackets.are_narrow(self._axes, self._accuracy)
        waits = ~narrow & (brackets.widths(self._axes) <= self._pause)
        self._found.append(brackets.part(narrow))
        self._waiting = Crossings.joined([self._waiting, brackets.part(waits)])
        wide = brackets.part(~narrow & ~waits)
        self._brackets = Crossings.joined([self._brackets, wide])
        self._halvings = np.concatenate([self._halvings, self._halvings_of(wide)])

    def _halvings_of(self, wide: Crossings) -> NDArray[np.int64]:
        """Return how often brackets (n,) must at least be halved."""
        ratios = np.maximum(wide.widths(self._axes) / self._accuracy, 2.0)
        return np.ceil(np.log2(ratios)).astype(np.int64)


def _unlike_edges(axes: Sequence[Axis], kinds: Kinds, numbers: Floats) -> Crossings:
    """Return every edge between neighbours of different kinds as a bracket."""
    edges = []
    for axis in range(kinds.ndim):
        length = kinds.shape[axis]
        low, high = np.arange(length - 1), np.arange(1, length)
        ends = np.stack([kinds.take(low, axis), kinds.take(high, axis)], axis=-1)
        values = np.stack([numbers.take(low, axis), numbers.take(high, axis)], axis=-1)
        unlike = (ends[..., 0] != ends[..., 1]) & (ends != NO_KIND).all(axis=-1)
        corner = np.argwhere(unlike)
        other = corner + np.eye(kinds.ndim, dtype=np.int64)[axis]
        bracket = [
            np.column_stack([a.values[i] for a, i in zip(axes, end.T, strict=True)])
            for end in (corner, other)
        ]
        along = np.full(len(corner), axis)
        edges.append(Crossings(along, corner, bracket[0], bracket[1], ends[unlike], values[unlike]))
    return Crossings.joined(edges)


def _halved(brackets: Crossings, middles: Floats, kinds: Kinds, numbers: Floats) -> Crossings:
    """Return the halves of brackets in which the kind changes: one of each bracket, or both."""
    (first, last), (first_number, last_number) = brackets.kinds.T, brackets.numbers.T
    lower = replace(
        brackets,
        high=middles,
        kinds=np.column_stack([first, kinds]),
        numbers=np.column_stack([first_number, numbers]),
    )
    upper = replace(
        brackets,
        low=middles,
        kinds=np.column_stack([kinds, last]),
        numbers=np.column_stack([numbers, last_number]),
    )
    both = Crossings.joined([lower, upper])
    return both.part(both.kinds[:, 0] != both.kinds[:, 1])


class Cut(NamedTuple):
    """A crossing on the rim of a cell: its number, and the kinds before and after it."""

    crossing: int
    before: int
    after: int


class Line(NamedTuple):
    """Points in order, with the lower-numbered kind on the left and the other on the right.

    Numbers below the number of crossings are crossings; the others are meeting points. A closed
    line ends with its first point.
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
        """The same piece with the lower kind on the left."""
        if self.left <= self.right:
            return self
        return Piece(self.end, self.begin, self.right, self.left)


class Rims:
    """The rims of the cells that borders cross, and the lines within them; one axis has no cells.

    `kinds` has the shape of the map; `places` (n, axes) are the places of its crossings.
    """

    def __init__(self, kinds: Kinds, found: Crossings, places: Floats) -> None:
        corners = found.corner
        if kinds.ndim == 1:
            kinds, corners = kinds[:, None], np.pad(corners, [(0, 0), (0, 1)])
        along = np.take_along_axis(places, found.axis[:, None], axis=1)[:, 0]
        self._edges: dict[tuple[int, int, int], list[Cut]] = defaultdict(list)
        for crossing in np.argsort(along, kind="stable").tolist():
            i, j = corners[crossing].tolist()
            cut = Cut(crossing, *found.kinds[crossing].tolist())
            self._edges[int(found.axis[crossing]), i, j].append(cut)
        whole = kinds != NO_KIND
        self._whole = whole[:-1, :-1] & whole[1:, :-1] & whole[:-1, 1:] & whole[1:, 1:]
        self._count = len(found)

    def cells(self) -> list[Cell]:
        """Return the cells that borders cross, if each corner has a kind, in order."""
        beside = {
            cell
            for axis, i, j in self._edges
            for cell in ((i, j), (i - (axis == 1), j - (axis == 0)))
        }
        rows, columns = self._whole.shape
        inside = (c for c in sorted(beside) if 0 <= c[0] < rows and 0 <= c[1] < columns)
        return [cell for cell in inside if self._whole[cell]]

    def doubtful(self) -> list[Cell]:
        """Return the cells on whose rim a kind occurs twice: their centres decide."""
        return [cell for cell in self.cells() if _repeated(self._rim(cell)) is not None]

    def lines(self, centres: Mapping[Cell, int]) -> tuple[list[Line], list[list[int]]]:
        """Return the lines, and the crossings that meet in each meeting point.

        `centres` has the kind at the centre of each doubtful cell, if it has one.
        """
        pieces: list[Piece] = []
        meetings: list[list[int]] = []
        for cell in self.cells():
            for group in _groups(self._rim(cell), centres.get(cell)):
                if len(group) == 2:  # on the way across, the kind after the first is on the right
                    first, second = group
                    across = Piece(first.crossing, second.crossing, first.before, first.after)
                    pieces.append(across.directed)
                    continue
                meeting = self._count + len(meetings)  # inward, `before` is on the left
                inward = [Piece(cut.crossing, meeting, cut.before, cut.after) for cut in group]
                pieces += [piece.directed for piece in inward]
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
    """Return the first kind with several stretches on a rim, None if there is none."""
    kinds = [cut.before for cut in rim]
    return next((kind for kind in kinds if kinds.count(kind) > 1), None)


def _groups(rim: list[Cut], centre: int | None) -> Iterator[list[Cut]]:
    """Yield the groups of crossings to join with each other.

    Stretches of the centre's kind form one region, which separates the others; another kind that
    still has two stretches forms one region too. If the rim lacks the centre's kind, all crossings
    meet.
    """
    starts = [place for place, cut in enumerate(rim) if cut.before == centre]
    if _repeated(rim) is None or not starts:
        yield rim
        return
    for start, stop in zip(starts, [*starts[1:], starts[0] + len(rim)], strict=True):
        group = [rim[place % len(rim)] for place in range(start, stop)]
        yield from _groups(group, _repeated(group))


def _chained(pieces: Sequence[Piece]) -> list[Line]:
    """Return pieces joined end to end as lines, which end where three or more meet."""
    degree = Counter(point for piece in pieces for point in (piece.begin, piece.end))
    follows = {piece.begin: piece for piece in pieces if degree[piece.begin] == 2}
    open_ends = [piece for piece in pieces if piece.begin not in follows]
    lines: list[Line] = []
    used: set[Piece] = set()
    for first in [*open_ends, *pieces]:  # pieces left after the open lines form closed ones
        points, piece = [first.begin], first
        while piece not in used:
            used.add(piece)
            points.append(piece.end)
            piece = follows.get(piece.end, piece)
        if len(points) > 1:
            lines.append(Line(points, (first.left, first.right)))
    return lines
