"""The data of many motions, in the units of their points, for searches and marches."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from stickslip.kernels.families import KIND
from stickslip.kernels.orbits.conversion import conversion_of
from stickslip.measure.accumulate import RECORD, SENSITIVE
from stickslip.model.models import model_of
from stickslip.model.scaling import Reduced
from stickslip.numerics import step_control
from stickslip.options import Physics

# The columns of `counts`, integers. HALVES: half periods of the search; CYCLE: half periods after
# which the orbit closes; ATTEMPTED: attempted steps; OUTCOME: a Status; AHEAD: the number of
# applications of the map that a search wants next; DONE: the number of these that were completed.
HALVES, CYCLE, ATTEMPTED, OUTCOME, AHEAD, DONE, COUNT_COLUMNS = range(7)

MOST_AHEAD = 8
"""The largest number of applications of the map before a search judges them."""

GROWS, REMEMBERED, CONTROL = range(3)
"""Columns of `control`: whether the next step may be longer, and the memory of the controller."""

LOWEST, HIGHEST, FILM_COLUMNS = range(3)
"""Columns of `film`."""

DAMPING, FASTEST, RESOLUTION = range(3)
"""The numbers at the end of a row of `varied`: the spurious damping of free oscillations in the
columns, a logarithm, and the fastest rate of these oscillations."""

KINDS = [Reduced._fields.index(name) for name in KIND]
"""The columns of `families.KIND` among the reduced parameters."""


class Motions(NamedTuple):
    """The motions of n points, a row each.

    `points` (n, reduced parameters) are as in `Reduced`, followed by a stream of random numbers if
    the noise is stochastic. `rtols` (n,) are the tolerances, and `longest` (n,) the longest steps.
    `states` (n, width + 1) hold the state in the point's own units and the next step, at phase 0.
    `control` (n, CONTROL) is the step control's state, so a motion taken in pieces has the same
    bits. `counts` are (n, COUNT_COLUMNS). `film` (n, 2) has the lowest and highest ln(phi) of the
    last half period without record. `ahead` (n, MOST_AHEAD, columns) has, in the layout of
    `ahead_of`, the result of each application that is not judged yet. `measured` is (n, RECORD),
    and `ratios` (n,) the contraction of an orbit. `varied` (n, `varied_of(width)`) shows how small
    displacements of the first state change the motion, its extrema and integrals.
    """

    points: np.ndarray
    rtols: np.ndarray
    longest: np.ndarray
    states: np.ndarray
    control: np.ndarray
    counts: np.ndarray
    film: np.ndarray
    ahead: np.ndarray
    measured: np.ndarray
    ratios: np.ndarray
    varied: np.ndarray

    @property
    def width(self) -> int:
        """Number of state variables."""
        return self.states.shape[1] - 1


def ahead_of(width: int) -> int:
    """Return the length of a row of `ahead`: rows of `states`, `control`, `film`, and attempts."""
    return width + 1 + CONTROL + FILM_COLUMNS + 1


def varied_of(width: int) -> int:
    """Return the length of a row of `varied`: a column for each component, then their slopes.

    The last two numbers are `DAMPING` and `FASTEST`, which say how well the columns are resolved.
    """
    return (width + len(SENSITIVE)) * width + RESOLUTION


def new_motions(points: np.ndarray, states: np.ndarray) -> Motions:
    """Return the motions of points (n, reduced parameters) in these states (n, width + 1)."""
    n, width = len(points), states.shape[1] - 1
    return Motions(
        points,
        np.zeros(n),
        np.full(n, np.inf),
        states,
        control=fresh_control(n),
        counts=np.zeros((n, COUNT_COLUMNS), np.int64),
        film=np.zeros((n, FILM_COLUMNS)),
        ahead=np.zeros((n, MOST_AHEAD, ahead_of(width))),
        measured=np.zeros((n, RECORD)),
        ratios=np.zeros(n),
        varied=np.zeros((n, varied_of(width))),
    )


def fresh_control(n: int) -> np.ndarray:
    """Return the `control` (n, CONTROL) of new motions."""
    return np.tile((1.0, step_control.START), (n, 1))


def motions_of(points: np.ndarray, physics: Physics, starts: np.ndarray | None = None) -> Motions:
    """Return the motions of points (n, parameters) in SI units, at their starts.

    `starts` (n, columns), in the layout of finals, are other states to begin in; a row of NaN
    stands for the start of the point.
    """
    n, width = len(points), model_of(physics).width
    motions = new_motions(np.empty((n, len(Reduced._fields))), np.empty((n, width + 1)))
    conversion_of(physics).reduce_points(points, motions.points, motions.states)
    if starts is not None:
        rows = np.flatnonzero(~np.isnan(starts[:, 0]))
        states = starts[rows].copy()
        conversion_of(physics).scale_states(points[rows], states)
        motions.states[rows, :-1] = states[:, :-1]  # the first step stays short
    return motions


def part_of(motions: Motions, rows: np.ndarray) -> Motions:
    """Return a copy of these rows (m,)."""
    return Motions(*(column[rows] for column in motions))


def put_back(
    motions: tuple[np.ndarray, ...], rows: np.ndarray, part: tuple[np.ndarray, ...]
) -> None:
    """Write a part with these rows (m,) back into motions, or into other columns of points."""
    for whole, piece in zip(motions, part, strict=True):
        whole[rows] = piece
