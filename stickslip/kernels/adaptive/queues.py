"""Queues of points on their way through the lanes."""

from __future__ import annotations

from typing import Any

import numpy as np

from stickslip.kernels.adaptive.conversion import conversion_of
from stickslip.kernels.adaptive.passes import (
    OUTCOME,
    Lanes,
    Pass,
    Queue,
    fresh_control,
    new_lanes,
    new_queue,
    pass_kernel,
)
from stickslip.kernels.families import KIND, families
from stickslip.kernels.interruption import check_interruption
from stickslip.model.models import model_of
from stickslip.model.scaling import Reduced
from stickslip.numerics.adaptive import OK
from stickslip.options import Physics

KINDS = [Reduced._fields.index(name) for name in KIND]
"""The columns of `families.KIND` among reduced parameters."""

# Attempts of all lanes together in one call of a kernel: about a second, so that Ctrl-C is noticed.
_WORK = 2_000_000


def reduced_queue(points: np.ndarray, physics: Physics) -> Queue:
    """Return a queue of points (n, parameters) from SI units, in their own, at their starts."""
    n = len(points)
    width = model_of(physics).width
    queue = new_queue(np.empty((n, len(Reduced._fields))), np.empty((n, width + 1)))
    conversion_of(physics).reduce_points(points, queue.points, queue.states)
    return queue


def part_of(queue: Queue, rows: np.ndarray) -> Queue:
    """Return a copy of these rows (m,) of a queue."""
    return Queue(*(column[rows] for column in queue))


def put_back(queue: tuple[np.ndarray, ...], rows: np.ndarray, part: tuple[np.ndarray, ...]) -> None:
    """Write a copy of some rows (m,) back into a queue, or into other columns of points."""
    for whole, piece in zip(queue, part, strict=True):
        whole[rows] = piece


def work_through(
    queue: Queue, mode: int, rtol: float, max_steps: int, physics: Physics, halves: int = 0
) -> None:
    """Take the points of a queue that are still ok through a pass at a tolerance.

    As many half periods as its cycle has for each, or `halves` for all, in at most `max_steps`.
    """
    alive, task = np.flatnonzero(queue.counts[:, OUTCOME] == OK), Pass(mode, halves, max_steps)
    queue.rtols[alive], queue.control[alive] = rtol, fresh_control(len(alive))
    lanes = new_lanes(queue.states.shape[1] - 1)
    for family, members in families(physics, queue.points[:, KINDS][alive]):
        take_through(pass_kernel(family), queue, alive[members], lanes, task)


def take_through(kernel: Any, queue: Queue, which: np.ndarray, lanes: Lanes, task: Pass) -> None:
    """Take the points in the rows `which` (m,), all of one family, through a pass in lanes."""
    lanes.rows[:], lanes.cursor[:] = -1, (0, -1)
    while kernel(queue, which, lanes, task, _WORK) > 0:
        check_interruption()
