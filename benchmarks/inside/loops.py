"""The loops over lanes of the adaptive method alone, outside the kernel that they are part of."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import types

from stickslip.compiled.decorators import jit
from stickslip.compiled.simd import LANES
from stickslip.kernels.adaptive import passes, recording
from stickslip.kernels.adaptive.queues import reduced_queue
from stickslip.kernels.families import KIND, Family, families
from stickslip.kernels.problem import problem_functions
from stickslip.numerics.adaptive_lanes import make_attempt
from stickslip.numerics.linear import algebra
from stickslip.numerics.tableaus import RODAS4P2
from stickslip.options import DEFAULTS
from stickslip.parameters import Parameters

_WARM_UP = 200  # attempts: steps are as long as they are then


class LaneLoops:
    """An attempted step of all lanes, and the look at it that measures.

    `points` (n, parameters), of one family, n at least LANES: the first of them are in the lanes.
    """

    def __init__(self, points: np.ndarray) -> None:
        functions = problem_functions(DEFAULTS.physics)
        kinds = points[:1][:, [Parameters._fields.index(name) for name in KIND]]
        ((family, _),) = families(DEFAULTS.physics, kinds)
        problems, operations = passes.make_problems(family), algebra(functions.width)
        attempt = make_attempt(
            functions.rhs, functions.jacobian, functions.error_weight,
            problems, RODAS4P2, operations, recording.ROOM,
        )  # fmt: skip
        see = recording.make_see(problems, functions, two_solids=False)
        self._loops = {"attempt": attempt, "see": see}
        self._often = {name: _often(loop) for name, loop in self._loops.items()}
        self._lanes = _loaded(points[:LANES], family)

    def repeat(self, name: str, times: int) -> None:
        """Let a loop run so many times, over lanes that never arrive."""
        self._often[name](self._lanes, times)

    def assembly(self, name: str) -> str:
        """The machine code of a loop, compiled anew."""
        fresh = self._loops[name].alone
        fresh.compile((types.float64[::1],))
        return str(next(iter(fresh.inspect_asm().values())))


def _often(loop: Any) -> Any:
    @jit
    def often(lanes: np.ndarray, times: int) -> None:
        for _ in range(times):
            loop(lanes)

    return often


def _loaded(points: np.ndarray, family: Family) -> np.ndarray:
    """Lanes with these points on their way, which nothing stops."""
    queue = reduced_queue(points, family.physics)
    lanes = passes.new_lanes(queue.states.shape[1] - 1)
    task = passes.Pass(passes.TRAVEL, 1e-6, 1e-6, 0, 10**9, False)
    queue.counts[:, passes.CYCLE] = 10**6
    passes.pass_kernel(family)(queue, lanes, task, _WARM_UP)
    for lane in range(LANES):
        recording.put(lanes.values, recording.SLOTS.end, lane, 1e9)
        recording.put(lanes.values, recording.SLOTS.limit, lane, math.inf)
    return lanes.values
