"""The command line in this process, in an empty folder that holds the config of the test file."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.sweeps.commands import FOUR_POINTS, Command, result_of


@pytest.fixture
def command(
    request: pytest.FixtureRequest,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> Command:
    """A call of the command; `a.yaml` is the SWEEP of the test file, or else four points."""
    monkeypatch.chdir(tmp_path)
    Path("a.yaml").write_text(getattr(request.module, "SWEEP", FOUR_POINTS))
    return lambda *arguments: result_of(arguments, monkeypatch, capsys)
