"""Refined against full: points computed, wrong pixels and time of a map of regimes.

The map of `configs/regimes.yaml` is computed in full and refined, in turn. Other refinements are
played through on the full map: which points they would ask for, and how wrong the rest would be.
A pixel is wrong where its regime or status is another one, or where an amplitude misses by more
than its stated error.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from common import arguments, finish, timed

from stickslip.status import Status
from stickslip.variables import RESULT_COLUMNS
from sweeps.config.load import load
from sweeps.config.order import Refine
from sweeps.config.paper import shipped_config
from sweeps.engine.in_memory import compute
from sweeps.engine.order.refine import Refinement
from sweeps.engine.settings import options_of
from sweeps.grid import Grid

QUICK = ["T={linspace: [150, 300], num: 33}", "omega={linspace: [5, 60], num: 33}"]
LEVELS = (1, 2, 3, 4, 5)
MISSES = (None, 1e-1, 3e-2, 1e-2, 3e-3)

STATUS, ERROR, REGIME = (
    RESULT_COLUMNS.index(name) for name in ("status", "amplitude_error", "regime")
)
AMPLITUDES = [
    RESULT_COLUMNS.index(f"{name}_amplitude") for name in ("elastic_stress", "friction_force")
]
FLOOR = 0.01  # of the largest value, below which amplitudes are compared with that


def main() -> None:
    options = arguments(__doc__)
    config = load(shipped_config("regimes"), QUICK if options.quick else ())
    grid, chosen = Grid.from_config(config), config.refine
    assert chosen is not None
    _warm_up(config, grid)
    unrefined = config.model_copy(update={"refine": None})
    full, full_seconds = timed(lambda: compute(unrefined, workers=2))
    refined, seconds = timed(lambda: compute(config, workers=2))
    results: dict[str, Any] = {
        "points": grid.size,
        "refine": chosen.resolved(),
        "full_seconds": full_seconds,
        "refined_seconds": seconds,
        "refined": _compared(grid, full, refined),
        "curve": [
            {"levels": levels, "where": _named(miss)}
            | _played(grid, full, Refine(chosen.axes, levels, miss))
            for levels in LEVELS
            for miss in MISSES
        ],
    }
    finish("refinement", results, quick=options.quick)


def _named(miss: float | None) -> str:
    return "regime" if miss is None else f"regime, {miss:g}"


def _warm_up(config: Any, grid: Grid) -> None:
    from sweeps.engine.executors.kernels import compile_kernels

    compile_kernels(options_of(config), grid)


def _played(grid: Grid, full: np.ndarray, refine: Refine) -> dict[str, Any]:
    """What a refinement would give, with the values of the full map."""
    rows, refinement = np.full_like(full, np.nan), Refinement(refine, grid)
    for needed in refinement.rounds(lambda: rows):
        rows[needed] = full[needed]
    numbers, values = refinement.interpolated(rows)
    rows[numbers] = values
    return _compared(grid, full, rows)


def _compared(grid: Grid, full: np.ndarray, found: np.ndarray) -> dict[str, Any]:
    """Points computed, and what is wrong with the others."""
    filled = found[:, STATUS] == Status.INTERPOLATED
    status = np.where(filled, float(Status.OK), found[:, STATUS])
    kind = (found[:, REGIME] != full[:, REGIME]) | (status != full[:, STATUS])
    missed = np.zeros(len(full), dtype=bool)
    for column in AMPLITUDES:
        scale = np.maximum(full[:, column], FLOOR * np.nanmax(full[:, column]))
        off = np.abs(found[:, column] - full[:, column]) / scale
        missed |= filled & ~kind & (off > found[:, ERROR] + full[:, ERROR])
    stated = found[filled, ERROR]
    return {
        "computed": int((~filled).sum()),
        "computed_part": float((~filled).mean()),
        "wrong_kind": int(kind.sum()),
        "missed": int(missed.sum()),
        "wrong_part": float((kind | missed).mean()),
        "stated_error_median": float(np.median(stated)) if filled.any() else 0.0,
        "stated_error_max": float(stated.max(initial=0.0)),
        "wrong": _where(grid, np.flatnonzero(kind | missed)),
    }


def _where(grid: Grid, numbers: np.ndarray) -> list[list[float]]:
    """Temperature and frequency of some of the points."""
    return [[round(row[0], 4), round(row[4], 4)] for row in grid.rows(numbers[:200]).tolist()]


if __name__ == "__main__":
    main()
