"""The estimate of a sweep before it begins: points, blocks, bytes, time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stickslip.dispatch.ask import ask
from stickslip.dispatch.blocks import PILOT_BLOCKS, Costs, Given, pilot_blocks, pilot_points
from stickslip.dispatch.workers import Workers
from stickslip.options import Options
from sweeps.config.load import Config
from sweeps.engine.computing import compile_kernels, order_of
from sweeps.engine.executors import make_executor
from sweeps.engine.existing import Part
from sweeps.engine.progress import SILENT, Compiling
from sweeps.engine.refine import refinement_of
from sweeps.engine.resume import intention
from sweeps.engine.settings import options_of
from sweeps.files.attributes import global_attributes
from sweeps.files.journal import BYTES_PER_POINT
from sweeps.files.sweep_file import most_bytes
from sweeps.grid import Grid

_FEW = 16  # points per block of the first pilot
_MOMENT = 3.0  # seconds that the second pilot may take


@dataclass(frozen=True)
class Plan:
    """The estimated size and time of a sweep.

    `there` of the `points` exist already. The rest takes `seconds` on so many `workers`, without
    compiling, with the relative standard error `uncertainty`. On a refined grid that is the time
    for all points, and `least_seconds` is the time for the coarse points alone; on other grids the
    two are equal.
    """

    points: int
    there: int
    blocks: int
    journal_bytes: int
    result_bytes: int
    seconds: float
    least_seconds: float
    uncertainty: float
    pilot_points: int
    workers: int


def plan(
    config: Config, output: Path, compiling: Compiling = SILENT, part: Part | None = None
) -> Plan:
    """Return the estimate for a sweep or a part of it; the pilot sample is not kept.

    `compiling` shows that kernels are being compiled.

    Raises the errors with which the sweep would refuse to begin, as `intention` does, and
    ExecutorError.
    """
    wanted, execution = intention(config, output, part), config.execution
    target, done = wanted.target, ~wanted.missing
    points, left = (int(np.count_nonzero(some)) for some in (target.needed, wanted.missing))
    costs, workers, slots, blocks = Costs(), execution.slots, 1, 0
    if left:
        options = options_of(config)
        with compiling:
            compile_kernels(options, target.grid)
        with make_executor(execution) as executor:
            costs = _pilot(target.grid, options, done, executor)
            workers = slots = executor.slots  # a cluster has its own number
            block = execution.block_points or max(1, costs.points_in(executor.block_seconds))
            blocks = math.ceil(left / block)
            if target.grid.followed:
                blocks = sum(1 for _ in order_of(target.grid, done, executor))
                slots = min(slots, blocks)  # a line is computed by one worker
    refinement = refinement_of(config.refine, target.grid)
    needed = refinement.needed() if refinement else target.needed
    return Plan(
        points=points,
        there=points - left,
        blocks=blocks,
        journal_bytes=left * BYTES_PER_POINT,
        result_bytes=most_bytes(target.grid, target.chunks, global_attributes(config)),
        seconds=costs.estimate(left, slots),
        least_seconds=costs.estimate(int(np.count_nonzero(needed & ~done)), slots),
        uncertainty=costs.uncertainty,
        pilot_points=costs.points,
        workers=workers,
    )


def _pilot(grid: Grid, options: Options, done: NDArray[np.bool_], executor: Workers) -> Costs:
    """Return the costs of a few points or, if time permits, of blocks as large as in a sweep.

    A few points do not fill the lanes of a kernel, so each seems to cost more.
    """

    def costs_in_blocks_of(points: int) -> Costs:
        costs, order = Costs(), Given(_sample(done, points))
        if grid.followed:  # whole lines, one block for each worker
            lines = order_of(grid, done, executor)
            order = Given(list(islice(lines, executor.slots)), lines.line)
        for block in ask(grid.rows, order, options, executor):
            fresh = int(np.count_nonzero(~done[block.indices]))  # a line may hold finished points
            costs.learn(fresh, block.seconds)
        return costs

    costs = costs_in_blocks_of(_FEW)
    if grid.followed:
        return costs
    affordable = costs.points_in(_MOMENT * executor.slots / PILOT_BLOCKS)
    many = min(affordable, pilot_points(len(done)))
    return costs_in_blocks_of(many) if many > 2 * _FEW else costs


def _sample(done: NDArray[np.bool_], points: int) -> list[NDArray[np.int64]]:
    """Return the blocks of a pilot; if few points are left, the strata cover only these."""
    blocks = pilot_blocks(done, points)
    if sum(map(len, blocks)) >= points:
        return blocks
    left = np.flatnonzero(~done)
    return [left[some] for some in pilot_blocks(np.zeros(len(left), dtype=bool), points)]
