"""The recipes of CONTRIBUTING.md touch as few files as promised, and work."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest
from support.recipes import OF_THE_SHELL, RECIPES, carried_out, copied, output_of, script

ALL = RECIPES | OF_THE_SHELL

MOST_FILES = {
    "friction law": 3,
    "law of the order parameter": 3,
    "state variables": 4,
    "integral": 3,
    "free energy": 1,
    "force on the block": 2,
    "drive tone": 2,
    "parameter": 2,
    "result variable": 2,
    "figure": 2,
    "method": 2,
    "executor": 2,
}
"""The largest number of files, from the table of CONTRIBUTING.md."""


@pytest.mark.parametrize("name", ALL)
def test_a_recipe_touches_no_more_files_than_promised(name: str, tmp_path: Path) -> None:
    touched = carried_out(ALL[name], copied(tmp_path))
    sys.stdout.write(f"{name}: {len(touched)} files: {', '.join(sorted(touched))}\n")
    assert len(touched) <= MOST_FILES[name]


def test_a_figure_needs_only_a_file_and_a_line(tmp_path: Path) -> None:
    copy = copied(tmp_path)
    carried_out(OF_THE_SHELL["figure"], copy)
    done = output_of(script("drawn.py"), copy)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == [1e-7, 2e-7]


@pytest.mark.slow
def test_an_executor_needs_only_a_file_and_a_line_for_the_same_bits(tmp_path: Path) -> None:
    copy = copied(tmp_path)
    carried_out(OF_THE_SHELL["executor"], copy)
    # The kernels of the project are already in the cache.
    done = output_of(script("serial_sweeps.py"), copy)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["in memory"] == found["into a file"] == found["by threads"]
    assert found["threads"] == ["MainThread"] * 6
    assert found["help"] == "threads|loky|serial|dask"
