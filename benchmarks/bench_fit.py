"""Fits of synthetic measurements: the best minima, and how honest their errors are.

`random_1` to `random_4` fit two free parameters of 50 random sets of data each, with noise of 1 and
5 % and without: an hour or so each, so that they are parts of their own. `starts` fits ten forces
from four starts, `three` three parameters at three frequencies. `four` fits k, gamma, T_c and A to
forces and stresses over temperature, where single data jump next to the minimum.
"""

from __future__ import annotations

import statistics
from functools import partial
from itertools import islice
from typing import Any

import numpy as np
import xarray as xr
from shared.fits import FORCE, FOUR, STRESS, Floats, Set, four_set, sets
from shared.measuring import Part, measure
from shared.timing import timed

from stickslip import stationary_orbits
from stickslip.variables import PARAMETERS
from sweeps import fit
from sweeps.config.load import from_mapping
from sweeps.fitting.fitting import model_of
from sweeps.fitting.minima import PATIENCE
from sweeps.measurements import read_data

SETS, QUARTERS, FEW = 200, 4, 2
SCENES, FEW_SCENES = 20, 1

STARTS = ((5e4, -2 / 3), (1e5, -0.8), (5e4, 0.0), (2e4, -0.2))
EXACT = 1e-4
WORSE = 1e-6
"""By what part chi2 may be above that of the true parameters: the roughness of the amplitudes."""


# --- random sets, and four parameters -------------------------------------------------------------


def random(quick: bool, first: int, count: int) -> dict[str, Any]:
    """Fit `count` random sets from the `first` on; count what is wrong."""
    fit({"T": [200, 250, 300], "F_max": [3e-3, 2.5e-3, 2.4e-3]}, "k")  # compiled
    end = first + (FEW if quick else count)
    rows = [_fitted(number, own) for number, own in islice(enumerate(sets(end)), first, end)]
    known = [held for row in rows for held in row["within"].values()]
    exact = [error for row in rows for error in row["exact"].values()]
    return {
        "sets": len(rows),
        "across_jumps": sum(row["crosses"] for row in rows),
        "exceptions": sum(row["exception"] for row in rows),
        "false_minima": sum(row["false"] for row in rows),
        "parameters": len(known),
        "covered": sum(known),
        "undetermined": sum(row["undetermined"] for row in rows),
        "exact_parameters": len(exact),
        "exact_worst": max(exact, default=0.0),
        "exact_beyond": sum(error > EXACT for error in exact),
        "seconds": [row["seconds"] for row in rows],
    }


def four(quick: bool) -> dict[str, Any]:
    """Fit k, gamma, T_c and A to forces and stresses; count the intervals that hold the truth."""
    rows = [_fitted(number, four_set(number)) for number in range(FEW_SCENES if quick else SCENES)]
    held = {name: [row["within"][name] for row in rows if name in row["within"]] for name in FOUR}
    return {
        "sets": len(rows),
        "exceptions": sum(row["exception"] for row in rows),
        "false_minima": sum(row["false"] for row in rows),
        "parameters": {name: len(of) for name, of in held.items()},
        "covered": {name: float(np.mean(of)) if of else None for name, of in held.items()},
        "beside_jumps": sum(row["jump"] for row in rows),
        "seconds": _seconds([row["seconds"] for row in rows]),
    }


