"""The executors that a config can ask for, and the module of each.

To add an executor, write the module and add a line here: the schema of configs, the command line
and the pages take its name from this table. Modules are named, not imported, so that reading a
config loads none of them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType


@dataclass(frozen=True)
class ExecutorEntry:
    """An executor: what computes the points, and its module within `sweeps.engine.executors`.

    The module has `executor_for(execution)`, the Executor of a section `execution` of a config.
    """

    meaning: str
    module: str


EXECUTORS: Mapping[str, ExecutorEntry] = MappingProxyType(
    {
        "threads": ExecutorEntry("threads of this process", "threads"),
        "loky": ExecutorEntry("processes of this machine", "processes"),
        "dask": ExecutorEntry("the workers of a dask cluster", "dask"),
    }
)
"""By the name of `execution.backend`; the first is that of a config which names none."""
