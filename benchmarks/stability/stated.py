"""Is the stated error a bound, and how far is it from the error? By kind of motion and of film.

Films from all over, against the same program at 1e-10.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from common import amplitude_errors, amplitudes, box_points, column, good, parameter, quantile

from stickslip.options import Options
from stickslip.orbit import compute_orbits
from stickslip.regime import Regime

_SEED, _POINTS = 2901, 2400
_TOLERANCES = (1e-4, 1e-6)
_EXACT = 1e-10
_RESOLVED = 1e-10
_FAR = 3.0
_PERIODS = 2000


def run(quick: bool) -> dict[str, Any]:
    """How often the bound held, how much too large it was, and its rank correlation."""
    points = box_points(
        40 if quick else _POINTS,
        _SEED,
        temperature=("linear", 100, 400),
        viscosity_coefficient=("log", 1e3, 1e6),
        spring_stiffness=("log", 100, 5e4),
        angular_frequency=("linear", 1, 100),
        rheological_index=("linear", -0.9, 1),
    )
    exact = _results(points, _EXACT)
    return {
        "points": len(points),
        "tolerances": {str(rtol): _by_kind(points, rtol, exact) for rtol in _TOLERANCES},
    }


def _results(points: np.ndarray, rtol: float) -> np.ndarray:
    options = Options(rtol=rtol, stationary_rtol=rtol, max_periods=_PERIODS, max_error=1.0)
    return compute_orbits(points, options)[0]


def _by_kind(points: np.ndarray, rtol: float, exact: np.ndarray) -> dict[str, Any]:
    found = _results(points, rtol)
    same = column(found, "orbit_periods") == column(exact, "orbit_periods")
    both = good(found) & good(exact) & same
    true = amplitude_errors(points, amplitudes(found), amplitudes(exact)).max(axis=1)
    stated, gamma = column(found, "amplitude_error"), parameter(points, "rheological_index")
    regime, melts = column(found, "regime"), column(found, "melting_count") > 0
    kinds = {
        "all": np.ones(len(points), dtype=bool),
        "stick-slip": melts,
        "liquid": regime == Regime.LIQUID,
        "locked": ~melts & (regime != Regime.LIQUID),
        "gamma<0": gamma < 0.0,
        "gamma>0": gamma > 0.0,
    }
    return {kind: _row(true[both & of], stated[both & of]) for kind, of in kinds.items()}


def _row(true: np.ndarray, stated: np.ndarray) -> dict[str, float]:
    from scipy.stats import spearmanr

    resolved = np.maximum(true, _RESOLVED)
    return {
        "points": len(true),
        "held": float(np.mean(true <= stated + _RESOLVED)),
        "far_off": int(np.sum(true > _FAR * stated + _RESOLVED)),
        "over_median": quantile(stated / resolved, 50),
        "over_95": quantile(stated / resolved, 95),
        "rank_correlation": float(spearmanr(stated, resolved)[0]),
        "true_median": quantile(true, 50),
        "true_max": float(true.max()),
    }
