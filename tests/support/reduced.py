"""Parameters in a point's own units, as tuples."""

from __future__ import annotations

import numpy as np

from stickslip.kernels.euler_cromer.step_units import StepParameters, step_reduction
from stickslip.model.models import model_of
from stickslip.model.scaling import Reduced
from stickslip.options import Physics
from stickslip.parameters import ParameterValues


def reduced_of(p: ParameterValues, physics: Physics) -> Reduced:
    """Return the parameters in the units of the nondimensional model."""
    row = np.empty(len(Reduced._fields))
    model_of(physics).write_reduced(p, row)
    return Reduced(*row.tolist())


def step_parameters_of(p: ParameterValues, steps: int, law: str) -> StepParameters:
    """Return the parameters in the units of a fixed-step lane with `steps` per period."""
    row = np.empty(len(StepParameters._fields))
    step_reduction(law)(p, steps, row)
    return StepParameters(*row.tolist())
