"""The Python in README.md and under "In short" in docs/api.md runs, and does what the page says."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from stickslip.variables import canonical_name, canonical_result
from sweeps.citations import bibtex

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text("utf-8")


@pytest.mark.slow
def test_the_example_of_the_readme_prints_what_it_says(tmp_path: Path) -> None:
    (block,) = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    (printed,) = re.findall(r"```text\n(.*?)```", README, re.DOTALL)
    assert len([line for line in block.splitlines() if line]) <= 10
    assert run(block, tmp_path) == printed
    assert made_in(tmp_path) == {"map.png"}


@pytest.mark.stress
def test_the_calls_in_short_run_as_one_script(tmp_path: Path) -> None:
    page = (ROOT / "docs" / "api.md").read_text("utf-8")
    (block,) = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    (tmp_path / "configs").symlink_to(ROOT / "configs")
    assert len(run(block, tmp_path).splitlines()) == 1
    assert made_in(tmp_path) == {"mine.nc", "courses.png", "forces.pdf", "portrait.png"}


def test_the_program_takes_the_symbols_of_the_table() -> None:
    rows = re.findall(r"^\| ([^|]+) \| (`[^|]+`) \|", README, re.MULTILINE)
    assert len(rows) > 5
    for symbols, names in rows:
        known = [canonical_name(each) or canonical_result(each) for each in symbols.split(", ")]
        assert known == names.replace("`", "").split(", ")


def test_the_bibtex_of_the_readme_is_what_the_command_prints() -> None:
    (block,) = re.findall(r"```bibtex\n(.*?)```", README, re.DOTALL)
    assert block.strip() == bibtex().strip()


def run(script: str, folder: Path) -> str:
    """What a script prints."""
    return subprocess.run(
        [sys.executable, "-c", script], cwd=folder, capture_output=True, text=True, check=True
    ).stdout


def made_in(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()} - {"configs"}
