"""Posteriors: sets of free parameters drawn by probability, with the walkers of emcee.

Walkers move by vectors between other walkers (ter Braak, Statistics and Computing 16, 239, 2006),
which lets them change basins. Each half of them moves by vectors of the other half, so that a half
is one call of the lanes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from stickslip.distributions import Distribution
from sweeps.exits import ExpectedError
from sweeps.fitting.least_squares import Fit
from sweeps.fitting.minima import Search
from sweeps.fitting.parameters import LOGARITHMIC, PLAIN
from sweeps.fitting.sampling import first_walkers
from sweeps.fitting.statistics import Statistics, log_likelihood
from sweeps.fitting.trials import Trial
from sweeps.measurements import Floats

WALKERS = 128
"""The number of walkers; with more than 16 free parameters it is 8 for each."""

MOST_STEPS = 3000
LONG = 40.0
"""The steps with draws must last this many autocorrelation times."""
ALIKE = 1.1
"""Walkers agree with each other if R-hat is below this."""

_CHECKED = 50  # steps between checks of the convergence
_FORGOTTEN = 1 / 3  # fraction of the steps before the walkers reach the probable places
_WINDOW = 5.0  # autocorrelation times over which correlations are summed
_RARE = 0.02  # fraction of the draws that a basin must have to count in R-hat
_SHORTENED, _SNOOKER = 0.7, 0.2  # fractions of the moves
WHOLE = 0.1
"""The fraction of moves by vectors of full length, which can reach another basin."""
LARGEST_LOST = 0.01
"""The largest fraction of trials that lack a value and might have been probable."""
_PROBABLE = -20.0  # a trial below this, relative to the minimum, would have been rejected anyway
_SEED = 3


class PosteriorError(ExpectedError, ValueError):
    """A posterior that is impossible to draw; the message says why, and what would help."""


class Posterior(NamedTuple):
    """Draws of the free parameters, on their scales: `places` (walkers, draws, p).

    `logs` (walkers, draws) are the logarithms of their probability, relative to the likelihood of
    the minimum. Each walker has made `steps` steps, and `thinning` steps lie between draws.
    `correlated` (p,) are autocorrelation times in steps. `agreement` is the largest R-hat of a
    parameter or of the weight of a basin. `settled` says whether there are enough steps and the
    walkers agree. `lost` is the fraction of trials that lack a value and might have been probable.
    `priors` describes the priors in words.
    """

    places: Floats
    logs: Floats
    steps: int
    thinning: int
    correlated: Floats
    agreement: float
    settled: bool
    lost: float
    priors: str

    @property
    def independent(self) -> float:
        """The equivalent number of independent draws."""
        walkers, kept = self.places.shape[0], self.steps * (1.0 - _FORGOTTEN)
        return float(walkers * kept / np.max(self.correlated))

    @property
    def likely_steps(self) -> int:
        """The number of steps that the present autocorrelation times of the parameters demand."""
        wanted = LONG * float(np.max(self.correlated)) / (1.0 - _FORGOTTEN)
        return _CHECKED * math.ceil(min(wanted, MOST_STEPS) / _CHECKED)


class _Target:
    """The probability of places, as a function for emcee, which counts trials."""

    def __init__(self, search: Search, fit: Fit, prior: Callable[[Floats], Floats]) -> None:
        self._search, self._fit, self._prior = search, fit, prior
        self._basins: dict[bytes, int] = {}
        self.computed = self.lost = 0

    def __call__(self, places: Floats) -> list[tuple[float, int]]:
        """Return the logarithm of the probability of each place (m, p), and its basin."""
        model = self._search.model
        logs, basins = np.full(len(places), -math.inf), np.full(len(places), -1)
        prior = self._prior(places)
        inside = np.flatnonzero(np.isfinite(prior))
        if len(inside):
            trials = model.trials(places[inside], self._search.budget)
            self._search.computed += len(trials)
            self.computed += len(trials)
            self.lost += sum(map(self._could_be_probable, trials))
            for number, trial in zip(inside, trials, strict=True):
                logs[number] = prior[number] + log_likelihood(self._fit, trial)
                basins[number] = self._basins.setdefault(trial.signature, len(self._basins))
        return list(zip(logs.tolist(), basins.tolist(), strict=True))

    def _could_be_probable(self, trial: Trial) -> bool:
        """Return whether a trial lacks values and its other data do not rule it out."""
        return not trial.is_whole and log_likelihood(self._fit, trial, trial.chi2) > _PROBABLE


def posterior_of(
    search: Search,
    fit: Fit,
    known: Statistics,
    priors: Mapping[str, Distribution],
    show: Callable[[Posterior], None] = lambda _: None,
) -> Posterior:
    """Return free parameters drawn in proportion to probability, from all basins seen in a search.

    `show` receives the posterior so far after each check of the convergence.

    Raises PosteriorError if the fit is exact or has as many parameters as data, so that errors are
    unknown, or if the fit or too many trials lack a value.
    """
    import emcee
    from emcee import moves

    if search.is_exact(fit) or fit.scale == 0.0:
        raise PosteriorError(
            "the fit matches the data exactly: without errors there are no probabilities"
        )
    if not fit.trial.is_whole:
        raise PosteriorError(
            f"{int((~fit.trial.known).sum())} of {fit.trial.known.size} data "
            "have no fitted value: without their orbits the draws would be biased; give narrower "
            "ranges, or leave out data that no orbit describes"
        )
    if math.isnan(fit.scale):
        raise PosteriorError(
            "the data have no errors, and there are no more data than free parameters, so their "
            "scatter does not show the errors: give errors, more data or fewer free parameters"
        )
    rng = np.random.default_rng(_SEED)
    count = max(WALKERS, 8 * len(search.model.free))
    prior = _prior_of(fit, priors)
    target = _Target(search, fit, prior)
    walkers = first_walkers(search, fit, known, count, rng)
    start = _within(prior, walkers, search.seen, fit)
    sampler = emcee.EnsembleSampler(
        *start.shape,
        target,
        vectorize=True,
        moves=[
            (moves.DEMove(), _SHORTENED),
            (moves.DEMove(gamma0=1.0), WHOLE),
            (moves.DESnookerMove(), _SNOOKER),
        ],
        blobs_dtype=np.int64,
    )
    sampler.random_state = np.random.RandomState(_SEED).get_state()
    state: Any = start
    while True:
        state = sampler.run_mcmc(state, _CHECKED, skip_initial_state_check=True)
        found = _posterior(sampler, target, _in_words(fit, priors))
        show(found)
        if found.lost > LARGEST_LOST and sampler.iteration > _CHECKED:
            raise PosteriorError(
                f"{found.lost:.1%} of the trials might be probable but lack a value (the "
                f"limit is {LARGEST_LOST:.0%}): without their orbits the draws would be biased "
                "against them; give narrower ranges, or leave out data that no orbit describes"
            )
        if found.settled or sampler.iteration >= MOST_STEPS:
            return found


def _within(
    prior: Callable[[Floats], Floats], walkers: list[Trial], seen: list[Trial], fit: Fit
) -> Floats:
    """Return the places of walkers; the best seen replace those that a prior excludes."""
    places = np.array([walker.u for walker in walkers])
    excluded = np.flatnonzero(~np.isfinite(prior(places)))
    if len(excluded):
        others = np.unique([trial.u for trial in seen], axis=0)
        likely = {tuple(trial.u): log_likelihood(fit, trial) for trial in seen}
        logs = prior(others) + np.array([likely[tuple(place)] for place in others])
        order = np.argsort(-logs)[: len(excluded)]
        if len(order) < len(excluded) or not np.isfinite(logs[order]).all():
            raise PosteriorError(
                "the priors exclude nearly all trials of the search: give wider priors, or "
                "ranges for the free parameters within the priors"
            )
        places[excluded] = others[order]
    return places


def _posterior(sampler: Any, target: _Target, priors: str) -> Posterior:
    """Return the draws of the walkers so far, and how well they agree."""
    first = int(sampler.iteration * _FORGOTTEN)
    places = sampler.get_chain(discard=first)  # (steps, walkers, p)
    basins, steps = sampler.get_blobs(discard=first), len(places)
    names, counts = np.unique(basins, return_counts=True)
    often = names[(counts > _RARE * basins.size) & (counts < (1.0 - _RARE) * basins.size)]
    observed = [*np.moveaxis(places, -1, 0), *((basins == name).astype(float) for name in often)]
    times = np.array([_autocorrelation_time(each) for each in observed])
    agreement = max(map(_r_hat, observed))
    correlated = times[: places.shape[-1]]
    longest = float(times.max())
    thinning = max(1, int(min(longest, MOST_STEPS) / 2.0))
    return Posterior(
        np.swapaxes(places[::thinning], 0, 1),
        sampler.get_log_prob(discard=first)[::thinning].T,
        int(sampler.iteration),
        thinning,
        correlated,
        agreement,
        bool(steps >= LONG * longest and agreement < ALIKE),
        target.lost / max(target.computed, 1),
        priors,
    )


def _autocorrelation_time(values: Floats) -> float:
    """Return the autocorrelation time of values (steps, walkers), in steps.

    The sum ends at Sokal's window of five autocorrelation times, as in emcee.autocorr. Deviations
    are from the mean of all walkers, since a walker that never leaves its basin does not show the
    weight of that basin.
    """
    steps = len(values)
    transform = np.fft.rfft(values - values.mean(), n=2 * steps, axis=0)
    correlation = np.fft.irfft(np.abs(transform) ** 2, axis=0)[:steps].sum(axis=1)
    if not correlation[0] > 0.0:
        return math.inf
    times = 2.0 * np.cumsum(correlation / correlation[0]) - 1.0
    enough = np.arange(steps) >= _WINDOW * times
    return max(1.0, float(times[np.argmax(enough)] if enough.any() else times[-1]))


def _r_hat(values: Floats) -> float:
    """Return the split R-hat of walkers (steps, walkers), which is 1 if their halves agree.

    It is defined by Gelman et al., Bayesian Data Analysis (2013), section 11.4.
    """
    half = len(values) // 2
    parts = np.concatenate([values[:half], values[half : 2 * half]], axis=1)
    within = float(parts.var(axis=0, ddof=1).mean())
    between = float(parts.mean(axis=0).var(ddof=1))
    if within == 0.0:
        return 1.0 if between == 0.0 else math.inf
    return math.sqrt((half - 1) / half + between / within)


def _prior_of(fit: Fit, priors: Mapping[str, Distribution]) -> Callable[[Floats], Floats]:
    """Return the function that gives the logarithm of the prior density at places (m, p).

    A parameter without a prior has a uniform one on its scale.
    """
    free = fit.model.free

    def log_density(places: Floats) -> Floats:
        total = np.where(fit.model.are_inside(places), 0.0, -math.inf)
        for one, u in zip(free, places.T, strict=True):
            if one.name in priors:
                values = one.value(u)
                slopes = np.array([one.slope(float(each)) for each in u])
                total += priors[one.name].log_density(values) + np.log(slopes)
        return total

    return log_density


def _in_words(fit: Fit, priors: Mapping[str, Distribution]) -> str:
    scales = {LOGARITHMIC: "uniform in its logarithm", PLAIN: "uniform"}
    words = (f"{one.name} {priors.get(one.name, scales[one.form])}" for one in fit.model.free)
    return ", ".join(words)
