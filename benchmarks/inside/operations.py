"""Floating-point operations of a step in lanes, in its machine code, and the peak of a core.

Operations are additions, multiplications, divisions and square roots; a fused multiply-add is two.
Comparisons and choices are none.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import numpy as np
from numba import types
from shared.timing import fastest

from inside import PHYSICS
from stickslip.compiled.decorators import jit, jit_making_arrays
from stickslip.compiled.fields import make_function
from stickslip.compiled.simd import LANES, for_lanes
from stickslip.kernels.adaptive.passes import (
    SLOTS,
    TRAVEL,
    Pass,
    make_problems,
    new_lanes,
    pass_kernel,
)
from stickslip.kernels.adaptive.recording import ROOM
from stickslip.kernels.euler_cromer.march import march_kernel
from stickslip.kernels.families import Family
from stickslip.kernels.orbits.motions import motions_of
from stickslip.kernels.problem import problem_functions
from stickslip.numerics.adaptive_lanes import make_attempt
from stickslip.numerics.euler_cromer_lanes import Tasks
from stickslip.numerics.lane_array import aligned
from stickslip.numerics.linear import algebra
from stickslip.numerics.tableaus import RODAS4P2

_ARITHMETIC = re.compile(
    r"\tv?(?P<kind>mul|add|sub|div|sqrt|fn?m(?:add|sub)\d+)(?P<size>[ps])d\t(?P<rest>.*)"
)
_LABEL = re.compile(r"^\.L\w+:", re.MULTILINE)
_COUNTING = re.compile(r"\taddq\t\$(\d+), %r\w+\n\tcmpq")
_WIDTHS = {"zmm": 8, "ymm": 4, "xmm": 2}
_ROUNDS, _LENGTH = 20_000, 16  # of the loop for the peak, and multiply-adds of a chain in each
_FAR = 1e9  # an end that no lane reaches


def _operations(text: str) -> int:
    """Return the operations of machine code that runs through once."""
    count = 0
    for found in _ARITHMETIC.finditer(text):
        width = 1
        if found["size"] == "p":
            width = max(n for name, n in _WIDTHS.items() if name in found["rest"])
        count += width * (2 if found["kind"].startswith("f") else 1)
    return count


def _of_loop(function: Any) -> float:
    """Return the operations, in a lane, of a function's innermost loop, which has no branches.

    Code that is no loop goes through all lanes.
    """
    (text,) = function.inspect_asm().values()
    block = max(_LABEL.split(text), key=_operations)
    counted = _COUNTING.search(block)
    return _operations(block) / (int(counted[1]) if counted else LANES)


def fixed_step_operations(gamma: float | None) -> float:
    """Return the operations of a step of Euler-Cromer, in a lane, without noise and record."""
    kernel = march_kernel(Family(PHYSICS, gamma), False, False)
    fresh = jit_making_arrays(kernel.py_func).alone
    numbers, counts = types.float64[:, ::1], types.int64[::1]
    tasks = types.NamedTuple((numbers, counts, counts, counts), Tasks)
    fresh.compile((tasks, counts, types.int64))
    return _of_loop(fresh)


def attempted_steps(
    point: np.ndarray, gamma: float | None, rtol: float, steps: int
) -> tuple[float, Callable[[], None]]:
    """Return the operations of an attempted step, in a lane, and a function of so many in all.

    The lanes are full of the same point, on its way.
    """
    family = Family(PHYSICS, gamma)
    functions = problem_functions(PHYSICS)
    attempt = make_attempt(
        functions.rhs, functions.jacobian, functions.error_weight, make_problems(family), RODAS4P2,
        algebra(functions.width), ROOM, functions.step_limits,
    )  # fmt: skip
    attempt.alone.compile((types.float64[::1],))
    motions = motions_of(np.tile(point, (LANES, 1)), PHYSICS)
    motions.rtols[:] = rtol
    lanes = new_lanes(motions.width, LANES)
    # Into the lanes, and a hundred steps on.
    pass_kernel(family)(motions, np.arange(LANES), lanes, Pass(TRAVEL, 100, 10**9), 100)
    for slot in (SLOTS.end, SLOTS.limit):
        lanes.values[slot * LANES : (slot + 1) * LANES] = _FAR

    @jit
    def attempts(values: np.ndarray) -> None:
        for _ in range(steps):
            attempt(values)

    return _of_loop(attempt.alone), lambda: attempts.alone(lanes.values)


def peak() -> float:
    """Return the operations a nanosecond of multiply-adds that do not wait for each other.

    The best of several numbers of chains: few wait for their own results, many lack registers.
    """
    return max(map(_rate, (3, 4, 5, 6, 8)))


def _rate(chains: int) -> float:
    lines = [f"x{i} = values[{i * LANES} + lane]" for i in range(chains)]
    lines += [f"x{i} = x{i} * 0.5 + 1.0" for _ in range(_LENGTH) for i in range(chains)]
    lines += [f"values[{i * LANES} + lane] = x{i}" for i in range(chains)]
    body = make_function(f"multiply_adds[{chains}]", "lane, values", lines, {})

    @jit
    def work(values: np.ndarray, count: int) -> None:
        for _ in range(_ROUNDS):
            for_lanes(count, body, (values,))

    values = aligned(chains * LANES)

    def run() -> None:
        work.alone(values, LANES)

    run()
    return 2 * LANES * chains * _LENGTH * _ROUNDS / fastest(run, 1)
