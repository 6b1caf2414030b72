"""Blocks that come back damaged from a thread, or from the worker of a cluster.

`python -m distributed.cli.dask_worker ... --preload faults.answers` starts such a worker.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from faults.arena import CONFIG, Tally
from stickslip.dispatch import thread_pool
from stickslip.dispatch.errors import ExecutorError
from stickslip.dispatch.task import Block, Task
from stickslip.variables import RESULT_COLUMNS
from sweeps.config.load import from_yaml
from sweeps.engine.run import run as run_sweep
from sweeps.files.netcdf import content_hash

_VALUES = (np.nan, np.inf, -np.inf, -1.0, 1e300, -1e300, 99.5)


def threads_lie(quick: bool) -> Tally:
    """Damage a block of a sweep in memory, which then is right, or ends with an error."""
    rng, tally, config = random.Random(7), Tally(), from_yaml(CONFIG)
    expected, whole = content_hash(run_sweep(config)), thread_pool.compute_block
    for _ in range(5 if quick else 200):
        thread_pool.compute_block = _liar(whole, rng, every=rng.choice([1, 3, 12]))
        try:
            sound = content_hash(run_sweep(config)) == expected
            tally.count("survived" if sound else "wrong", "another result")
        except ExecutorError:
            tally.count("survived")
        except Exception as error:  # noqa: BLE001 - what should not be is counted
            tally.count("wrong", repr(error))
        finally:
            thread_pool.compute_block = whole
    return tally


def _liar(
    compute: Callable[[Task], Block], rng: random.Random, every: int
) -> Callable[[Task], Any]:
    """Return a function that damages every so many blocks."""

    def damaged(task: Task) -> Any:
        block = compute(task)
        return _damage(block, rng) if rng.randrange(every) == 0 else block

    return damaged


def _damage(block: Block, rng: random.Random) -> Any:
    kind = rng.randrange(8)
    if kind == 0:
        return rng.choice([None, 1, "block", [block], block.results])
    if kind == 1:
        return replace(block, indices=block.indices + 1)
    if kind == 2:
        return replace(block, results=block.results[:, 1:])
    results = block.results.copy()
    place = rng.randrange(len(results)), rng.randrange(len(RESULT_COLUMNS))
    if kind == 3:
        results[place] = rng.choice(_VALUES)
    else:
        results.view(np.uint64)[place] ^= np.uint64(1 << rng.randrange(64))
    return replace(block, results=results)


def dask_setup(_: object) -> None:
    """Damage every third block of this worker; dask calls it as the worker begins."""
    from sweeps.engine.executors import dask

    dask.compute_block = _liar(dask.compute_block, random.Random(), every=3)
