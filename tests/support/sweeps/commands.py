"""Commands of the command line, in this process or another, and their results."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import pytest

from support.sweeps.processes import HANGS
from sweeps.cli.app import main

FOUR_POINTS = """\
title: Four points
sweep:
  temperature: [200, 250]
  rheological_index: [-2/3, 0]
integrator: {rtol: 1e-4}
stationary: {rtol: 1e-4}
simulation: {periods: 1, samples_per_period: 50}
"""


class Result(NamedTuple):
    """The exit code of a command and what it printed."""

    code: int
    out: str
    err: str


class Command(Protocol):
    """The command line in this process; `ok` fails unless the exit code is 0."""

    def __call__(self, *arguments: str) -> Result: ...
    def ok(self, *arguments: str) -> Result: ...


def result_of(
    arguments: Iterable[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Result:
    """Run a command in this process through its real entry point."""
    monkeypatch.setattr(sys, "argv", ["stickslip", *arguments])
    with pytest.raises(SystemExit) as ended:
        main()
    out, err = capsys.readouterr()
    assert "Traceback" not in out + err
    return Result(int(ended.value.code or 0), out, err)


def process(*arguments: str, environment: dict[str, str] | None = None, **settings: Any) -> Result:
    """Run a command in a new process."""
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE} | settings
    done = subprocess.run(
        [sys.executable, "-m", "sweeps.cli", *arguments],
        env=os.environ | (environment or {}),
        text=True,
        timeout=HANGS,
        check=False,
        **streams,
    )
    assert "Traceback" not in done.stderr
    return Result(done.returncode, done.stdout, done.stderr)


def entries(folder: Path | str = ".") -> list[str]:
    """The sorted names in a folder."""
    return sorted(path.name for path in Path(folder).iterdir())
