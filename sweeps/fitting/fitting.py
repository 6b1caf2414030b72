"""The fit of parameters to measurements, from data and a config to a Dataset."""

from __future__ import annotations

import importlib.util
import time
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from stickslip.accessors import register_accessors
from stickslip.dispatch.workers import Workers
from stickslip.variables import PARAMETERS
from sweeps.config.checks import warnings_of_columns
from sweeps.config.load import Config
from sweeps.engine.executors import workers_of
from sweeps.engine.progress import display_of
from sweeps.engine.settings import options_of, read_config
from sweeps.exits import ExpectedError
from sweeps.fitting.least_squares import Fit
from sweeps.fitting.minima import Search, population_of
from sweeps.fitting.parameters import Free, free_parameters, priors_of
from sweeps.fitting.posterior import ALIKE, Posterior, posterior_of
from sweeps.fitting.sampling import drawn
from sweeps.fitting.statistics import (
    Determination,
    Statistics,
    covering,
    jumps_within,
    profile_intervals,
    statistics_of,
    widened,
)
from sweeps.fitting.trials import Model, Trial
from sweeps.human import clock
from sweeps.measurements import Measurements, read_data

if TYPE_CHECKING:
    import xarray as xr

    from sweeps.measurements import Table

# How often to look for a better minimum, and the fraction of chi2 by which it must be better.
_AGAIN, _BETTER = 3, 1e-4


# The extras of the same names.
_FOR_A_FIT = "'uncertainties>=3.2'"
FOR_A_POSTERIOR = "'emcee>=3.1' 'corner>=2.2'"
"""What a posterior and its picture need, as arguments of pip."""


class FitError(ExpectedError, ValueError):
    """A fit that is impossible; the message says why, and what would help.

    >>> fit({"T": [200, 250], "F_max": [2.8e-3, 1.3e-3]}, "k", {"sweep": {"K": [3000, 4000]}})
    Traceback (most recent call last):
    sweeps.fitting.fitting.FitError: the config has axes (spring_stiffness): put varied ...
    """


class _Progress:
    """The progress of a fit as the number of trials so far, of an unknown total.

    The outlook is the best fit, once it is known, and how far a posterior has got.
    """

    goal: ClassVar[None] = None

    def __init__(self, search: Search) -> None:
        self._search = search
        self._begun = time.monotonic()
        self.outlook = self._best = ""

    def found(self, best: Fit) -> None:
        """Show the best fit while the posterior is sampled."""
        values = zip(self._search.model.free, best.trial.u, strict=True)
        named = (f"{PARAMETERS[free.name].symbol} = {free.value(u):.4g}" for free, u in values)
        self._best = f"best fit {', '.join(named)}"
        self.outlook = f"{self._best}; sampling the posterior"

    def sampled(self, posterior: Posterior) -> None:
        """Show how far the posterior has got."""
        self.outlook = (
            f"{self._best}; posterior: {posterior.steps} of about {posterior.likely_steps} steps, "
            f"R-hat {posterior.agreement:.2f} (converged below {ALIKE})"
        )

    @property
    def done(self) -> int:
        """The number of trials so far."""
        return self._search.computed

    @property
    def headline(self) -> str:
        """The number of trials and the time so far, as a line of text."""
        return f"fitting: {self.done} trials ({clock(time.monotonic() - self._begun)})"


