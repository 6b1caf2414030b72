"""Steps and errors of the adaptive method in its variants: tableau, cusp, weights, step control.

Error of (x/X_m, v/(X_m omega)) after three drive periods from rest against the package's own
variant at 1e-12 without a rounded cusp, and attempted steps a period, over a ladder of tolerances
and four scenes. The scalar drive: its steps are those of the lanes.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any, NamedTuple
from unittest.mock import patch

import numpy as np
from common import arguments, finish
from inside import FIRST_STEP, FUNCTIONS, adaptive_drive, plain_after_success, problem_of
from parts.other_tableaus import RODAS4, RODAS4P

from stickslip.compiled.decorators import inline, jit
from stickslip.kernels.problem import Problem
from stickslip.model.rhs import relative_state, starting_state
from stickslip.numerics import adaptive, step_control
from stickslip.numerics.tableaus import RODAS4P2, RosenbrockTableau
from stickslip.parameters import Parameters, ParameterValues

PERIODS = 3
LADDER = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)
REFERENCE_RTOL = 1e-12
COMPARED_AT = (1e-4, 1e-6, 1e-8)  # errors at which steps are compared
SCENES = {
    "gamma=-2/3": Parameters(),
    "gamma=-2/3, omega=38": Parameters(angular_frequency=38),
    "gamma=0": Parameters(rheological_index=0),
    "gamma=2/3": Parameters(rheological_index=2 / 3),
}
OWN = "RODAS4P2"

error_weight = FUNCTIONS.error_weight


@inline
def weight_without_relief(problem: Any, y: Any, J: Any) -> Any:
    """The error weights, with ln(phi) counting as much where the noise forgets its error."""
    x, v, _ = error_weight(problem, y, J)
    return x, v, 1.0 / (1.0 + abs(y[2]))


@inline
def no_defect(f1: Any, LU: Any, y0: Any, y1: Any, d1: Any, d2: Any, h: float) -> Any:
    """Nothing, in place of the error that is seen from the end of a step."""
    return 0.0, 0.0, 0.0


class Variant(NamedTuple):
    """A tableau, error weights, the rounding of the cusp (1: the package's), what is replaced."""

    tableau: RosenbrockTableau = RODAS4P2
    weight: Callable[..., Any] = error_weight
    rounding: float = 1.0
    replaced: tuple[tuple[Any, str, Any], ...] = ()


VARIANTS = {
    OWN: Variant(),
    "RODAS4P": Variant(RODAS4P),
    "RODAS4": Variant(RODAS4),
    "without the rounded cusp": Variant(rounding=0.0),
    "without relief for ln(phi)": Variant(weight=weight_without_relief),
    "without the PI controller": Variant(
        replaced=((step_control, "after_success", plain_after_success),)
    ),
    "without the defect estimate": Variant(
        replaced=((adaptive, "make_defect_error", lambda _algebra: no_defect),)
    ),
}
QUICK = (OWN, "without the rounded cusp")


def main() -> None:
    quick = arguments(__doc__).quick
    ladder = LADDER[1:5:2] if quick else LADDER
    own = _compiled(VARIANTS[OWN])
    reference = {name: _end(own, p, REFERENCE_RTOL, 0.0)[0] for name, p in SCENES.items()}
    rows = []
    for name in QUICK if quick else VARIANTS:
        variant = VARIANTS[name]
        same_code = variant._replace(rounding=1.0) == VARIANTS[OWN]
        run = own if same_code else _compiled(variant)
        for scene, p in SCENES.items():
            for rtol in ladder:
                state, steps, status = _end(run, p, rtol, variant.rounding)
                error = float(np.abs(state - reference[scene])[:2].max())
                row = {"variant": name, "scene": scene, "rtol": rtol, "status": status}
                rows.append(row | {"steps_per_period": steps / PERIODS, "error": error})
                note = "" if status == adaptive.OK else f"  status {status}"
                print(f"{name:30}{scene:24}{rtol:8.0e}{steps / PERIODS:10.0f}{error:12.1e}{note}")
    finish("methods", {"own": OWN, "compared": _compared(rows), "rows": rows}, quick=quick)


@inline
def start(p):
    return relative_state(p, 0.0, starting_state(p))


def _compiled(variant: Variant) -> Any:
    """The compiled integration of PERIODS drive periods with a variant."""
    with ExitStack() as stack:
        for module, name, value in variant.replaced:
            stack.enter_context(patch.object(module, name, value))
        drive = adaptive_drive(variant.weight, _ignore, variant.tableau)

        @jit
        def run(p, rtol, rounding, most):
            usual = problem_of(p, rtol)
            problem = Problem(p, rounding * usual.u_s, usual.phases)
            period = 2.0 * math.pi / p.angular_frequency
            y, h, total, status = start(p), FIRST_STEP * period, 0, 0
            for _ in range(PERIODS):
                if status == 0:
                    y, h, steps, status = drive(problem, rtol, 0.0, period, y, h, most, 0)
                    total += steps
            return y, total, status

        run(ParameterValues(*Parameters()), 1e-3, 0.0, 10)  # compiles with what is replaced
    return run


@jit
def _ignore(p, t, h, y0, y1, d1, d2, record):
    pass


def _end(run: Any, p: Parameters, rtol: float, rounding: float) -> tuple[np.ndarray, int, int]:
    """The scaled state after PERIODS drive periods, the attempted steps, the status."""
    V_m = abs(p.drive_amplitude) * p.angular_frequency
    (x, u, psi), steps, status = run(ParameterValues(*p), rtol, rounding, 10**7)
    return np.array([x / abs(p.drive_amplitude), u / V_m, psi]), steps, status


def _compared(rows: list[dict[str, Any]]) -> dict[str, dict[str, float]]:
    """Steps at equal error as parts of those of the package's own variant, scene by scene.

    Geometric means over three errors, on straight lines through log(steps) over log(error): the
    error of a single tolerance is large or small by luck.
    """
    names = list(dict.fromkeys(row["variant"] for row in rows))
    steps = {(name, scene): _log_steps(rows, name, scene) for name in names for scene in SCENES}
    return {
        name: {scene: math.exp(steps[name, scene] - steps[OWN, scene]) for scene in SCENES}
        for name in names
        if name != OWN
    }


def _log_steps(rows: list[dict[str, Any]], name: str, scene: str) -> float:
    chosen = [row for row in rows if (row["variant"], row["scene"]) == (name, scene)]
    logs = np.log([[max(r["error"], 1e-15), r["steps_per_period"]] for r in chosen])
    fit = np.polyfit(logs[:, 0], logs[:, 1], 1)
    return float(np.polyval(fit, np.log(COMPARED_AT)).mean())


if __name__ == "__main__":
    main()
