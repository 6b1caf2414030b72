"""Kernels are compiled before a run, several at a time, whatever fails."""

from __future__ import annotations

from concurrent.futures import Future
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stickslip.compiled.cache import is_kept
from stickslip.dispatch import compilation as kernels
from stickslip.kernels.adaptive.passes import pass_kernel
from stickslip.kernels.families import KIND, Family
from stickslip.options import DEFAULTS
from stickslip.orbit import prepare_kernels, uncompiled
from sweeps.config.load import from_mapping
from sweeps.engine.computing import compile_kernels
from sweeps.grid import Grid

INDICES = [-2 / 3, 0.0, 2 / 3]
KINDS = [[index, *[0.0] * (len(KIND) - 1)] for index in INDICES]
GRID = Grid.from_config(from_mapping({"sweep": {"T": [200.0, 250.0], "gamma": INDICES}}))


@pytest.fixture
def prepared(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """The kinds that this process prepared, call by call."""
    calls: list[Any] = []
    monkeypatch.setattr(kernels, "prepare_kernels", lambda _, kinds: calls.append(kinds.tolist()))
    return calls


def test_other_processes_compile_missing_kernels_meanwhile(
    prepared: list[Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kernels, "uncompiled", lambda *_: [0, 1])
    monkeypatch.setattr(kernels, "usable_cores", lambda: 2)
    compile_kernels(DEFAULTS, GRID)
    assert prepared == [[], KINDS]


@pytest.mark.parametrize("cores", [1, 2])
def test_with_one_core_or_nothing_to_do_no_process_starts(
    prepared: list[Any], monkeypatch: pytest.MonkeyPatch, cores: int
) -> None:
    monkeypatch.setattr(kernels, "uncompiled", lambda *_: [0][: 2 - cores])
    monkeypatch.setattr(kernels, "usable_cores", lambda: cores)
    monkeypatch.setattr(kernels, "compiled_elsewhere", None)
    compile_kernels(DEFAULTS, GRID)
    assert prepared == [KINDS]


def _fail(*_: object) -> None:
    raise OSError("no memory left")


def test_kernels_that_fail_elsewhere_are_compiled_here_afterwards(
    prepared: list[Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kernels, "uncompiled", lambda *_: [0])
    monkeypatch.setattr(kernels, "usable_cores", lambda: 2)
    monkeypatch.setattr(kernels, "compile_one", _fail)
    compile_kernels(DEFAULTS, GRID)
    assert prepared == [[], KINDS]


def test_without_processes_all_kernels_are_compiled_here(
    prepared: list[Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kernels, "uncompiled", lambda *_: [0])
    monkeypatch.setattr(kernels, "usable_cores", lambda: 2)
    monkeypatch.setattr(kernels, "process_pool", _fail)
    compile_kernels(DEFAULTS, GRID)
    assert prepared == [[], KINDS]


def test_kernels_that_no_process_has_begun_are_compiled_here(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    futures: list[Future[None]] = [Future() for _ in range(3)]
    futures[0].set_result(None)
    futures[1].set_running_or_notify_cancel()
    submitted = iter(futures)
    pool = SimpleNamespace(submit=lambda _: next(submitted), shutdown=lambda **_: None)
    monkeypatch.setattr(kernels, "process_pool", lambda _: pool)
    monkeypatch.setattr(kernels, "usable_cores", lambda: 2)
    made: list[int] = []
    with kernels.compiled_elsewhere([partial(made.append, number) for number in range(3)]):
        futures[1].set_result(None)
    assert made == [2]


def test_a_family_is_missing_until_it_is_compiled() -> None:
    kinds = np.zeros((5, len(KIND)))
    kinds[2:, 0] = 0.31, 0.32, 0.33
    prepare_kernels(DEFAULTS, kinds[:1])
    assert is_kept(pass_kernel(Family(DEFAULTS.physics, 0.0)))
    assert len(uncompiled(DEFAULTS, kinds[:2])) == 0
    # The other films have one family, which an earlier test may have compiled. All families share
    # the kernels of searches.
    assert len(uncompiled(DEFAULTS, kinds[2:])) <= 1
