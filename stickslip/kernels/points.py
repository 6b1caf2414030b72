"""Input and output rows of kernels: parameters and final states."""

from __future__ import annotations

from stickslip.compiled.fields import make_row_reader
from stickslip.model.models import model_of
from stickslip.options import Physics
from stickslip.parameters import ParameterValues

parameters_of = make_row_reader(ParameterValues)
"""Inline: the parameters of a row of numbers in the order of `Parameters._fields`."""

FIRST_STEP = 1e-6
"""The first step as a fraction of the drive period: short against every rate of the paper's
figures, and the controller can lengthen it six-fold with each step."""


def final_columns(physics: Physics) -> tuple[str, ...]:
    """Columns of a final row: the stroboscopic state (x, v, ln phi, ...), the next step."""
    return (*(component.name for component in model_of(physics).components), "step")
