"""Kernels that were cached by different processes keep their own code."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

_TWINS = """
import sys
from stickslip.compiled.decorators import jit, kernel

def make_sum(step):
    @jit
    def total(n):
        if n > 1:
            return step(n) + total(n - 1)  # recursion: it cannot vanish into its caller
        return step(n)
    return total

@jit
def one(n): return 1.0

@jit
def two(n): return 2.0

ones, twos = make_sum(one), make_sum(two)

@kernel
def single(n): return ones(n)

@kernel
def double(n): return twos(n)

print(*[{"single": single, "double": double}[name](5) for name in sys.argv[1:]])
"""


@pytest.mark.stress
def test_kernels_that_were_cached_by_different_processes_are_kept_apart(tmp_path: Path) -> None:
    # A factory makes functions of one name. Numba tells them apart by a counter that starts anew
    # in each process, so two cached kernels can hold different code under one and the same symbol.
    script = tmp_path / "twins.py"
    script.write_text(_TWINS, encoding="utf-8")
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}

    def answers(*kernels: str) -> list[float]:
        command = [sys.executable, str(script), *kernels]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
        return [float(word) for word in done.stdout.split()]

    assert answers("single") == [5.0]
    assert answers("double") == [10.0]
    assert answers("single", "double") == [5.0, 10.0]
    assert answers("double", "single") == [10.0, 5.0]