def _fitted(number: int, own: Set) -> dict[str, Any]:
    """Return how a set is fitted: what is wrong, and which intervals hold the truth."""
    row: dict[str, Any] = {"exception": 0, "false": 0, "jump": 0, "within": {}, "exact": {}}
    row |= {"crosses": own.crosses, "undetermined": 0, "seconds": 0.0}
    config = from_mapping({"model": own.start})
    try:
        ds, row["seconds"] = timed(lambda: fit(own.data, own.free, config))
        plain = fit(own.exact, own.free, config) if own.exact else None
    except Exception as error:  # noqa: BLE001 - they are counted
        print(number, own, repr(error), flush=True)
        return row | {"exception": 1}
    true_chi2 = _true_chi2(own)
    row["false"] = int(ds.attrs["chi2"] > true_chi2 * (1.0 + WORSE))
    row["jump"] = int((ds.datum_at_jump == 1).any())
    for name in own.free:
        found = ds.sel(free_parameter=name)
        if found.parameter_determination == 0:
            low, high = found.parameter_interval_lower, found.parameter_interval_upper
            row["within"][name] = bool(low <= own.true[name] <= high)
    row["undetermined"] = len(own.free) - len(row["within"])
    row["exact"] = _exact_errors(own, plain) if plain else {}
    odd = row["false"] or max(row["exact"].values(), default=0.0) > EXACT
    print(number, row, flush=True)
    if odd or not all(row["within"].values()):
        print("   ", own, ds.attrs["chi2"], true_chi2, plain and plain.parameter_value.values)
        for what in ("value", "standard_error", "interval_lower", "interval_upper"):
            print("   ", what, ds[f"parameter_{what}"].values, flush=True)
    return row


def _exact_errors(own: Set, plain: xr.Dataset) -> dict[str, float]:
    """Return errors of the parameters that data without noise determine, mostly relative ones."""
    errors = {}
    for name in own.free:
        found = plain.sel(free_parameter=name)
        if found.parameter_determination == 0:
            plainly = PARAMETERS[name].measured_in is not None
            off = abs(float(found.parameter_value) - own.true[name])
            errors[name] = off / (1.0 if plainly else own.true[name])
    return errors


def _true_chi2(own: Set) -> float:
    """Return chi2 at the true parameters."""
    model = model_of(read_data(own.data), own.free, from_mapping({"model": own.true}))
    start = np.array([[each.start for each in model.free]])
    return model.trials(start, PATIENCE)[0].chi2


# --- one minimum from any start -------------------------------------------------------------------


def starts(quick: bool) -> dict[str, Any]:
    """Fit k and gamma to ten forces from each of four starts."""
    places = {"T": np.linspace(160.0, 310.0, 10)}
    return _from_starts(quick, places, {"k": 7e4, "gamma": -0.55}, [FORCE])


def three(quick: bool) -> dict[str, Any]:
    """Fit k, gamma and K to forces and stresses at three frequencies, from each of four starts."""
    temperatures, frequencies = np.linspace(160.0, 280.0, 7), [7.0, 10.0, 20.0]
    places = {"T": np.tile(temperatures, 3), "omega": np.repeat(frequencies, 7)}
    return _from_starts(quick, places, {"k": 7e4, "gamma": -0.55, "K": 4e3}, [FORCE, STRESS])


def _from_starts(
    quick: bool, places: dict[str, Floats], true: dict[str, float], of: list[str]
) -> dict[str, Any]:
    """Return by what part of a standard error fits from all starts differ, and their seconds."""
    ds, rng = stationary_orbits(places | true), np.random.default_rng(1)
    noise = {name: 1.0 + 0.01 * rng.standard_normal(ds[name].size) for name in of}
    data = places | {name: ds[name].values * noise[name] for name in of}
    starts = [{"model": {"k": k, "gamma": gamma}} for k, gamma in STARTS[: 1 if quick else None]]
    fits = [timed(partial(fit, data, list(true), start)) for start in starts]
    values = np.array([found.parameter_value.values for found, _ in fits])
    errors = fits[0][0].parameter_standard_error.values
    return {
        "starts": len(fits),
        "differ": float((np.ptp(values, axis=0) / errors).max()),
        "values": values[0].tolist(),
        "errors": errors.tolist(),
        "seconds": _seconds([seconds for _, seconds in fits]),
    }


def _seconds(seconds: list[float]) -> dict[str, float]:
    return {"median": statistics.median(seconds), "max": max(seconds)}


QUARTER = SETS // QUARTERS
RANDOM: dict[str, Part] = {
    f"random_{number + 1}": partial(random, first=number * QUARTER, count=QUARTER)
    for number in range(QUARTERS)
}
PARTS: dict[str, Part] = {"starts": starts, "three": three, "four": four} | RANDOM

if __name__ == "__main__":
    measure("fit", __doc__, PARTS, long=("four", *RANDOM))
