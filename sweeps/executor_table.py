"""The executors that a config can name, and the module of each.

To add an executor, write the module and add a line here. The schema of configs, the command line
and the pages take the names from this table. The table names the modules and does not import them,
so that reading a config loads none of them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType


@dataclass(frozen=True)
class ExecutorEntry:
    """An executor: what computes the points, and its module within `sweeps.engine.executors`.

    The module has a function `executor_for(execution)`, which makes the Executor for the section
    `execution` of a config.
    """

    meaning: str
    module: str


EXECUTORS: Mapping[str, ExecutorEntry] = MappingProxyType(
    {
        "threads": ExecutorEntry("threads in this process", "threads"),
        "loky": ExecutorEntry("processes on this machine", "processes"),
        "dask": ExecutorEntry("the workers of a dask cluster", "dask"),
    }
)
"""Executors by the name in `execution.backend`; a config that names none gets the first."""
