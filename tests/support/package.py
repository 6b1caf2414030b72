"""A copy of the package that a test may change, and code that runs with it."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import stickslip

PACKAGE = Path(stickslip.__file__).parent

ENDED = 1800.0  # seconds, after which a process hangs on any machine


def copy_of_package(folder: Path, package: Path = PACKAGE) -> Path:
    """Copy the sources of a package into `folder`."""
    ignore = shutil.ignore_patterns("__pycache__")
    return Path(shutil.copytree(package, folder / package.name, ignore=ignore))


def start_python(script: str, cache: Path, package: Path = PACKAGE) -> subprocess.Popen[str]:
    """Start an interpreter with the given package and folder of compiled code."""
    return subprocess.Popen(
        [sys.executable, "-W", "default", "-c", script],
        env=os.environ | {"NUMBA_CACHE_DIR": str(cache), "PYTHONPATH": str(package.parent)},
        cwd=package.parent,  # an interpreter started with -c looks there first
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def run_python(script: str, cache: Path, package: Path = PACKAGE) -> tuple[str, str]:
    """Return the output and the warnings of a script; raise AssertionError if it fails."""
    process = start_python(script, cache, package)
    out, err = process.communicate(timeout=ENDED)
    assert process.returncode == 0, err
    return out, err
