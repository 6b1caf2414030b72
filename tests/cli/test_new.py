"""`stickslip new` writes valid configs and prints the next command."""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest
from support.sweeps.commands import Command


@pytest.mark.parametrize("kind", ["paper", "lubricant", "map", "fit"])
def test_a_new_config_is_valid(command: Command, kind: str) -> None:
    code, out, err = command("new", "film.yaml", "--kind", kind)
    assert (code, err) == (0, "")
    assert out.startswith("film.yaml\nnext: stickslip ")
    command.ok("check", "film.yaml")
    text = Path("film.yaml").read_text()
    assert "film.yaml" in text
    assert "FILE" not in text
    assert "RESULT" not in text
    if kind != "fit":
        assert "output: results/film.nc" in text


@pytest.mark.parametrize("kind", ["paper", "lubricant", "map"])
@pytest.mark.parametrize("stem", ["my film", "run #2", "a: b", "it's", "FILE of RESULT", "null"])
def test_a_new_config_may_have_any_name(command: Command, kind: str, stem: str) -> None:
    """Its commands are quoted for the shell, and its output for YAML."""
    out = command.ok("new", f"{stem}.yaml", "--kind", kind).out
    name = shlex.quote(f"{stem}.yaml")
    assert out == f"{stem}.yaml\nnext: stickslip sweep {name}\n"
    assert f"stickslip sweep {name}" in Path(f"{stem}.yaml").read_text()
    assert f"stickslip plot {shlex.quote(f'results/{stem}.nc')}" in Path(f"{stem}.yaml").read_text()
    assert f"output: results/{stem}.nc\n" in command.ok("check", f"{stem}.yaml").out


def test_an_existing_file_is_kept(command: Command) -> None:
    before = Path("a.yaml").read_text()
    code, _, err = command("new", "a.yaml")
    assert code == 2
    assert "a.yaml already exists" in err
    assert Path("a.yaml").read_text() == before
    assert "the name of a config must end in .yaml" in command("new", "a.txt").err
