"""What benchmarks use of the inside of the package: all of it stands here.

A benchmark that counts, times or replaces something below `stickslip.orbit` does so by these
modules alone, so that a change of the kernels touches no other benchmark.
"""

from __future__ import annotations

from inside.fixed import (
    fixed_amplitudes,
    fixed_lanes,
    fixed_period,
    march_assembly,
    reference_period,
    scalar_steps,
)
from inside.kernels import (
    general_kernels,
    generic_drive,
    kernel_without_noise,
    plain_after_success,
    replaced_kernel,
)
from inside.lanes import (
    Attempts,
    attempted,
    attempts_of,
    chosen,
    first_period,
    half_periods,
    lane_end,
    measured,
    search,
    succeeded,
)
from inside.loops import LaneLoops
from inside.scalar import (
    FUNCTIONS,
    adaptive_drive,
    scalar_amplitudes,
    scalar_end,
    scalar_states,
    starting_state,
)
from inside.stages import STAGES, lanes_used, timed_stages
from stickslip.kernels.adaptive.driver import end_states
from stickslip.kernels.euler_cromer.lanes import March
from stickslip.kernels.points import FIRST_STEP
from stickslip.kernels.problem import problem_of
from stickslip.measure.window import error_of_mean

__all__ = [
    "FIRST_STEP",
    "FUNCTIONS",
    "STAGES",
    "Attempts",
    "LaneLoops",
    "March",
    "adaptive_drive",
    "attempted",
    "attempts_of",
    "chosen",
    "end_states",
    "error_of_mean",
    "first_period",
    "fixed_amplitudes",
    "fixed_lanes",
    "fixed_period",
    "general_kernels",
    "generic_drive",
    "half_periods",
    "kernel_without_noise",
    "lane_end",
    "lanes_used",
    "march_assembly",
    "measured",
    "plain_after_success",
    "problem_of",
    "reference_period",
    "replaced_kernel",
    "scalar_amplitudes",
    "scalar_end",
    "scalar_states",
    "scalar_steps",
    "search",
    "starting_state",
    "succeeded",
    "timed_stages",
]
