"""Euler-Cromer at the paper's step: too slow to be run, so extrapolated from larger steps."""

from __future__ import annotations

import math
import time
from itertools import pairwise
from typing import Any

import numpy as np
from inside.scalar import scalar_end

from curves.series import PERIODS, reference
from stickslip.options import Options
from stickslip.parameters import Parameters

PAPER_DT = 1e-10


def euler_cromer(p: Parameters, ladder: tuple[float, ...], steps: int) -> dict[str, Any]:
    """Measure the paper's scheme at larger steps, and extrapolate to the paper's."""
    exact = reference(np.array(p).tobytes())[0]
    points = [_fixed_run(p, dt, exact) for dt in ladder]
    _fixed_seconds(p, PAPER_DT, 1000)
    per_step = min(_fixed_seconds(p, PAPER_DT, steps) for _ in range(5)) / steps
    steps_a_period = 2 * math.pi / p.angular_frequency / PAPER_DT
    result: dict[str, Any] = {
        "points": points,
        "dt": PAPER_DT,
        "extrapolated": True,
        "ns_per_step": 1e9 * per_step,
        "timed_part_of_a_period": steps / steps_a_period,
        "seconds_per_period": per_step * steps_a_period,
        "error": None,
    }
    if points:
        finest = points[-1]
        result["error"] = finest["error"] * PAPER_DT / finest["dt"]
        ratios = [a["error"] / b["error"] for a, b in pairwise(points)]
        result["error_ratios_at_half_the_step"] = ratios
    error = "not measured" if result["error"] is None else f"{result['error']:.1e}"
    print(
        f"  Euler-Cromer at dt {PAPER_DT:g} s, extrapolated: {result['seconds_per_period']:.0f} s "
        f"per period ({result['ns_per_step']:.1f} ns a step), error {error}",
        flush=True,
    )
    return result


def _fixed_run(p: Parameters, dt: float, reference: float) -> dict[str, Any]:
    """Return error and time of one run over all periods at `dt`."""
    begun = time.perf_counter()
    x = _fixed_end(p, dt, None)
    seconds = (time.perf_counter() - begun) / PERIODS
    error = float(abs(x / abs(p.drive_amplitude) - reference))
    steps = 2 * math.pi / p.angular_frequency / dt
    return {
        "dt": dt,
        "error": error,
        "seconds_per_period": seconds,
        "ns_per_step": 1e9 * seconds / steps,
    }


def _fixed_seconds(p: Parameters, dt: float, steps: int) -> float:
    begun = time.perf_counter()
    _fixed_end(p, dt, steps)
    return time.perf_counter() - begun


def _fixed_end(p: Parameters, dt: float, max_steps: int | None) -> float:
    """Return x after all periods, or anything where the steps did not suffice."""
    options = Options(method="euler-cromer", dt=dt, max_steps=max_steps)
    return scalar_end(np.array(p), options, PERIODS)[0]
