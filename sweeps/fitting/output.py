"""A fit as a Dataset: the fitted curve as a sweep, and beside it data, parameters, statistics."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
import xarray as xr
from uncertainties import ufloat

from stickslip.datasets import result_attributes, result_values
from stickslip.regime import Regime
from stickslip.status import Status
from stickslip.variables import PARAMETERS, RESULT_COLUMNS
from sweeps.config.load import Config, from_mapping
from sweeps.engine.run import run_in_memory
from sweeps.fitting.least_squares import Fit
from sweeps.fitting.minima import PATIENCE
from sweeps.fitting.posterior import Posterior
from sweeps.fitting.statistics import LEVEL, Determination, Statistics
from sweeps.human import counted
from sweeps.measurements import Floats

DATUM, FREE, OTHER = "datum", "free_parameter", "other_parameter"
"""The dimensions of data and of free parameters."""

CHAIN, DRAW = "chain", "draw"
"""The dimensions of a posterior, by the names that ArviZ has for them."""

QUANTILES = {"lower": 0.5 - LEVEL / 2.0, "median": 0.5, "upper": 0.5 + LEVEL / 2.0}

_CURVE = 101  # points of a fitted curve
_FEW = 8  # values that are worth a curve each
# What the data of a machine rarely say, and differs from the paper's.
_MACHINE = (
    "temperature", "angular_frequency", "drive_amplitude", "spring_stiffness", "block_mass",
    "film_thickness", "contact_area",
)  # fmt: skip
_PERIODS = RESULT_COLUMNS.index("periods_integrated")
_DECADE = 10.0  # an axis that spans more is logarithmic

RELATIVE = (
    "none were given: residuals are relative to the values, with a common unknown factor that "
    "chi2/dof estimates"
)
GIVEN = "those of the data; standard errors grow with the root of chi2/dof where that is above 1"


def fit_dataset(
    fit: Fit,
    known: Statistics,
    config: Config,
    profile: Floats | None,
    posterior: Posterior | None,
    trials: int,
) -> xr.Dataset:
    """Return the file of a fit: the sweep of the fitted curve, with the fit beside it.

    Along `datum`: `measured_value`, `measured_error`, `fitted_value`, `residual`, and so on; along
    `free_parameter`: `parameter_value`, `parameter_standard_error`, and so on.
    """
    curve = run_in_memory(curve_config(fit, config), workers=fit.model.workers)
    about = {
        "chi2": fit.trial.chi2,
        "degrees_of_freedom": fit.dof,
        "reduced_chi2": fit.reduced,
        "measurement_errors": RELATIVE if fit.model.data.relative else GIVEN,
        "trials": trials,
    }
    data = _of_data(fit, known) | _of_parameters(fit, known, profile)
    if posterior is not None:
        data |= _of_posterior(fit, posterior)
        about |= _about_posterior(posterior)
    names = (FREE, [each.name for each in fit.model.free])
    along = {
        "datum_variable": (DATUM, list(fit.model.data.variable), {"long_name": "what was measured"})
    }
    return curve.assign(data).assign_coords({FREE: names} | along).assign_attrs(about)


def curve_config(fit: Fit, config: Config) -> Config:
    """Return the config whose sweep is the fitted curve, through the range of the data.

    Over the parameter with the most values, with a curve for each of the few values of another; at
    the data themselves where there is no such order.
    """
    data, free = fit.model.data, fit.model.free
    varied = {name: values for name, values in data.parameters.items() if np.ptp(values) > 0}
    given = {name: float(values[0]) for name, values in data.parameters.items()}
    fitted = {each.name: float(each.value(u)) for each, u in zip(free, fit.trial.u, strict=True)}
    model = fit.model.fixed._asdict() | given | fitted
    axes = dict(sorted(varied.items(), key=lambda item: -len(np.unique(item[1]))))
    written: dict[str, Any] = config.resolved() | {"sweep": {}, "cases": {}}
    written["model"] = {name: value for name, value in model.items() if name not in varied}
    if np.max(fit.trial.results[:, _PERIODS]) <= PATIENCE.periods:  # as much as the data needed
        written["stationary"]["max_periods"] = min(config.stationary.max_periods, PATIENCE.periods)
    names = ", ".join(each.name for each in free)
    written["title"] = config.title or f"Fit of {names} to {counted(len(data.value), 'value')}"
    others = [*axes][1:]
    if len(others) <= 1 and all(len(np.unique(axes[name])) <= _FEW for name in others):
        written["sweep"] = {name: _axis(axes[name]) for name in [*axes][:1]}
        written["sweep"] |= {name: np.unique(axes[name]).tolist() for name in others}
    else:
        written["cases"] = {name: values.tolist() for name, values in varied.items()}
    return from_mapping(written, "the fitted curve")


def _axis(values: Floats) -> dict[str, Any]:
    low, high = float(values.min()), float(values.max())
    geometric = low > 0 and high / low > _DECADE
    return {"geomspace" if geometric else "linspace": [low, high], "num": _CURVE}


def _of_data(fit: Fit, known: Statistics) -> dict[str, Any]:
    data, trial = fit.model.data, fit.trial
    regimes, statuses = (
        result_values(name, trial.results[data.row, RESULT_COLUMNS.index(name)])
        for name in ("regime", "status")
    )
    # Where none were given, errors are as large as the residuals say.
    errors = data.error * np.sqrt(fit.reduced) if data.relative else data.error
    with np.errstate(invalid="ignore", divide="ignore"):  # an exact fit has no errors
        residuals = (data.value - trial.fitted) / errors
    jumps = np.where(fit.at_jump, 1, np.where(known.jumps, 2, 0))
    changes = "whether the motion changes within the step of a derivative, or within the intervals"
    unit = {"comment": "in the unit of the variable, datum_variable"}
    variables: dict[str, Any] = {
        "measured_value": (DATUM, data.value, _named("measured value", unit)),
        "measured_error": (DATUM, errors, _named("standard error of the value", unit)),
        "fitted_value": (DATUM, trial.fitted, _named("fitted value", unit)),
        "residual": (
            DATUM,
            residuals,
            _named("measured minus fitted value, in standard errors", {"units": "1"}),
        ),
        "datum_row": (DATUM, data.row.astype(np.int32), _named("row of the data")),
        "datum_regime": (DATUM, regimes, result_attributes("regime")),
        "datum_status": (DATUM, statuses, result_attributes("status")),
        "datum_at_jump": (
            DATUM,
            jumps.astype(np.int8),
            _named(f"{changes} of the parameters", _flags("smooth at_jump jumps_within_intervals")),
        ),
    }
    for name, values in data.parameters.items():
        variables[f"datum_{name}"] = (DATUM, values[data.row], dict(PARAMETERS[name].attributes))
    return variables


def _of_parameters(fit: Fit, known: Statistics, profile: Floats | None) -> dict[str, Any]:
    free = fit.model.free
    places = [*zip(free, fit.trial.u, strict=True)]
    named = (f"{each.name}: {PARAMETERS[each.name].unit or 1}" for each in free)
    units = {"comment": f"in {'; '.join(named)}"}
    forms = {"form": " ".join(each.form for each in free)}
    values = np.array([float(each.value(u)) for each, u in places])
    errors = known.errors * np.array([each.slope(u) for each, u in places])
    starts = np.array([float(each.value(each.start)) for each in free])
    meanings = _flags(" ".join(code.name.lower() for code in Determination))
    variables: dict[str, Any] = {
        "parameter_value": (FREE, values, _named("fitted value", units)),
        "parameter_standard_error": (
            FREE,
            errors,
            _named("standard error of the fitted value", units | forms),
        ),
        "parameter_start": (FREE, starts, _named("start of the fit", units)),
        "parameter_determination": (
            FREE,
            known.determination,
            _named("what the data say of the parameter", meanings),
        ),
        "parameter_correlation": (
            (FREE, OTHER),
            known.correlations,
            _named("correlation of the errors of two parameters", {"units": "1"}),
        ),
    }
    intervals = {"interval": (known.intervals, "standard error")}
    if profile is not None:
        intervals["profile"] = (profile, "profile likelihood")
    for name, (ends, method) in intervals.items():
        pairs = [np.sort(each.value(pair)) for each, pair in zip(free, ends, strict=True)]
        for side, column in zip(("lower", "upper"), np.array(pairs).T, strict=True):
            what = f"{side} end of the {100 * LEVEL:g} % interval by the {method}"
            variables[f"parameter_{name}_{side}"] = (FREE, column, _named(what, units))
    return variables


def _of_posterior(fit: Fit, posterior: Posterior) -> dict[str, Any]:
    free, draws = fit.model.free, np.moveaxis(posterior.places, -1, 0)
    named = (f"{each.name}: {PARAMETERS[each.name].unit or 1}" for each in free)
    units = {"comment": f"in {'; '.join(named)}"}
    drawn = np.array([each.value(own) for each, own in zip(free, draws, strict=True)])
    variables: dict[str, Any] = {
        "posterior_draws": (
            (FREE, CHAIN, DRAW),
            drawn,
            _named("values drawn with their probability", units),
        ),
        "posterior_log_probability": (
            (CHAIN, DRAW),
            posterior.logs,
            _named("logarithm of their probability, up to a constant", {"units": "1"}),
        ),
    }
    quantiles = np.quantile(drawn, list(QUANTILES.values()), axis=(1, 2))
    for (name, level), values in zip(QUANTILES.items(), quantiles, strict=True):
        variables[f"parameter_posterior_{name}"] = (
            FREE,
            values if posterior.settled else np.full_like(values, np.nan),
            _named(f"{100 * level:g} % quantile of the posterior", units),
        )
    return variables


def _about_posterior(posterior: Posterior) -> dict[str, Any]:
    """Return how far a posterior can be trusted, as attributes of the file."""
    return {
        "posterior_priors": posterior.priors,
        "posterior_steps": posterior.steps,
        "posterior_thinning": posterior.thinning,
        "posterior_autocorrelation": float(posterior.correlated.max()),
        "posterior_independent_draws": posterior.independent,
        "posterior_agreement": posterior.agreement,
        "posterior_settled": int(posterior.settled),
        "posterior_trials_without_value": posterior.lost,
    }


def _named(long_name: str, attributes: Mapping[str, Any] = MappingProxyType({})) -> dict[str, Any]:
    return {"long_name": long_name, **attributes}


def _flags(meanings: str) -> dict[str, Any]:
    """Return the attributes of a variable whose values 0, 1, ... stand for these words."""
    values = np.arange(len(meanings.split()), dtype=np.int8)
    return {"units": "1", "flag_values": values, "flag_meanings": meanings}


def table_of(ds: xr.Dataset) -> list[str]:
    """Return a fit in words: parameters, chi2, what is not known, and a line for each datum."""
    columns = [
        name
        for name in map(str, ds.data_vars)
        if name.removeprefix("datum_") in PARAMETERS and np.ptp(ds[name].values) > 0
    ]
    head = [name.removeprefix("datum_") for name in columns]
    rows = [[*head, "variable", "measured", "error", "fitted", "residual", "regime", ""]]
    for datum in (ds.isel({DATUM: number}) for number in range(ds.sizes[DATUM])):
        regime = Regime(int(datum.datum_regime)).name.lower()
        status = Status(int(datum.datum_status))
        numbers = [f"{float(datum[name]):.6g}" for name in (*columns, *_NUMBERS)]
        rows.append(
            [
                *numbers[: len(columns)],
                str(datum.datum_variable.values),
                *numbers[len(columns) :],
                f"{float(datum.residual):.2f}",
                regime if status.is_result else status.name.lower(),
                _JUMPS[int(datum.datum_at_jump)],
            ]
        )
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = (
        "  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    )
    return [*_parameter_lines(ds), _machine_line(ds), *_statistic_lines(ds), "", *lines]


_NUMBERS = ("measured_value", "measured_error", "fitted_value")
_JUMPS = ("", "at a jump", "jumps within the intervals")


def _machine_line(ds: xr.Dataset) -> str:
    """Return the parameters of the machine that the fit took as given."""
    given = [name for name in _MACHINE if name in ds.coords and ds[name].ndim == 0]
    listed = (
        f"{PARAMETERS[name].symbol} = {float(ds[name]):g} {PARAMETERS[name].unit}".rstrip()
        for name in given
        if name not in ds[FREE].values and f"datum_{name}" not in ds
    )
    return f"computed with {', '.join(listed)} (--set or a config gives others)"


def _parameter_lines(ds: xr.Dataset) -> list[str]:
    lines = []
    for name in map(str, ds[FREE].values):
        own = ds.sel({FREE: name})
        code = Determination(int(own.parameter_determination))
        value, error = float(own.parameter_value), float(own.parameter_standard_error)
        units = f" {PARAMETERS[name].unit}".rstrip()
        low, high = _ends(own, "interval")
        line = f"{name}: {value:.7g}{units}"
        if code is not Determination.AT_BOUND and np.isfinite([low, high]).all():
            # As many digits as the error has meaning; the file holds all.
            line = f"{name}: {ufloat(value, error):.2uP}{units}"
            line += f", {100 * LEVEL:g} %: {_interval(low, high)}"
        if "parameter_profile_lower" in own:
            line += f", by the profile: {_interval(*_ends(own, 'profile'))}"
        if "parameter_posterior_lower" in own and ds.attrs["posterior_settled"]:
            line += f", by the posterior: {_interval(*_ends(own, 'posterior'))}"
        lines.append(line + _REMARKS[code])
    return lines


def _posterior_line(ds: xr.Dataset) -> str:
    """Return how far the posterior can be trusted, as a sentence."""
    steps, walkers = int(ds.attrs["posterior_steps"]), ds.sizes[CHAIN]
    agreement = f"R-hat {float(ds.attrs['posterior_agreement']):.3g}"
    if not ds.attrs["posterior_settled"]:
        return (
            f"posterior: NOT DETERMINED, since {walkers} walkers have not come to agree within "
            f"{steps} steps ({agreement}): they do not change often enough between basins"
        )
    draws = round(float(ds.attrs["posterior_independent_draws"]))
    time, priors = float(ds.attrs["posterior_autocorrelation"]), ds.attrs["posterior_priors"]
    return (
        f"posterior: {draws} independent draws by {walkers} walkers in {steps} steps, "
        f"autocorrelation time {time:.3g} steps, {agreement}; priors: {priors}"
    )


def posterior_groups(ds: xr.Dataset) -> dict[str, xr.Dataset]:
    """Return the groups of a file that ArviZ opens, of a fit with a posterior."""
    own = ds.reset_coords(drop=True)
    draws = {
        name: own["posterior_draws"].sel({FREE: name}, drop=True).assign_attrs(variable.attributes)
        for name, variable in PARAMETERS.items()
        if name in own[FREE].values
    }
    return {
        "posterior": xr.Dataset(draws, attrs={"inference_library": "emcee"}),
        "sample_stats": xr.Dataset({"lp": own["posterior_log_probability"]}),
        "observed_data": own[["measured_value"]],
    }


def _ends(parameter: xr.Dataset, name: str) -> tuple[float, float]:
    low, high = (float(parameter[f"parameter_{name}_{side}"]) for side in ("lower", "upper"))
    return low, high


def _interval(low: float, high: float) -> str:
    if 0.0 < low * _ANYTHING < high:
        return f"any value, over more than {math.log10(_ANYTHING):.0f} decades"
    return f"{low:.6g} to {high:.6g}"


_ANYTHING = 1e6  # ends farther apart by this factor tell of no value
_REMARKS = {
    Determination.DETERMINED: "",
    Determination.UNDETERMINED: "; NOT DETERMINED by these data",
    Determination.AT_BOUND: "; AT ITS BOUND, and taken as fixed there",
}


def _statistic_lines(ds: xr.Dataset) -> list[str]:
    names = [str(name) for name in ds[FREE].values]
    lines = [
        f"correlation of {names[i]} and {names[j]}: {float(value):.3f}"
        for (i, j), value in np.ndenumerate(ds.parameter_correlation.values)
        if i < j and np.isfinite(value)
    ]
    chi2, dof = float(ds.attrs["chi2"]), int(ds.attrs["degrees_of_freedom"])
    reduced = f", chi2/dof {float(ds.attrs['reduced_chi2']):.4g}" if dof > 0 else ""
    lines.append(f"chi2 {chi2:.6g} with {counted(dof, 'degree')} of freedom{reduced}")
    lines.append(f"errors of the data: {ds.attrs['measurement_errors']}")
    if "posterior_draws" in ds:
        lines.append(_posterior_line(ds))
    if jumps := int((ds.datum_at_jump != 0).sum()):
        data = "a jump of 1 datum bounds" if jumps == 1 else f"jumps of {jumps} data bound"
        lines.append(
            f"{data} the basin of this minimum: intervals reach over all others that may be true"
        )
    return lines
