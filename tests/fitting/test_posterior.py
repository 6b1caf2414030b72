"""Posteriors: draws follow the probability, or the result says that they do not."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, cast

import numpy as np
import pytest
import xarray as xr

from stickslip import stationary_orbits
from stickslip.distributions import Distribution, distribution
from sweeps.config.load import from_mapping
from sweeps.fitting import posterior
from sweeps.fitting.fitting import best_of, model_of
from sweeps.fitting.least_squares import Fit
from sweeps.fitting.minima import Search
from sweeps.fitting.output import CHAIN, DRAW, about_posterior, posterior_line
from sweeps.fitting.parameters import PLAIN, FreeError, FreeParameter, priors_of
from sweeps.fitting.posterior import PosteriorError, posterior_of
from sweeps.fitting.statistics import Statistics, log_likelihood
from sweeps.fitting.trials import Trial
from sweeps.measurements import Floats, read_data

LEVELS = (0.025, 0.16, 0.5, 0.84, 0.975)
FREE = [
    FreeParameter(name, PLAIN, 1.0, 1.0, 0.0, -40.0, 40.0, (-40.0, 40.0))
    for name in ("rheological_index", "initial_displacement")
]


@dataclass
class Hills:
    """A model of two free parameters whose chi2 is given by a function."""

    chi2: Callable[[Floats], float]
    lacking: Callable[[Floats], bool] = lambda _: False
    free: list[FreeParameter] = field(default_factory=lambda: FREE)
    relative: bool = False
    squares: float = 1.0

    @property
    def data(self) -> Any:
        return self

    @property
    def wide(self) -> Floats:
        return np.full(2, 80.0)

    def inside(self, places: Floats) -> Floats:
        return np.clip(places, -40.0, 40.0)

    def are_inside(self, places: Floats) -> Any:
        return (np.abs(places) < 40.0).all(axis=1)

    def trials(self, places: Floats, _: object) -> list[Trial]:
        return [self.trial(u) for u in places]

    completed = staticmethod(lambda trials, _: list(trials))

    def trial(self, u: Floats) -> Trial:
        residuals = np.array([math.sqrt(self.chi2(u)), 0.0])
        fitted = np.array([0.0, math.nan if self.lacking(u) else 0.0])
        residuals[~np.isfinite(fitted)] = 1e3
        kind = 1.0 if u[0] > 0.0 else 0.0  # basins to both sides
        results = np.full((2, 100), kind)
        return Trial(u, fitted, residuals, results)


def drawn_from(
    model: Hills,
    priors: dict[str, Distribution] | None = None,
    show: Callable[[posterior.Posterior], None] = lambda _: None,
) -> posterior.Posterior:
    """Return the posterior of a model with its minimum at 0, from walkers around it."""
    search = Search(cast("Any", model))
    fit = Fit(cast("Any", model), model.trial(np.zeros(2)), np.eye(2), np.zeros(2, dtype=bool))
    known = Statistics(
        np.ones(2), np.eye(2), np.zeros(2, dtype=np.int8), np.zeros((2, 2)), fit.at_jump
    )
    search.seen = [model.trial(u) for u in np.random.default_rng(0).uniform(-30, 30, (400, 2))]
    return posterior_of(search, fit, known, priors or {}, show)


@pytest.fixture(scope="module")
def shown() -> list[posterior.Posterior]:
    """The posteriors shown while walkers draw a normal distribution; the last is the result."""
    shown: list[posterior.Posterior] = []
    found = drawn_from(Hills(plane), show=shown.append)
    assert shown[-1] is found
    return shown


def test_the_walkers_show_how_far_they_are(shown: list[posterior.Posterior]) -> None:
    found = shown[-1]
    steps = [each.steps for each in shown]
    assert steps == list(range(50, found.steps + 1, 50))
    assert 0.7 * found.steps < found.likely_steps <= found.steps


def plane(u: Floats) -> float:
    """Chi2 of a normal distribution with standard deviations 1 and 2 and a correlation of 0.8."""
    one, two = u[0], u[1] / 2.0
    return float((one**2 - 1.6 * one * two + two**2) / (1.0 - 0.8**2)) + 1e-3


def test_a_normal_distribution_is_drawn(shown: list[posterior.Posterior]) -> None:
    found = shown[-1]
    assert found.settled
    assert found.independent > 4000
    exact = np.array([-1.95996, -0.99446, 0.0, 0.99446, 1.95996])
    quantiles = np.quantile(found.places, LEVELS, axis=(0, 1))
    assert np.abs(quantiles[:, 0] - exact).max() < 0.1
    assert np.abs(quantiles[:, 1] / 2.0 - exact).max() < 0.1
    flat = found.places.reshape(-1, 2)
    assert np.corrcoef(flat.T)[0, 1] == pytest.approx(0.8, abs=0.03)


@pytest.mark.stress
def test_a_prior_counts_as_much_as_a_datum() -> None:
    """A datum of 0 +- 1 and a prior of 2 +- 1 give 1 +- 0.71; a range cuts off the rest."""
    priors = {
        "rheological_index": distribution("normal", 2.0, 1.0),
        "initial_displacement": distribution("uniform", 0.5, 30.0),
    }
    found = drawn_from(Hills(lambda u: float(u @ u) + 1e-3), priors)
    index, displacement = found.places.reshape(-1, 2).T
    assert index.mean() == pytest.approx(1.0, abs=0.05)
    assert index.std() == pytest.approx(math.sqrt(0.5), abs=0.05)
    assert displacement.min() > 0.5
    assert "normal [2, 1]" in found.priors


def test_basins_have_their_weights() -> None:
    """A vector between two walkers connects two basins, one twice as wide as the other."""

    def basins(u: Floats) -> float:
        near = ((u[0] + 8.0) / 1.0) ** 2 + u[1] ** 2
        far = ((u[0] - 8.0) / 2.0) ** 2 + u[1] ** 2
        return float(min(near, far)) + 1e-3

    found = drawn_from(Hills(basins))
    assert found.settled
    assert np.mean(found.places[..., 0] > 0.0) == pytest.approx(2 / 3, abs=0.05)


def test_weights_that_do_not_settle_are_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(posterior, "MOST_STEPS", 200)
    monkeypatch.setattr(posterior, "WHOLE", 0.0)

    def apart(u: Floats) -> float:
        return float(min((u[0] + 20.0) ** 2, (u[0] - 20.0) ** 2) + (u[1] - 0.1 * u[0]) ** 2) + 1e-3

    found = drawn_from(Hills(lambda u: 100.0 * apart(u)))
    assert not found.settled
    assert found.agreement > 1.1
    assert "walkers do not agree after 200 steps" in _line_on(found)


@pytest.mark.stress
def test_walkers_that_agree_after_too_few_steps_are_not_said_to_disagree(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(posterior, "MOST_STEPS", 500)
    found = drawn_from(Hills(plane))
    assert not found.settled
    assert found.agreement < 1.1
    line = _line_on(found)
    assert "500 steps of 128 walkers are too few for 40 autocorrelation times" in line
    assert "do not agree" not in line


def _line_on(found: posterior.Posterior) -> str:
    """Return the line of the summary on a posterior."""
    ds = xr.Dataset({"draws": ((CHAIN, DRAW), found.logs)}, attrs=about_posterior(found))
    return posterior_line(ds)


def test_trials_without_a_value_are_counted_and_many_are_refused() -> None:
    rarely = drawn_from(Hills(plane, lacking=lambda u: bool(u[0] > 20.0)))
    assert rarely.settled
    assert rarely.lost == 0.0  # their other data rule them out
    with pytest.raises(PosteriorError, match=r"% of the trials might be probable but lack a value"):
        drawn_from(Hills(plane, lacking=lambda u: bool(u[0] > 1.0)))


def test_a_fit_without_all_values_has_no_posterior() -> None:
    with pytest.raises(PosteriorError, match="1 of 2 data have no fitted value"):
        drawn_from(Hills(plane, lacking=lambda _: True))


def test_as_many_parameters_as_data_without_errors_have_no_posterior() -> None:
    """Such a fit need not be exact, for example at a bound."""
    with pytest.raises(PosteriorError, match="no more data than free parameters"):
        drawn_from(Hills(plane, relative=True))


def test_a_trial_without_any_value_may_be_as_probable_as_can_be() -> None:
    model: Any = Hills(plane, relative=True)
    minimum = model.trial(np.zeros(2))
    fit = Fit(model, minimum, np.eye(2), np.zeros(2, dtype=bool))
    assert log_likelihood(fit, minimum) == 0.0
    assert 20.0 < log_likelihood(fit, minimum, cost=0.0) < math.inf


def test_r_hat_is_1_only_if_walkers_agree() -> None:
    rng = np.random.default_rng(1)
    alike = rng.standard_normal((400, 8))
    assert posterior._r_hat(alike) == pytest.approx(1.0, abs=0.01)
    assert posterior._r_hat(alike + np.arange(8)) > 1.5
    assert posterior._r_hat(alike + np.linspace(0.0, 3.0, 400)[:, None]) > 1.1  # they drift


@pytest.mark.parametrize(
    ("priors", "message"),
    [
        ({"K": [1e3, 2e3]}, "a prior for K, which is not free; free parameters: rheo"),
        ({"gamma": {"normal": [-0.5]}}, r"the prior of rheological_index: must be \[low, high\]"),
        ({"gamma": {"normal": [0.0, 1.0]}}, "has values that rheological_index cannot have"),
        ({"gamma": [-0.5, 0.5], "rheological_index": [0, 1]}, "two priors for rheological_index"),
    ],
)
def test_wrong_priors_are_refused(priors: dict[str, Any], message: str) -> None:
    with pytest.raises(FreeError, match=message):
        priors_of(priors, FREE)


# --- films ---


def reference(seed: int, rtol: float, count: int) -> Search:
    """Return a search for k and gamma in `count` forces with noise of 1 %."""
    T = np.linspace(160.0, 310.0, count)
    force = stationary_orbits({"T": T, "k": 7e4, "gamma": -0.55}).friction_force_amplitude.values
    noisy = force * (1.0 + 0.01 * np.random.default_rng(seed).standard_normal(count))
    data = read_data({"T": T, "F_max": noisy, "F_max_error": 0.01 * force})
    loose = {"integrator": {"rtol": rtol}, "stationary": {"rtol": rtol}}
    return Search(model_of(data, ["k", "gamma"], from_mapping(loose)))


@pytest.mark.stress
def test_quantiles_are_those_of_a_grid_of_chi2(monkeypatch: pytest.MonkeyPatch) -> None:
    """The grid lies along the ridge: k and gamma are correlated by -0.998."""
    # The ends of intervals scatter by 0.04 standard errors after the usual length.
    monkeypatch.setattr(posterior, "LONG", 100.0)
    search = reference(1, 1e-4, 10)
    fit, known = best_of(search)
    found = posterior_of(search, fit, known, {})
    assert found.settled
    for number in (0, 1):
        off = np.quantile(found.places[..., number], LEVELS) - by_a_grid(search, fit, known, number)
        assert np.abs(off).max() < 0.1 * known.errors[number], (number, off / known.errors)


def by_a_grid(search: Search, fit: Fit, known: Statistics, number: int) -> Floats:
    """Return the quantiles of one of two parameters, after a sum over the other."""
    along, across = np.linspace(-5.0, 5.0, 61), np.linspace(-5.0, 5.0, 41)
    order = [number, 1 - number]
    covariance = known.correlations * np.outer(known.errors, known.errors)
    ridge = np.linalg.cholesky(covariance[np.ix_(order, order)])
    steps = np.stack(np.meshgrid(along, across, indexing="ij"), axis=-1).reshape(-1, 2)
    places = fit.trial.u + (steps @ ridge.T)[:, order]
    costs = np.array([trial.cost for trial in search.model.trials(places, search.budget)])
    density = np.exp(-0.5 * (costs - fit.trial.cost) / fit.scale).reshape(61, 41).sum(axis=1)
    below = np.concatenate([[0.0], np.cumsum((density[1:] + density[:-1]) / 2.0)])
    values = fit.trial.u[number] + along * known.errors[number]
    return np.interp(LEVELS, below / below[-1], values)


@pytest.mark.stress
def test_intervals_hold_the_truth_as_often_as_they_say(monkeypatch: pytest.MonkeyPatch) -> None:
    """In 30 sets, 68 % intervals hold it in 50 to 85 %, and 95 % intervals in 87 to 100 %."""
    # A few hundred independent draws are enough, since 30 sets show the coverage only roughly.
    monkeypatch.setattr(posterior, "WALKERS", 32)
    monkeypatch.setattr(posterior, "LONG", 10.0)
    truth, held = np.array([math.log(7e4), -0.55]), []
    for seed in range(30):
        search = reference(seed, 1e-4, 5)
        found = posterior_of(search, *best_of(search), {})
        assert found.settled, seed
        low, lower, upper, high = np.quantile(found.places, (0.025, 0.16, 0.84, 0.975), axis=(0, 1))
        held += [((lower <= truth) & (truth <= upper), (low <= truth) & (truth <= high))]
    narrow, wide = np.mean(held, axis=(0, 2))
    assert 0.5 <= narrow <= 0.85
    assert 0.87 <= wide <= 1.0
