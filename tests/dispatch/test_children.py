"""The processes that a sweep starts end with it, even on a minimal system."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib import metadata
from pathlib import Path

from support.sweeps.processes import Running

import sweeps

ROOT = Path(sweeps.__file__).parents[1]

POOL = """
from stickslip.dispatch.children import children_started, process_pool
with children_started():
    pool = process_pool(1)
    future = pool.submit(abs, -1)
assert future.result() == 1
pool.shutdown(wait=True, kill_workers=True)
"""


def test_processes_end_without_a_command_of_the_system() -> None:
    """Containers may lack `pgrep`, which loky needs to end processes without psutil."""
    pool = Running("-c", POOL, env=os.environ | {"PATH": ""})
    assert pool.ended()[0] == 0
    assert any(name.startswith("psutil") for name in metadata.requires("stickslip") or ())


def test_a_process_repeats_no_warning_of_the_cache(tmp_path: Path) -> None:
    """The main process has warned already; each kernel of each process would warn again."""
    script = tmp_path / "script.py"
    script.write_text(
        "from stickslip.dispatch.children import children_started, process_pool\n"
        "if __name__ == '__main__':\n"
        "    with children_started():\n"
        "        pool = process_pool(1)\n"
        "        pool.submit(exec, 'import stickslip.orbit').result()\n"
        "        pool.shutdown(wait=True)\n"
    )
    done = subprocess.run(
        [sys.executable, str(script)],
        env=os.environ | {"NUMBA_CACHE_DIR": "/dev/null/nowhere", "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
