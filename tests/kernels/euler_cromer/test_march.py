"""The machine code of the loops of the march."""

from __future__ import annotations

import re

import llvmlite.binding as llvm
import numpy as np
import pytest
from numba.core import config as numba_config
from support.marches import FAST_DT, fast, march_of
from support.points import GAMMAS

from stickslip.compiled.decorators import jit
from stickslip.kernels.euler_cromer import march
from stickslip.kernels.families import Family
from stickslip.options import DEFAULTS

FAMILIES = [Family(DEFAULTS.physics, gamma) for gamma in (*GAMMAS, None)]
_ARITHMETIC = re.compile(r"\bv(?:mul|add|sub|fn?m(?:add|sub)\d+)(pd|sd)\b")
_DIVISION = re.compile(r"\bv(?:div|sqrt)[ps]d\b")


def hot_loops(assembly: str) -> list[str]:
    """Return the innermost loops with 12 vector operations or more."""
    lines, labels, loops = assembly.splitlines(), {}, []
    for i, line in enumerate(lines):
        if label := re.match(r"(\.LBB\w+):", line):
            labels[label[1]] = i
        elif jump := re.match(r"\s+j\w+\s+(\.LBB\w+)", line):
            begin = labels.get(jump[1], i)
            body = "\n".join(lines[begin + 1 : i])
            vectors = _ARITHMETIC.findall(body).count("pd")
            if not re.search(r"^\.LBB", body, re.MULTILINE) and vectors >= 12:
                loops.append(body)
    return loops


def assembly_of(family: Family, noisy: bool, measured: bool) -> str:
    """Return the assembly of a freshly compiled march, as a cached one has none."""
    fresh = jit(march.march_kernel(family, noisy, measured).py_func).alone
    fresh(march_of([fast()], FAST_DT).tasks, np.arange(0), 1)
    return fresh.inspect_asm(fresh.signatures[0])


def test_divisions_scalar_code_and_calls_are_detected() -> None:
    lines = [".LBB0_1:", *["vmulpd %zmm1"] * 30, "vdivpd %zmm2", "vmulsd %xmm1", "callq sin"]
    (loop,) = hot_loops("\n".join([*lines, "\tjne .LBB0_1"]))
    assert _DIVISION.search(loop)
    assert "sd" in _ARITHMETIC.findall(loop)
    assert "call" in loop


@pytest.mark.stress
@pytest.mark.parametrize("measured", [True, False])
@pytest.mark.parametrize("noisy", [True, False])
@pytest.mark.parametrize("family", FAMILIES, ids=str)
def test_the_hot_loop_is_vectors_without_calls_and_divisions(
    family: Family, noisy: bool, measured: bool
) -> None:
    features = numba_config.CPU_FEATURES or llvm.get_host_cpu_features().flatten()
    if not {"+avx2", "+avx512f"} & set(features.split(",")):
        pytest.skip("without AVX2 the vectors of this machine are too short")
    loops = hot_loops(assembly_of(family, noisy, measured))
    assert loops
    for loop in loops:
        assert set(_ARITHMETIC.findall(loop)) == {"pd"}
        assert "call" not in loop
        assert "ymm" in loop or "zmm" in loop
        # The logarithm of a general power divides.
        assert len(_DIVISION.findall(loop)) <= (2 if family.gamma is None else 0)
