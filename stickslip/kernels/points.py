"""What goes into a kernel and what comes out: rows of parameters, final states."""

from __future__ import annotations

from stickslip.compiled.fields import make_row_reader
from stickslip.model.state import STATE
from stickslip.parameters import ParameterValues

parameters_of = make_row_reader(ParameterValues)
"""Inline: the parameters held by a row of numbers in the order of `Parameters._fields`."""

FINAL_COLUMNS = (*(component.name for component in STATE), "step")
"""Columns of a final row: the stroboscopic state (x, v, ln phi) on the orbit, the next step."""

FIRST_STEP = 1e-6
"""The first step as a part of the drive period: short against every rate of the paper's figures,
and the controller lengthens it six-fold a step."""
