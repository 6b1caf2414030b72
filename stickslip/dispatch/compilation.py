"""Kernels made ready before workers would wait for them: several at a time, on the first run.

A kernel takes ten seconds to compile, and a process compiles one at a time. Some are compiled here,
the others by processes that leave them in the cache. They are as few as there are other cores: to a
process that has compiled a kernel a similar one costs a quarter.
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
    """Compile or load what points of these kinds (n, k) need, as `prepare_kernels` does."""
    missing = uncompiled(options, kinds)
    if missing and usable_cores() > 1 and not is_of_this_process(options.friction):
        calls = [partial(compile_one, options, kinds, number) for number in missing]
        with compiled_elsewhere(calls):
            prepare_kernels(options, kinds[:0])  # what all kinds share
    prepare_kernels(options, kinds)  # loads what the others left, and makes what they did not


@contextmanager
def compiled_elsewhere(calls: Sequence[Callable[[], None]]) -> Iterator[None]:
    """Meanwhile these calls are made by processes that joblib's loky starts, the last maybe here.

    What fails, here or there, is left to whoever comes afterwards.
    """
    with children_started():
        pool = process_pool(min(len(calls), usable_cores() - 1))
    try:
        with children_started():
            futures = [pool.submit(call) for call in calls]
        yield
        for call, future in zip(reversed(calls), reversed(futures), strict=True):
            if future.cancel():  # no process has come to it
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
