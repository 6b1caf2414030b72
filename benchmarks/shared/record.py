"""A record, `results/NAME.json`: for each part of a script what was measured, and where."""

from __future__ import annotations

import json
import platform
import subprocess
from pathlib import Path
from typing import Any

from stickslip.compiled.cache import source_hash
from sweeps.files.attributes import software

RESULTS = Path(__file__).parents[1] / "results"

Results = dict[str, Any]
Record = dict[str, dict[str, Any]]


def read_record(path: Path) -> Record:
    """Return a record; empty where there is none."""
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}


def environment() -> dict[str, str]:
    """Return commit, code, machine and versions."""
    return {
        "commit": _commit(),
        "code_sha256": source_hash(),
        "processor": _processor(),
        "system": f"{platform.system()} {platform.machine()}",
        "software": software(),
    }


def write_record(path: Path, record: Record) -> None:
    """Write a record."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")


def _commit() -> str:
    """Return the commit, marked where the sources, not just earlier results, differ from it."""
    git = ("git", "-C", str(RESULTS.parent))
    sources = ("--", ":/", ":(exclude,top)benchmarks/results")
    changed = _output(*git, "status", "--porcelain", *sources)
    return _output(*git, "rev-parse", "--short", "HEAD") + ("-dirty" if changed else "")


def _output(*command: str) -> str:
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return "unknown"


def _processor() -> str:
    lines = _output("lscpu").splitlines()
    known = dict(line.split(":", 1) for line in lines if ":" in line)
    name, cores = known.get("Model name", "unknown").strip(), known.get("CPU(s)", "?").strip()
    return f"{name}, {cores} cores"
