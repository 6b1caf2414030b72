"""How long the package takes to start: imports, the command line, compilation."""

from __future__ import annotations

import json
import shutil
import statistics
import sys
import tempfile
from collections import Counter
from pathlib import Path
from typing import Any

from command import median_of_commands, run_command, run_process

import stickslip
import sweeps
from sweeps.config.paper import shipped_config


def start_up(where: Path, runs: int, *, cold: bool) -> dict[str, Any]:
    """Seconds to the first words and to the first results, and where they go."""
    quickstart = shipped_config("quickstart")
    sweep = ("sweep", quickstart, "-o", where / "first.nc", "--overwrite", "--no-progress")
    run_command(*sweep)
    result: dict[str, Any] = {
        "python": _median_import("", runs),
        "import stickslip": _median_import("import stickslip", runs),
        "import stickslip.orbit": _median_import("import stickslip.orbit", runs),
        "import sweeps.engine.in_memory": _median_import("import sweeps.engine.in_memory", runs),
        "stickslip --help": median_of_commands(runs, "--help"),
        "warm first result": median_of_commands(runs, *sweep),
        "imports_of_a_sweep": _heaviest_imports(),
    }
    if cold:
        with tempfile.TemporaryDirectory() as empty:
            result["cold first result"] = run_command(*sweep, NUMBA_CACHE_DIR=empty)["seconds"]
            result["first result of another installation"] = _elsewhere(sweep, empty)
        with tempfile.TemporaryDirectory() as empty:
            result["compilations"] = _compilations(where, empty)
    print("start:", json.dumps(result, indent=1))
    return result


def _elsewhere(words: tuple[str | Path, ...], compiled: str) -> float:
    """Seconds of a command of the same sources in another place, with this folder of code."""
    with tempfile.TemporaryDirectory() as place:
        for package in (stickslip, sweeps):
            sources = Path(package.__file__).parent
            leave_out = shutil.ignore_patterns("__pycache__")
            shutil.copytree(sources, Path(place) / sources.name, ignore=leave_out)
        command = [sys.executable, "-P", "-c", "from sweeps.cli import main; main()", *words]
        run = run_process(command, NUMBA_CACHE_DIR=compiled, PYTHONPATH=place)
    return float(run["seconds"])


def _median_import(code: str, runs: int) -> float:
    return statistics.median(
        run_process([sys.executable, "-c", code])["seconds"] for _ in range(runs)
    )


def _heaviest_imports(count: int = 8) -> dict[str, float]:
    """Seconds of the packages that take longest to import for a sweep, each without the others."""
    code = "import sweeps.cli.app, sweeps.engine.sweep"
    said = run_process([sys.executable, "-X", "importtime", "-c", code])["said"]
    seconds: Counter[str] = Counter()
    for line in said.splitlines():
        parts = line.removeprefix("import time:").split("|")
        if len(parts) == 3 and parts[0].strip().isdigit():
            seconds[parts[2].strip().split(".")[0]] += 1e-6 * int(parts[0])
    return dict(seconds.most_common(count))


_COMPILATIONS = """
import json, sys, time
from numba.core import event
from stickslip.options import Options
from stickslip.orbit import compute_orbits
from stickslip.parameters import Parameters
import numpy as np

depth, seconds = 0, {}

class Listener(event.Listener):
    def on_start(self, e):
        global depth
        depth += 1
        if depth == 1:
            self.begun = time.perf_counter()

    def on_end(self, e):
        global depth
        depth -= 1
        if depth == 0:
            name = e.data["dispatcher"].py_func.__name__
            seconds[name] = seconds.get(name, 0.0) + time.perf_counter() - self.begun

with event.install_listener("numba:compile", Listener()):
    compute_orbits(
        np.array([Parameters(rheological_index=g) for g in (-2 / 3, 0, 2 / 3, -1 / 2)]), Options()
    )
json.dump(seconds, open(sys.argv[1], "w"))
"""


def _compilations(where: Path, empty: str) -> dict[str, float]:
    """Seconds that the compilation of each kernel takes, in a process with an empty cache."""
    path = where / "compilations.json"
    run_process([sys.executable, "-c", _COMPILATIONS, path], NUMBA_CACHE_DIR=empty)
    seconds = json.loads(path.read_text())
    return dict(sorted(seconds.items(), key=lambda item: -item[1]))
