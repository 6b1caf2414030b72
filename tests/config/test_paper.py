"""The shipped configs."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.sweeps.configs import SHIPPED

from sweeps.config.load import load


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_a_shipped_config_says_what_it_produces(path: Path) -> None:
    claim, editor, *_ = path.read_text().splitlines()
    assert claim.startswith("# ")
    assert len(claim) > 60
    assert editor == "# yaml-language-server: $schema=stickslip.schema.json"
    config = load(path)
    assert config.title
    assert config.output == f"results/{path.stem}.nc"
    assert config.warnings == ()


def test_the_configs_that_others_rely_on_are_shipped() -> None:
    shipped = {path.stem for path in SHIPPED}
    assert {"quickstart", *(f"fig{n}" for n in (2, 3, 5, 6, 7, 8, 9)), "cube"} <= shipped
