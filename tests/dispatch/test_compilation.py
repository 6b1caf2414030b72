"""Kernels are made ready several at a time, and in any case."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from stickslip.compiled.cache import is_kept
from stickslip.dispatch import compilation as kernels
from stickslip.kernels.adaptive.passes import pass_kernel
from stickslip.kernels.families import KIND, Family
from stickslip.options import DEFAULTS, Options
from stickslip.orbit import prepare_kernels, uncompiled
from sweeps.config.load import from_mapping
from sweeps.engine.computing import compile_kernels
from sweeps.grid import Grid

INDICES = [-2 / 3, 0.0, 2 / 3]
FLUIDS = [[index, *[0.0] * (len(KIND) - 1)] for index in INDICES]
"""Their kinds."""

GRID = Grid.from_config(from_mapping({"sweep": {"T": [200.0, 250.0], "gamma": INDICES}}))


@pytest.fixture
def prepared(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """The kinds that were asked for in this process, call by call."""
    asked: list[Any] = []
    monkeypatch.setattr(kernels, "prepare_kernels", lambda _, kinds: asked.append(kinds.tolist()))
    return asked


def test_families_that_are_missing_are_compiled_in_processes_meanwhile(
    prepared: list[Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kernels, "uncompiled", lambda _, kinds: kinds[:2])
    monkeypatch.setattr(kernels, "_cores", lambda: 2)
    compile_kernels(DEFAULTS, GRID)
    assert prepared == [[], FLUIDS]


def test_a_family_alone_is_compiled_here_and_what_all_share_meanwhile(
    prepared: list[Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    here: list[Any] = []
    monkeypatch.setattr(kernels, "uncompiled", lambda _, kinds: kinds[:1])
    monkeypatch.setattr(kernels, "_cores", lambda: 2)
    monkeypatch.setattr(kernels, "compile_families", lambda _, kinds: here.append(kinds.tolist()))
    compile_kernels(DEFAULTS, GRID)
    assert here == [FLUIDS[:1]]
    assert prepared == [FLUIDS]  # what another process was asked for is not seen here


@pytest.mark.parametrize("cores", [1, 2])
def test_one_core_or_nothing_to_do_needs_no_process(
    prepared: list[Any], monkeypatch: pytest.MonkeyPatch, cores: int
) -> None:
    monkeypatch.setattr(kernels, "uncompiled", lambda _, kinds: kinds[: 2 - cores])
    monkeypatch.setattr(kernels, "_cores", lambda: cores)
    monkeypatch.setattr(kernels, "_elsewhere", None)
    compile_kernels(DEFAULTS, GRID)
    assert prepared == [FLUIDS]


def _fail(options: Options, kinds: np.ndarray) -> None:
    raise OSError("no memory left")


@pytest.mark.parametrize(("missing", "asked"), [(1, [FLUIDS]), (2, [[], FLUIDS])])
def test_what_fails_is_made_afterwards(
    prepared: list[Any], monkeypatch: pytest.MonkeyPatch, missing: int, asked: list[Any]
) -> None:
    monkeypatch.setattr(kernels, "uncompiled", lambda _, kinds: kinds[:missing])
    monkeypatch.setattr(kernels, "_cores", lambda: 2)
    monkeypatch.setattr(kernels, "compile_families", _fail)
    compile_kernels(DEFAULTS, GRID)
    assert prepared == asked


def test_a_family_is_missing_until_it_is_compiled() -> None:
    kinds = np.zeros((5, len(KIND)))
    kinds[2:, 0] = 0.31, 0.32, 0.33
    prepare_kernels(DEFAULTS, kinds[:1])
    assert is_kept(pass_kernel(Family(DEFAULTS.physics, 0.0)))
    assert len(uncompiled(DEFAULTS, kinds[:2])) == 0
    # Other films of one family count once; whether it was ever needed here is not known.
    assert len(uncompiled(DEFAULTS, kinds[2:])) <= 1
