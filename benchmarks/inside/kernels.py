"""Kernels beside those of the package: for any index, without noise, of other equations."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any
from unittest.mock import patch

import numpy as np

from inside.defaults import PHYSICS, WIDTH
from inside.lanes import search_pass
from stickslip.compiled.decorators import inline, jit
from stickslip.compiled.fields import make_lane_reader, make_map, make_tuple_maker
from stickslip.kernels.adaptive import passes, queues
from stickslip.kernels.adaptive.queues import reduced_queue
from stickslip.kernels.adaptive.recording import SLOTS, get
from stickslip.kernels.families import Family
from stickslip.kernels.problem import problem_of
from stickslip.model.scaling import KEPT, LITERALS, Reduced
from stickslip.numerics import step_control
from stickslip.numerics.adaptive import make_adaptive
from stickslip.numerics.linear import algebra, larger
from stickslip.numerics.tableaus import RODAS4P2
from stickslip.options import Options, Physics
from stickslip.parameters import Parameters, ParameterValues


@contextmanager
def general_kernels() -> Iterator[None]:
    """Let the kernel for any rheological index do all points."""

    def one_family(physics: Physics, indices: np.ndarray) -> Iterator[tuple[Family, np.ndarray]]:
        yield Family(physics, None), np.arange(len(indices))

    with patch.object(queues, "families", one_family):
        yield


@contextmanager
def replaced_kernel(kernel: Any) -> Iterator[None]:
    """Let this kernel do all points."""
    with patch.object(queues, "pass_kernel", lambda _family: kernel):
        yield


def kernel_without_noise(gamma: float) -> Any:
    """A compiled kernel for a rheological index, without the closure of the noise."""
    fixed = dict(LITERALS) | {"rheological_index": gamma, "noise_intensity": 0.0}
    fixed["film_thickness"] = 1.0
    values = make_tuple_maker(ParameterValues, "q", {n: f"q.{n}" for n in KEPT} | fixed, {})
    reduced = make_lane_reader(Reduced, SLOTS.parameters, get)

    @inline
    def problem(lanes: np.ndarray, lane: int) -> Any:
        return problem_of(values(reduced(lanes, lane)), get(lanes, SLOTS.rtol, lane))

    kernel = jit(passes.make_pass(problem, PHYSICS))
    nobody = reduced_queue(np.empty((0, len(Parameters._fields))), PHYSICS)
    kernel(nobody, passes.new_lanes(WIDTH), search_pass(Options()), 0)
    return kernel


def generic_drive(rhs: Any, jacobian: Any, sizes: tuple[float, ...]) -> Any:
    """The adaptive drive of y' = rhs(p, t, y); errors count against |y|, or these sizes if more.

    As of `numerics.adaptive.make_adaptive`, compiled.
    """
    width = len(sizes)
    least = make_map(
        "least", "y", (f"1.0 / (abs(y[{i}]) + {sizes[i]!r})" for i in range(width)), {}
    )

    @inline
    def weight(p: Any, y: Any, J: Any) -> Any:
        return least(y)

    @inline
    def ignore(p: Any, t: float, h: float, y0: Any, y1: Any, d1: Any, d2: Any, record: Any) -> None:
        pass

    return make_adaptive(rhs, jacobian, weight, ignore, RODAS4P2, algebra(width))


@inline
def plain_after_success(error: float, remembered: float) -> tuple[float, float]:
    """The plain controller, error^(-1/4), in place of the PI controller."""
    return step_control.after_rejection(larger(error, 1e-10)), remembered
