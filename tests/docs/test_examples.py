"""Examples in docstrings: every public name has one, and it gives the result that it shows."""

from __future__ import annotations

import doctest
import inspect
from pathlib import Path
from typing import Any

import pytest
from support.marks import marked

import stickslip
import sweeps

PUBLIC = {name: getattr(home, name) for home in (stickslip, sweeps) for name in home.__all__}
PUBLIC |= {
    f"ds.stickslip.{name}": method
    for name, method in inspect.getmembers(sweeps.StickslipAccessor, inspect.isfunction)
    if not name.startswith("_")
}


SLOW = ("phase_diagram", "ds.stickslip.report", "ds.stickslip.summary")


@pytest.mark.parametrize("name", [*sorted({*PUBLIC} - {*SLOW}), *marked("stress", SLOW)])
def test_the_docstring_has_an_example_that_holds(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    given: dict[str, Any] = {each: PUBLIC[each] for each in PUBLIC if "." not in each}
    example = doctest.DocTestParser().get_doctest(
        inspect.getdoc(PUBLIC[name]) or "", given, name, None, None
    )
    assert example.examples
    failed, _ = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS).run(example)
    assert not failed, capsys.readouterr().out