def fit(
    data: Table,
    free: Free,
    config: str | Path | Mapping[str, Any] | Config | None = None,
    *,
    profile: bool = False,
    posterior: bool = False,
    priors: Mapping[str, Any] | None = None,
    workers: int | None = None,
    progress: bool = False,
) -> xr.Dataset:
    """Return the parameters that fit measurements best, with their errors, and the fitted curve.

    A differential evolution searches a wide box around the start in `config`, and least squares
    refine its best trials, so that the minimum does not depend on the start. Parameters vary on
    logarithmic scales, or on plain scales if they may be 0 or negative.

    >>> data = {"T": [160, 200, 240], "F_max": [4.67e-3, 3.25e-3, 2.38e-3]}
    >>> ds = fit(data, "k", {"model": {"gamma": -0.55}})
    >>> ds.parameter_value.round(-3).values
    array([71000.])

    Parameters
    ----------
    data
        A CSV file, a DataFrame or a dict of columns: parameters and measured variables (such as
        `friction_force_amplitude`), by name or symbol, in SI units. A column of standard errors has
        the name of its variable followed by `_error`. Without errors, residuals are relative to the
        values, with a common unknown factor that chi2/dof estimates.
    free
        The parameters to fit, by name or symbol, or a dict with the range (lowest, highest) of
        trials for each, or None for a wide range around the start.
    config
        All other parameters, the start, and options, as for `sweeps.run` but without axes; by
        default the paper's Fig. 3.
    profile
        Also compute intervals by the profile likelihood, which takes several times as long.
    posterior
        Also draw parameters from their posterior distribution (emcee), which takes minutes.
    priors
        Prior distributions for the posterior: a dict such as `{"gamma": {"normal": [-0.5, 0.1]}}`,
        in the forms of `sample` in configs. The prior of any other parameter is uniform on its
        scale, within the bounds of trials.
    workers
        Number of threads or processes, counted like joblib's `n_jobs`; by default the setting of
        `joblib.parallel_config`, or else of `execution` in the config.
    progress
        Show the number of trials so far.

    Returns
    -------
    Dataset
        The sweep of the fitted curve, with its config in the attributes, and more variables. Along
        `free_parameter`: `parameter_value`, `parameter_standard_error`, the ends of the 95 %
        interval `parameter_interval_lower` and `_upper` (by Student's t; `parameter_profile_lower`
        and `_upper` by the profile), `parameter_correlation`, and `parameter_determination`: 0, or
        1 if the data do not determine a parameter (its standard error is at least a factor of e or
        a whole unit, or the data do not depend on it), or 2 at a bound, where it counts as fixed.
        Along `datum`: `measured_value`, `measured_error`, `fitted_value`, `residual`,
        `datum_regime`, `datum_status`, and `datum_at_jump`: 1 if the step of a derivative crosses a
        jump, 2 if the motion changes within the intervals. The attributes `chi2`,
        `degrees_of_freedom` and `reduced_chi2` refer to the data with a fitted value. With a
        posterior: `posterior_draws` along `free_parameter`, `chain` (a walker) and `draw`, and
        `parameter_posterior_lower`, `_median` and `_upper`, the quantiles 2.5, 50 and 97.5 %, which
        are NaN if the walkers do not agree (`posterior_agreement`, R-hat, is 1.1 or more) or their
        steps are too few (`posterior_settled` is 0).

    Raises
    ------
    ConfigError, DataError, FreeError
        The config, the data or the free parameters have mistakes; the message lists them all.
    ExecutorError
        The workers are not available, or were lost.
    FitError
        The package uncertainties, or emcee for a posterior, is missing; the config has axes or a
        stochastic film; for a profile, there is a single free parameter, or no more data than
        parameters.
    PosteriorError
        The fit is exact, has as many parameters as data without errors, or lacks a value; or too
        many trials lack a value.
    """
    if not isinstance(config, Config):
        config = read_config({} if config is None else config)
    measured = read_data(data)
    for line in odd_values(measured, config, data):
        warnings.warn(line, stacklevel=2)
    return fit_measured(
        measured,
        free,
        config,
        profile=profile,
        priors=(priors or {}) if posterior or priors else None,
        workers=workers,
        progress=progress,
    )


def odd_values(data: Measurements, config: Config, source: Table) -> list[str]:
    """Return warnings about parameters in data that look like values in another unit."""
    named = str(source) if isinstance(source, (str, Path)) else "table"
    columns = {name: values.tolist() for name, values in data.parameters.items()}
    return warnings_of_columns(columns, config, named)


def fit_measured(
    data: Measurements,
    free: Free,
    config: Config,
    *,
    profile: bool,
    progress: bool,
    priors: Mapping[str, Any] | None = None,
    workers: int | None = None,
) -> xr.Dataset:
    """Return the fit of measurements already read, with a posterior unless `priors` is None.

    See `fit`.
    """
    require("uncertainties", "a fit", _FOR_A_FIT)
    if priors is not None:
        require("emcee", "a posterior", FOR_A_POSTERIOR)
    from sweeps.fitting.output import fit_dataset

    with workers_of(config.execution, workers) as able:
        search = Search(model_of(data, free, config, able))
        if profile:
            _refuse_profile(search.model)
        prior = None if priors is None else priors_of(priors, search.model.free)
        shown = _Progress(search)
        with display_of(shown, wanted=progress):
            found, known = best_of(search)
            shown.found(found)
            intervals = profile_intervals(search, found, known) if profile else None
            draws = None
            if prior is not None:
                draws = posterior_of(search, found, known, prior, shown.sampled)
        result = fit_dataset(found, known, config, intervals, draws, search.computed)
    register_accessors()
    return result


