"""Sobol indices of results over a box of parameters (global sensitivity).

Results vary over the box. The first-order index of a parameter is the part of their variance that
would vanish if it were known; its total index is the part that would remain if all others were
known. The estimators are from Saltelli et al. (Comput. Phys. Commun. 181, 259, 2010), as in SciPy.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stickslip.accessors import register_accessors
from stickslip.boxes import BoxError, Design, box_of
from stickslip.datasets import parameter_scalars
from stickslip.options import options_for_orbits
from stickslip.parameters import Parameters
from stickslip.points import orbit_rows, places_of, rows_of
from stickslip.regime import Regime
from stickslip.status import Status
from stickslip.variables import RESULT_COLUMNS, RESULTS, canonical_result

if TYPE_CHECKING:
    import xarray as xr

AMPLITUDES = ("elastic_stress_amplitude", "friction_force_amplitude")

PARAMETER, RESULT, BOUND = "parameter", "result", "bound"
"""The dimensions of indices: the varied parameters, the results, the two ends of an interval."""

LARGEST_MISSING = 0.02
"""The default of the largest share of base points that may lack a result."""

_REGIME, _STATUS = RESULT_COLUMNS.index("regime"), RESULT_COLUMNS.index("status")
_WITH_RESULT = [int(status) for status in Status if status.is_result]

# Results that differ by less than this, relative to the largest, differ by rounding alone.
_EQUAL = 1e-12


def sensitivity_indices(
    box: Mapping[str, Any],
    of: str | Iterable[str] = AMPLITUDES,
    *,
    base_points: int = 1024,
    seed: int = 0,
    confidence: float = 0.95,
    largest_missing: float = LARGEST_MISSING,
    **options: Any,
) -> xr.Dataset:
    """Return the Sobol indices of results over a box of parameters, with confidence intervals.

    With d varied parameters, n base points make (d + 2) n points, all computed together.

    >>> box = {"T": (180, 280), "k": {"log": (2e4, 2e5)}}
    >>> ds = sensitivity_indices(box, "friction_force_amplitude", base_points=64)
    >>> ds.total_order[0].round(1).values.tolist()
    [0.9, 0.1]

    Parameters
    ----------
    box
        Parameters by name or symbol, each with a pair (low, high) to draw it evenly between these
        values, `{"log": (low, high)}` to draw it evenly in its logarithm, `{"normal": (mean,
        deviation)}` or `{"lognormal": (median, deviation of ln)}`, or a number to fix it.
        Parameters are drawn independently.
    of
        Names or symbols of results, from `variables.RESULTS`.
    base_points
        The number n, a power of 2.
    seed
        Seed of the scrambled sequence and of the bootstrap.
    confidence
        Confidence level of the intervals, from a BCa bootstrap over base points.
    largest_missing
        The largest share of base points that may be left out because a point has no result.
    **options
        As for `stationary_orbit`.

    Returns
    -------
    xarray.Dataset
        `first_order` and `total_order` over `result` and `parameter`; `first_order_interval` and
        `total_order_interval`, with the further dimension `bound`; `mean` and `standard_deviation`
        of each result, in its unit; `regime_share`, the share of all points in each `regime`; the
        box as `distribution` (in words), `low`, `high` (where it ends) and `logarithmic` over
        `parameter`. Indices are NaN for a result that
        does not vary, and intervals for one that varies at so few points that a sample of the
        bootstrap has none of them. The attributes give the number of base points, and of those left
        out.

    Raises
    ------
    BoxError
        The box has no range or an invalid one, a result is unknown or named twice, a level or share
        is out of range, the number of base points is not a power of 2, or the share of those
        without a result exceeds `largest_missing`.
    ParameterError, TypeError, OptionError, NoiseError
        As for `stationary_orbits`.
    """
    refuse_confidence(confidence)
    refuse_share(largest_missing)
    ranges, fixed = box_of(box)
    results, chosen = results_named(of), options_for_orbits(**options)
    design = Design.of(ranges, base_points, seed)
    points: dict[str, Any] = {**design.points(), **fixed}
    places = places_of(points)
    rows = orbit_rows(rows_of(places), chosen)
    ds = indices_of(
        design, rows, results, seed=seed, confidence=confidence, largest_missing=largest_missing
    )
    constant = {n: places[n].item() for n in Parameters._fields if n not in ranges}
    register_accessors()
    return ds.assign_coords(parameter_scalars(constant))


def results_named(of: str | Iterable[str]) -> list[str]:
    """Return the full names of results; raises BoxError for an unknown one, or for none."""
    given = [of] if isinstance(of, str) else list(of)
    names = [canonical_result(name) or name for name in given]
    unknown = [name for name in names if name not in RESULTS or name in ("status", "regime")]
    if unknown or not names:
        what = f"there is no result {', '.join(unknown)}" if unknown else "no result is named"
        numbers = [name for name in RESULTS if name not in ("status", "regime")]
        raise BoxError(f"of: {what}; there are {', '.join(numbers)}")
    if twice := [name for name in dict.fromkeys(names) if names.count(name) > 1]:
        raise BoxError(f"of: {', '.join(twice)} is named twice; leave one out")
    return names


def refuse_confidence(confidence: float) -> None:
    """Raise BoxError for a confidence level that is not between 0 and 1."""
    if not 0.0 < confidence < 1.0:
        raise BoxError(f"confidence must be between 0 and 1, not {confidence:g}")


def refuse_share(largest_missing: float) -> None:
    """Raise BoxError for a share of missing base points that is not from 0 to 1."""
    if not 0.0 <= largest_missing <= 1.0:
        raise BoxError(
            f"the largest share of missing base points must be from 0 to 1, not {largest_missing:g}"
        )


def indices_of(
    design: Design,
    rows: NDArray[np.float64],
    results: list[str],
    *,
    seed: int = 0,
    confidence: float = 0.95,
    largest_missing: float = LARGEST_MISSING,
) -> xr.Dataset:
    """Return the indices of results from the rows ((d + 2) n, columns) of a design."""
    import xarray as xr

    shape = (len(design.box) + 2, -1)
    outputs = np.stack([rows[:, RESULT_COLUMNS.index(r)].reshape(shape) for r in results])
    # Counts of a point without a result are finite: -1, or the periods computed in vain.
    computed = np.isin(rows[:, _STATUS], _WITH_RESULT).reshape(shape)
    used = np.asarray((np.isfinite(outputs) & computed).all(axis=(0, 1)))
    lost = int((~used).sum())
    if lost > largest_missing * used.size or used.sum() < 2:
        rare = [
            name
            for name, values in zip(results, outputs, strict=True)
            if not RESULTS[name].always and np.isnan(values[computed]).any()
        ]
        if rare and (~computed).any(axis=0).sum() <= largest_missing * used.size:
            raise BoxError(
                f"of: not every motion in the box has {' and '.join(rare)}; leave it out, or "
                "take a box of one kind of motion"
            )
        raise BoxError(
            f"{lost} of {used.size} base points include a point without a result; this is more "
            f"than the allowed {largest_missing:.3g}, so the indices would describe another box; "
            "take a smaller box, more drive periods (max_periods), or a larger share"
        )
    estimates = [
        _estimate(np.compress(used, values, axis=1), confidence, np.random.default_rng(seed))
        for values in outputs
    ]
    kept = rows.reshape(*outputs.shape[1:], -1)[:, used, _REGIME]
    by_parameter, by_bound = (RESULT, PARAMETER), (RESULT, PARAMETER, BOUND)
    ranges = list(design.box.values())
    ds = xr.Dataset(
        {
            "mean": (RESULT, outputs[:, :2, used].mean(axis=(1, 2))),
            "standard_deviation": (RESULT, outputs[:, :2, used].std(axis=(1, 2))),
            "regime_share": ("regime", [float(np.mean(kept == code)) for code in Regime]),
        },
        coords={
            RESULT: results,
            PARAMETER: list(design.box),
            BOUND: ["low", "high"],
            "regime": [code.name.lower() for code in Regime],
            "distribution": (PARAMETER, [str(r) for r in ranges]),
            "low": (PARAMETER, [r.low for r in ranges]),
            "high": (PARAMETER, [r.high for r in ranges]),
            "logarithmic": (PARAMETER, [r.logarithmic for r in ranges]),
            "result_units": (RESULT, [RESULTS[name].units for name in results]),
        },
        attrs={
            "base_points": used.size,
            "base_points_without_result": lost,
            "points": len(rows),
            "confidence_level": confidence,
            "seed": seed,
        },
    )
    indices, intervals = (np.stack(each, axis=1) for each in zip(*estimates, strict=True))
    for place, order in enumerate(("first_order", "total_order")):
        ds[order] = (by_parameter, indices[place])
        ds[f"{order}_interval"] = (by_bound, intervals[place])
        ds[order].attrs["long_name"] = f"{order.replace('_', '-')} Sobol index"
        ds[f"{order}_interval"].attrs["long_name"] = f"confidence interval of {order}"
    return ds


def _estimate(
    values: NDArray[np.float64], confidence: float, rng: np.random.Generator
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the indices (2, d) of one result (d + 2, n), and their intervals (2, d, 2).

    First come the first-order, then the total indices; all are NaN if the result does not vary. An
    interval is NaN if the result does not vary in a sample of the bootstrap.
    """
    from scipy.stats import bootstrap

    parameters = len(values) - 2
    least = _EQUAL * np.abs(values).max()
    if np.ptp(values) <= least:
        return np.full((2, parameters), np.nan), np.full((2, parameters, 2), np.nan)
    # The mean is subtracted because the variance of the estimate would grow with it.
    centred = values - values[:2].mean()
    indices = saltelli(centred)

    def resampled(drawn: NDArray[np.intp]) -> NDArray[np.float64]:
        sample = centred[:, drawn]
        return saltelli(sample) if np.ptp(sample) > least else np.full_like(indices, np.nan)

    with warnings.catch_warnings():
        # A parameter without influence has the index 0 in every sample, and so no interval.
        warnings.filterwarnings("ignore", "The BCa confidence interval cannot be calculated")
        warnings.filterwarnings("ignore", "invalid value", RuntimeWarning)
        found = bootstrap(
            (np.arange(values.shape[1]),),
            resampled,
            confidence_level=confidence,
            vectorized=False,
            rng=rng,
        ).confidence_interval
    intervals = np.stack([found.low, found.high], axis=-1)
    without_influence = (values[2:] == values[0]).all(axis=1)[:, None]
    return indices, np.where(without_influence, indices[..., None], intervals)


def saltelli(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the first-order and total indices (2, d) of values (d + 2, n) with mean 0.

    The rows belong to A, to B, then to the mixtures. Saltelli et al. (2010), Table 2, (b) and (f).
    """
    in_A, in_B, mixed = values[0], values[1], values[2:]
    variance = np.var(values[:2])
    first = np.mean(in_B * (mixed - in_A), axis=1) / variance
    total = 0.5 * np.mean((in_A - mixed) ** 2, axis=1) / variance
    return np.stack([first, total])
