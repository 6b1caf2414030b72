"""Parts have no separate machine code, and give the same results in kernels as alone."""

from __future__ import annotations

import gc
import os

import numpy as np
import pytest

from stickslip.compiled.decorators import inline, jit, named_kernel


def _series(x: float, terms: int = 3) -> float:
    """Return a sum that another compilation could round differently."""
    total = 1.0
    for i in range(terms, 0, -1):
        total = 1.0 + x * total / i
    return total


series = jit(_series)
double = inline(lambda x: 2.0 * x)


def _sums(x: np.ndarray, out: np.ndarray) -> None:
    for i in range(len(x)):
        out[i] = double(series(x[i])) + series(x[i], 7) + series(x=x[i], terms=9)


# Each process compiles this, because a kernel from the cache does not show its parts.
sums = named_kernel(f"tests: sums of parts in {os.getpid()}", _sums)


def test_a_part_gives_python_the_results_that_it_gives_a_kernel() -> None:
    x, out = np.linspace(-2.0, 2.0, 9), np.empty(9)
    sums(x, out)
    assert out.tolist() == [double(series(v)) + series(v, 7) + series(x=v, terms=9) for v in x]


def test_a_part_that_a_kernel_calls_gets_no_machine_code() -> None:
    sums(np.ones(1), np.ones(1))
    for part in (series, double):
        assert part.overloads
        for result in part.overloads.values():
            assert not callable(result.entry_point)
            assert not result.library.codegen._engine.is_symbol_defined(result.fndesc.mangled_name)


@jit
def fall(unused: int, n: int) -> int:
    return n + fall(unused, n - 1) if n > 0 else 0  # recursion: it cannot vanish into its caller


@jit
def falls(n: int) -> int:
    return fall(1000, n)


def test_code_inside_a_kernel_is_used_by_no_other_code() -> None:
    # In the kernel the optimiser drops the first argument, which other callers pass.
    def _falls(out: np.ndarray) -> None:
        for i in range(len(out)):
            out[i] = falls(i)

    out = np.empty(5)
    named_kernel(f"tests: falls in {os.getpid()}", _falls)(out)
    assert out.tolist() == [falls(i) for i in range(5)] == [0, 1, 3, 6, 10]


@pytest.mark.parametrize("collecting", [True, False])
def test_a_compilation_leaves_garbage_collection_as_it_was(collecting: bool) -> None:
    kernel = named_kernel(f"tests: collecting {collecting} in {os.getpid()}", _sums)
    if not collecting:
        gc.disable()
    try:
        kernel(np.ones(1), np.ones(1))
        assert gc.isenabled() is collecting
    finally:
        gc.enable()
