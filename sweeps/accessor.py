"""`import sweeps.accessor` gives Datasets `ds.stickslip`; `sweeps.run` and `simulate` do it too."""

from __future__ import annotations

from sweeps.views.accessor import StickslipAccessor

__all__ = ["StickslipAccessor"]
