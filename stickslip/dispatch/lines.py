"""Lines along a followed axis, on which each point starts from the orbit of the one before.

A line goes up the axis from the config's start, and then down again from the last orbit. After a
point without a result it goes on from the last orbit that was found.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from stickslip.kernels.parameter_rows import final_columns
from stickslip.keys import keys_of_lines, secret_of
from stickslip.measure.results import STATUS
from stickslip.options import Options
from stickslip.orbit import compute_orbits
from stickslip.status import Status
from stickslip.variables import RESULT_COLUMNS

Indices = NDArray[np.int64]

_RESULTS = [status for status in Status if status.is_result]

# Enough lines to keep the lanes of a kernel busy; more would only come back later.
_MOST_LINES = 16

KNOWN: dict[bytes, NDArray[np.float64]] = {}
"""The states that `start_after` has computed, by the key of the line up to each of them."""

MOST_KNOWN = 20_000  # a few MB


class Lines:
    """Cuts the lines that are not done into blocks of a few, with the interface of `Blocks`.

    `lines` (lines, points) are the numbers of their points. If a point of a line is missing, the
    whole line is computed, because each point needs the one before.
    """

    defers: ClassVar[bool] = False

    def __init__(self, lines: Indices, done: NDArray[np.bool_], slots: int) -> None:
        self.line = lines.shape[1]
        self._lines = lines[~done[lines].all(axis=1)]
        self._at_once = max(1, min(_MOST_LINES, -(-len(self._lines) // slots)))

    def __iter__(self) -> Iterator[Indices]:
        for first in range(0, len(self._lines), self._at_once):
            yield self._lines[first : first + self._at_once].ravel()

    def learn(self, points: int, seconds: float) -> None:
        """Do nothing, as the size of a block does not depend on the cost of others."""


def follow(points: NDArray[np.float64], line: int, options: Options) -> NDArray[np.float64]:
    """Return the result rows (n, columns) of points (n, parameters) that form whole lines."""
    lines = points.reshape(-1, line, points.shape[-1])
    rows = np.stack([rows for rows, _ in _followed(lines, options)], axis=1)
    return rows.reshape(-1, len(RESULT_COLUMNS))


def start_after(points: NDArray[np.float64], options: Options) -> NDArray[np.float64]:
    """Return the state (final columns,) from which the next point of a line starts.

    `points` (n, parameters) are the points of the line before it. Without any the state is NaN, for
    the config's start. The states along a line are remembered, so each is computed only once.
    """
    state, keys = np.full(len(final_columns(options.physics)), np.nan), _keys(points, options)
    known = 0
    for n, key in enumerate(keys, start=1):
        if (found := KNOWN.get(key)) is not None:  # another thread may clear them meanwhile
            known, state = n, found
    if len(KNOWN) > MOST_KNOWN:
        KNOWN.clear()
    followed = _followed(points[None, known:], options, state[None])
    for key, (_, states) in zip(keys[known:], followed, strict=True):
        state = KNOWN[key] = states[0]
    return state


def remember_starts(lines: Sequence[NDArray[np.float64]], options: Options) -> None:
    """Compute the states along lines of points (n, parameters), in batches for `start_after`."""
    for first in range(0, len(lines), _MOST_LINES):
        some = lines[first : first + _MOST_LINES]
        longest = max(map(len, some))
        # A shorter line repeats its last point, whose results are not used.
        filled = [np.pad(line, ((0, longest - len(line)), (0, 0)), "edge") for line in some]
        along = [states for _, states in _followed(np.stack(filled), options)]
        for number, line in enumerate(some):
            for key, states in zip(_keys(line, options), along, strict=False):
                KNOWN[key] = states[number]


def _keys(points: NDArray[np.float64], options: Options) -> list[bytes]:
    """Return a key for each point (n, parameters), which identifies its line up to that point."""
    (keys,) = keys_of_lines(points[None], secret_of(repr(options)))
    return [key.tobytes() for key in keys]


def _followed(
    lines: NDArray[np.float64], options: Options, states: NDArray[np.float64] | None = None
) -> Iterator[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Yield result rows and states, point by point along lines (lines, points, parameters).

    The next points start from these states (lines, final columns). The first points start from the
    `states` given, by default from the config's start.
    """
    if states is None:
        states = np.full((len(lines), len(final_columns(options.physics))), np.nan)
    for points in np.moveaxis(lines, 1, 0):
        rows, finals = compute_orbits(points, options, states)
        settled = np.isin(rows[:, STATUS], _RESULTS)
        states = np.where(settled[:, None], finals, states)
        yield rows, states
