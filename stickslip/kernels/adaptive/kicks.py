"""Stochastic noise in the adaptive method, a random kick after every accepted step of a lane.

Only stochastic films import this module, and only their kernels contain its functions.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from stickslip.compiled.decorators import inline, jit
from stickslip.compiled.simd import LANES, for_lanes
from stickslip.kernels.adaptive.recording import SLOTS, get, put, step_reader, stream_begin
from stickslip.kernels.problem import Problem
from stickslip.kernels.streams import KEY_HIGH, KEY_LOW, PATH, PERIOD, normal_number
from stickslip.model.chance import bending, disturbed, make_deviation
from stickslip.model.state import FILM
from stickslip.numerics.linear import algebra
from stickslip.parameters import Parameters

# Within a step the drift may deviate this much from a linear one over the width of the noise.
_MOST_BENDING = 0.1


@inline
def after_kick(
    p: Parameters, psi: float, deviation: float, h: float, xi: float
) -> tuple[float, float]:
    """ln(phi) after the noise of a step of length `h`, and the longest next step allowed."""
    bent = bending(p, psi, deviation, h)
    longest = h * (_MOST_BENDING / bent) if bent > _MOST_BENDING else np.inf
    return disturbed(psi, deviation, xi), longest


def make_kick(problems: Callable[..., Problem], width: int) -> Any:
    """Return the function (lanes) that adds the noise of the last step if it was accepted."""
    deviation_of, step_of = make_deviation(algebra(width).interpolate), step_reader(width)
    first = stream_begin(width)

    @inline
    def lane_kick(lane: int, lanes: np.ndarray) -> None:
        p, step = problems(lanes, lane).p, step_of(lanes, lane)
        # The number of the attempt identifies the step, so no counter of draws is needed.
        low, high = get(lanes, first + KEY_LOW, lane), get(lanes, first + KEY_HIGH, lane)
        path, period = get(lanes, first + PATH, lane), get(lanes, first + PERIOD, lane)
        xi = normal_number(low, high, path, period, get(lanes, SLOTS.attempts, lane))
        deviation = deviation_of(p, step.used, step.y0, step.y1, step.d1, step.d2)
        psi, longest = after_kick(p, step.y1[FILM], deviation, step.used, xi)
        # Choices replace branches, so a lane whose step was rejected draws a number in vain.
        accepted, h = get(lanes, SLOTS.accepted, lane) > 0.0, get(lanes, SLOTS.step, lane)
        put(lanes, SLOTS.state + FILM, lane, psi if accepted else step.y1[FILM])
        put(lanes, SLOTS.step, lane, longest if accepted and longest < h else h)

    @jit
    def kick(lanes: np.ndarray) -> None:
        for_lanes(LANES, lane_kick, (lanes,))

    return kick