def summary_of(ds: xr.Dataset) -> str:
    """Return a summary of a fit: parameters with errors, chi2, and a line for each datum.

    Raises FitError if the Dataset is no fit or the package uncertainties is missing.
    """
    if "parameter_value" not in ds:
        raise FitError("this is not a fit; make one with `stickslip fit` or `sweeps.fit`")
    if lost := [dim for dim in ("datum", "free_parameter") if dim not in ds.dims]:
        raise FitError(
            f"a fit without the dimension {lost[0]} has no summary: keep it by using "
            f"isel({lost[0]}=[0]), and do not use squeeze()"
        )
    require("uncertainties", "a fit", _FOR_A_FIT)
    from sweeps.fitting.output import table_of

    return "\n".join(table_of(ds))


def best_of(search: Search) -> tuple[Fit, Statistics]:
    """Return the best minimum and its statistics, after a look at the ends of the intervals."""
    found = search.run()
    codes = statistics_of(found).determination
    found = search.along(found, np.flatnonzero(codes != Determination.DETERMINED).tolist())
    known = statistics_of(found)
    draws = _draws(search, found, known)
    if not draws:
        found, known = _to_its_ends(search, found)
        draws = _draws(search, found, known)
    if not draws:
        return found, known
    closer = search.run(population=draws[-population_of(search.model) :])
    found = min(found, closer, key=lambda fit: fit.trial.cost)
    known, _ = widened(search, found, statistics_of(found))
    return found, covering(search, found, known, draws)


def _to_its_ends(search: Search, found: Fit) -> tuple[Fit, Statistics]:
    """Return a minimum, or a better one found from the ends of its intervals, with statistics."""
    known, best = widened(search, found, statistics_of(found))
    for _ in range(_AGAIN):
        if search.is_exact(found) or best.cost >= found.trial.cost * (1.0 - _BETTER):
            break
        found = search.run([best])
        known, best = widened(search, found, statistics_of(found))
    return found, known


def _draws(search: Search, found: Fit, known: Statistics) -> list[Trial]:
    """Return trials drawn by likelihood if jumps bound the basin of a minimum, or else none."""
    determined = (known.determination == Determination.DETERMINED).any()
    if search.is_exact(found) or not found.scale > 0.0 or not determined:
        return []
    return drawn(search, found, known) if jumps_within(search, found, known).any() else []


def model_of(
    data: Measurements, free: Free, config: Config, workers: Workers | None = None
) -> Model:
    """Return the model of measurements with some free parameters; raises FreeError, FitError."""
    options = options_of(config)
    if varied := [*config.sweep, *config.cases]:
        raise FitError(
            f"the config has axes ({', '.join(varied)}): put varied parameters into the data, and "
            "leave `sweep`, `cases` and `sample` out"
        )
    if both := [name for name in config.model if name in data.parameters]:
        raise FitError(
            f"given both in the config and as columns of the data: {', '.join(both)}; leave one of "
            "the two out"
        )
    if options.physics.chance:
        raise FitError("noise: a mean of random paths cannot be fitted; leave out 'stochastic'")
    fixed = config.parameters()
    return Model(data, free_parameters(free, fixed, data.parameters), fixed, options, workers)


def _refuse_profile(model: Model) -> None:
    if len(model.free) < 2:
        raise FitError("a profile needs two free parameters or more, since it refits all but one")
    if len(model.data.value) <= len(model.free):
        raise FitError("a profile needs more data than free parameters")


def require(package: str, what: str, needed: str) -> None:
    """Raise FitError if a package is missing; `needed` are arguments of pip that install it."""
    if importlib.util.find_spec(package) is None:
        raise FitError(f"{what} needs {package}, which is not installed; try: pip install {needed}")
