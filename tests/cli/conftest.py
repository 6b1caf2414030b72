"""The command line in this process, in an empty folder that holds the config of the test file."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.sweeps.commands import FOUR_POINTS, Command


@pytest.fixture
def command(shell: Command, request: pytest.FixtureRequest) -> Command:
    """The command, ready to be called; `a.yaml` has the test file's A_YAML, or else four points."""
    if not hasattr(request.module, "A_YAML"):
        Path("a.yaml").write_text(FOUR_POINTS)
    return shell
