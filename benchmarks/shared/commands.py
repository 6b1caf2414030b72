"""The command line, run as a user does, and what it took."""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

COMMAND = Path(sys.executable).with_name("stickslip")
MIB = 2.0**20

# Runs the program from a small process: the peak of a child is never below that of its parent.
_LAUNCHER = """
import json, resource, subprocess, sys, time
begun = time.perf_counter()
code = subprocess.call(sys.argv[2:], stdin=subprocess.DEVNULL)
seconds = time.perf_counter() - begun
peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
with open(sys.argv[1], "w") as file:
    json.dump({"seconds": seconds, "code": code, "peak": peak}, file)
"""


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
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "report.json"
        ended = subprocess.run(
            [sys.executable, "-S", "-c", _LAUNCHER, str(report), *map(str, words)],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            env=os.environ | environment,
        )
        took = json.loads(report.read_text()) if report.exists() else {"code": ended.returncode}
    if took["code"] not in codes:
        output = ended.stdout.decode(errors="replace")
        raise RuntimeError(f"{words} ended with exit code {took['code']}:\n{output}")
    peak = took["peak"] * (1 if sys.platform == "darwin" else 1024)
    return {"seconds": took["seconds"], "code": took["code"], "peak_mib": peak / MIB}


def median_of_commands(runs: int, *words: str | Path) -> float:
    """Return the median of the wall seconds of `stickslip WORDS`."""
    return statistics.median(run_command(*words)["seconds"] for _ in range(runs))
