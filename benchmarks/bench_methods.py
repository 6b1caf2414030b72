"""Steps and errors of the adaptive method in its variants: tableau and cusp safeguard.

Error of (x/X_m, v/(X_m omega)) after three drive periods from rest against the same method at
1e-12, and attempted steps a period, for a ladder of tolerances and three fluids.
"""

from __future__ import annotations

import math

import numpy as np
from environment import write_results

from stickslip.compiled import jit
from stickslip.kernels.methods import error_scale
from stickslip.model.rhs import jacobian, rhs, starting_state
from stickslip.numerics import adaptive
from stickslip.numerics.tableaus import RODAS4, RODAS4P, RosenbrockTableau
from stickslip.parameters import Parameters, ParameterValues

PERIODS = 3
LADDER = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)
SCENES = {
    "gamma=-2/3": Parameters(),
    "gamma=-2/3, omega=38": Parameters(angular_frequency=38),
    "gamma=0": Parameters(rheological_index=0),
    "gamma=2/3": Parameters(rheological_index=2 / 3),
}
VARIANTS = {
    "RODAS4P": (RODAS4P, adaptive._DEFECT_WEIGHT),
    "RODAS4P without defect estimate": (RODAS4P, 0.0),
    "RODAS4": (RODAS4, adaptive._DEFECT_WEIGHT),
}


def main() -> None:
    reference = {
        name: _final(_run(*VARIANTS["RODAS4P"]), p, 1e-12)[0] for name, p in SCENES.items()
    }
    results = []
    for variant, (tableau, weight) in VARIANTS.items():
        run = _run(tableau, weight)
        for scene, p in SCENES.items():
            for rtol in LADDER:
                state, steps = _final(run, p, rtol)
                error = float(np.abs(state - reference[scene])[:2].max())
                row = {"variant": variant, "scene": scene, "rtol": rtol}
                results.append(row | {"steps_per_period": steps / PERIODS, "error": error})
                print(f"{variant:34}{scene:24}{rtol:8.0e}{steps / PERIODS:10.0f}{error:12.1e}")
    print(write_results("methods", results))


def _run(tableau: RosenbrockTableau, defect_weight: float):
    """The compiled integration of PERIODS drive periods with one variant."""
    kept, adaptive._DEFECT_WEIGHT = adaptive._DEFECT_WEIGHT, defect_weight
    drive = adaptive.make_adaptive(rhs, jacobian, error_scale, _ignore, tableau)

    @jit
    def run(p, rtol):
        period = 2.0 * math.pi / p.angular_frequency
        y, h, total = starting_state(p), 1e-6 * period, 0
        for _ in range(PERIODS):
            y, h, steps, _ = drive(p, rtol, 0.0, period, y, h, 10**9, 0)
            total += steps
        return y, total

    run(ParameterValues(*Parameters()), 1e-3)  # compiles, and freezes the weight into the code
    adaptive._DEFECT_WEIGHT = kept
    return run


@jit
def _ignore(p, t, h, y0, y1, d1, d2, record):
    pass


def _final(run, p: Parameters, rtol: float) -> tuple[np.ndarray, int]:
    """The scaled state after PERIODS drive periods, and the steps that it took."""
    (x, v, psi), steps = run(ParameterValues(*p), rtol)
    scale = np.array([p.drive_amplitude, p.drive_amplitude * p.angular_frequency, 1.0])
    return np.array([x, v, psi]) / scale, steps


if __name__ == "__main__":
    main()
