"""The command line in this process, in an empty folder that holds the config of the test file."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from support.sweeps.commands import FOUR_POINTS, Command, Result

from sweeps.cli.app import main


@pytest.fixture
def command(
    request: pytest.FixtureRequest,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> Command:
    """The real entry point; `a.yaml` is the SWEEP of the test file, or else four points."""
    monkeypatch.chdir(tmp_path)
    Path("a.yaml").write_text(getattr(request.module, "SWEEP", FOUR_POINTS))

    def call(*arguments: str) -> Result:
        monkeypatch.setattr(sys, "argv", ["stickslip", *arguments])
        with pytest.raises(SystemExit) as ended:
            main()
        out, err = capsys.readouterr()
        assert "Traceback" not in out + err
        return Result(int(ended.value.code or 0), out, err)

    return call
