"""The script of the page: a linter finds nothing in it, and would find faults."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("bokeh", reason="bokeh is not installed")
from sweeps.page.document import MODULES, script

_OXLINT = Path(sys.executable).with_name("oxlint")
_RULES = ("no-undef", "no-unused-vars", "eqeqeq", "prefer-const", "no-var")
_CONFIG = {
    "env": {"browser": True, "es2024": True},
    "globals": {"Bokeh": "readonly"},
    "categories": {"correctness": "error"},
    "rules": dict.fromkeys(_RULES, "error"),
}


def linted(text: str, folder: Path) -> subprocess.CompletedProcess[str]:
    (folder / "page.js").write_text(text, encoding="utf-8")
    (folder / "oxlint.json").write_text(json.dumps(_CONFIG), encoding="utf-8")
    words = [str(_OXLINT), "-c", "oxlint.json", "page.js"]
    return subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)


@pytest.fixture(autouse=True)
def oxlint_is_there() -> None:
    if not _OXLINT.exists():
        pytest.skip("oxlint is not installed: the script of the page is not linted")


def test_a_linter_finds_nothing(tmp_path: Path):
    found = linted(script(), tmp_path)
    assert found.returncode == 0, found.stdout


@pytest.mark.parametrize("fault", ["misspelt(state);", "const unused = 1;", "state.log == 1;"])
def test_a_linter_finds_a_fault(fault: str, tmp_path: Path):
    assert linted(script().replace("start();\n", f"start();\n{fault}\n"), tmp_path).returncode


def test_the_script_has_all_modules():
    folder = Path(__file__).parents[2] / "sweeps" / "page" / "web"
    assert sorted(path.stem for path in folder.glob("*.js")) == sorted(MODULES)
