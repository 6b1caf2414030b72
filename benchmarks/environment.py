"""What a benchmark ran on, and where its numbers go."""

from __future__ import annotations

import json
import platform
import subprocess
from pathlib import Path
from typing import Any

from stickslip.compiled.cache import source_hash
from sweeps.files.attributes import software

HERE = Path(__file__).parent


def environment() -> dict[str, str]:
    """Commit, code, machine and versions."""
    return {
        "commit": _commit(),
        "code_sha256": source_hash(),
        "processor": _processor(),
        "system": f"{platform.system()} {platform.machine()}",
        "software": software(),
    }


def write_results(name: str, results: Any) -> Path:
    """Write `benchmarks/results/NAME.json`: the results and the environment."""
    path = HERE / "results" / f"{name}.json"
    path.parent.mkdir(parents=True, exist_ok=True)
    content = {"environment": environment(), "results": results}
    path.write_text(json.dumps(content, indent=1) + "\n")
    return path


def _commit() -> str:
    """The commit, marked where the sources, not just earlier results, differ from it."""
    git = ("git", "-C", str(HERE.parent))
    sources = ("--", ".", ":(exclude)benchmarks/results")
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
