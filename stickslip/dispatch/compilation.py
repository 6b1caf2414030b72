"""Compilation of kernels before the first run, several at a time, so that no worker waits for them.

A kernel takes ten seconds to compile, and a process compiles one at a time. This process compiles
some, other processes compile the rest and leave them in the cache. There are only as many processes
as cores, because a process that has compiled one kernel needs a quarter of the time for a similar
one.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial

import numpy as np
from numpy.typing import NDArray

from stickslip.dispatch.children import children_started, process_pool
from stickslip.dispatch.workers import first_line
from stickslip.laws import is_of_this_process
from stickslip.options import Options
from stickslip.orbit import compile_one, prepare_kernels, uncompiled

log = logging.getLogger(__name__)


def compile_kinds(options: Options, kinds: NDArray[np.float64]) -> None:
    """Compile or load the kernels of points of these kinds (n, k), as `prepare_kernels` does."""
    missing = uncompiled(options, kinds)
    if missing and usable_cores() > 1 and not is_of_this_process(options.friction):
        calls = [partial(compile_one, options, kinds, number) for number in missing]
        with compiled_elsewhere(calls):
            prepare_kernels(options, kinds[:0])  # the kernels that all kinds share
    prepare_kernels(options, kinds)  # loads what the processes compiled, and compiles the rest


@contextmanager
def compiled_elsewhere(calls: Sequence[Callable[[], None]]) -> Iterator[None]:
    """Start these calls in processes of joblib's loky; on exit make here those not yet begun.

    A call that fails, here or there, is left to the caller.
    """
    try:
        with children_started():
            pool = process_pool(min(len(calls), usable_cores() - 1))
    except Exception as error:  # noqa: BLE001 - such as a system without shared memory
        log.debug("kernels are compiled one by one: %s", first_line(error))
        yield
        return
    try:
        with children_started():
            futures = [pool.submit(call) for call in calls]
        yield
        for call, future in zip(reversed(calls), reversed(futures), strict=True):
            if future.cancel():  # no process has begun it
                call()
        for future in futures:
            if not future.cancelled():
                future.result()
    except Exception as error:  # noqa: BLE001 - a process may end in any way
        log.debug("kernels are compiled one by one: %s", first_line(error))
    finally:
        pool.shutdown(wait=True, kill_workers=True)


def usable_cores() -> int:
    """Count the processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
