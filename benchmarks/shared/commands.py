"""The command line, run as a user does, and what it took."""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

COMMAND = Path(sys.executable).with_name("stickslip")
MIB = 2.0**20


def run_command(*words: str | Path, stopped: bool = False, **environment: str) -> dict[str, Any]:
    """Run `stickslip WORDS`; return its wall seconds, exit code and peak memory.

    Raises RuntimeError where it fails; failed points are no failure, nor, if `stopped` is meant, an
    early end.
    """
    return run_process([COMMAND, *words], (0, 3, 4) if stopped else (0, 3), **environment)


def run_process(
    words: list[str | Path], codes: tuple[int, ...] = (0,), **environment: str
) -> dict[str, Any]:
    """Run a program; see `run_command`."""
    begun = time.perf_counter()
    with (
        tempfile.TemporaryFile() as said,
        subprocess.Popen(
            [str(word) for word in words],
            stdin=subprocess.DEVNULL,
            stdout=said,
            stderr=subprocess.STDOUT,
            env=os.environ | environment,
        ) as process,
    ):
        _, status, usage = os.wait4(process.pid, 0)
        seconds = time.perf_counter() - begun
        process.returncode = code = os.waitstatus_to_exitcode(status)
        said.seek(0)
        text = said.read().decode(errors="replace")
    if code not in codes:
        raise RuntimeError(f"{words} ended with exit code {code}:\n{text}")
    peak = usage.ru_maxrss * (1 if sys.platform == "darwin" else 1024)
    user = usage.ru_utime + usage.ru_stime
    return {"seconds": seconds, "cpu": user, "code": code, "peak_mib": peak / MIB, "said": text}


def median_of_commands(runs: int, *words: str | Path) -> float:
    """Return median of the wall seconds of `stickslip WORDS`."""
    return statistics.median(run_command(*words)["seconds"] for _ in range(runs))
