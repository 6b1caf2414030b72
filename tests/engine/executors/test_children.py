"""Processes that a sweep starts end with it, on systems that have little installed too."""

from __future__ import annotations

import os
from importlib import metadata

from support.sweeps.processes import Running

POOL = """
from sweeps.engine.executors.children import children_started, process_pool
with children_started():
    pool = process_pool(1)
    future = pool.submit(abs, -1)
assert future.result() == 1
pool.shutdown(wait=True, kill_workers=True)
"""


def test_processes_end_without_a_command_of_the_system() -> None:
    """Containers may lack `pgrep`, with which loky ends processes where psutil is missing."""
    pool = Running("-c", POOL, env=os.environ | {"PATH": ""})
    assert pool.ended()[0] == 0
    assert any(name.startswith("psutil") for name in metadata.requires("stickslip") or ())
