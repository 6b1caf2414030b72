"""The sweeps of Figs. 7, 8 and 9 one by one: seconds with compiled code ready, and true errors.

Two threads; each sweep runs once as a warm-up and then five times, and the median is the result.
The errors are those against the same sweep at rtol 1e-9.
"""

from __future__ import annotations

import statistics
from typing import TYPE_CHECKING, Any

import numpy as np
from common import AMPLITUDES, amplitude_errors, arguments, finish, median_seconds

from sweeps import run
from sweeps.config.paper import shipped_config
from sweeps.engine.settings import read_config
from sweeps.grid import Grid

if TYPE_CHECKING:
    import xarray as xr

FIGURES = ("fig7", "fig8", "fig9")
WORKERS, RUNS = 2, 5
REFERENCE = ("integrator.rtol=1e-9", "stationary.rtol=1e-9")
COARSE = {
    "fig7": "temperature={linspace: [150, 320], num: 8}",
    "fig8": "viscosity_coefficient={linspace: [1e4, 2e5], num: 8}",
    "fig9": "spring_stiffness={linspace: [100, 1e4], num: 8}",
}


def main() -> None:
    quick = arguments(__doc__).quick
    results = {name: _figure(name, quick=quick) for name in FIGURES}
    finish("figures", {"workers": WORKERS} | results, quick=quick)


def _figure(name: str, *, quick: bool) -> dict[str, Any]:
    changes = (COARSE[name],) if quick else ()
    config = read_config(shipped_config(name), changes)
    ds = run(config, workers=WORKERS)
    exact = run(read_config(shipped_config(name), (*changes, *REFERENCE)), workers=WORKERS)
    grid = Grid.from_config(config)
    errors = amplitude_errors(grid.points(0, grid.size), _amplitudes(ds), _amplitudes(exact))
    known = errors[np.isfinite(errors).all(axis=1)].max(axis=1)
    return {
        "points": int(ds.status.size),
        "failed": int((ds.status != 0).sum()),
        "other_counts_than_reference": int(
            (
                (ds.melting_count != exact.melting_count)
                | (ds.orbit_periods != exact.orbit_periods)
            ).sum()
        ),
        "seconds_median": median_seconds(
            lambda: run(config, workers=WORKERS), 1 if quick else RUNS
        ),
        "periods_integrated_median": statistics.median(
            ds.periods_integrated.values.ravel().tolist()
        ),
        "error_median": float(np.median(known)),
        "error_max": float(known.max()),
        "stated_error_max": float(ds.amplitude_error.max()),
        "power_balance_error_max": float(ds.power_balance_error.max()),
    }


def _amplitudes(ds: xr.Dataset) -> np.ndarray:
    return np.column_stack([ds[name].values.ravel() for name in AMPLITUDES])


if __name__ == "__main__":
    main()
