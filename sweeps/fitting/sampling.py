"""Sample trials by likelihood, for minima where chi2 jumps and is not parabolic."""

from __future__ import annotations

import numpy as np

from sweeps.fitting.least_squares import Fit
from sweeps.fitting.minima import Search, population_of
from sweeps.fitting.statistics import Statistics, log_likelihood
from sweeps.fitting.trials import Trial
from sweeps.measurements import Floats

# All generations, and the first ones, in which the walkers reach the likely places.
_GENERATIONS, _FIRST = 32, 12
# Walkers start only from trials with a larger logarithm of the likelihood.
_LEAST = -10.0
# How often a vector between two walkers keeps its full length, which can reach another basin.
_WHOLE = 0.1
_SHAKE = 1e-4  # fraction of the box; otherwise steps would stay in the span of the first walkers
_SEED = 2


def drawn(search: Search, fit: Fit, known: Statistics) -> list[Trial]:
    """Return trials drawn by likelihood within the bounds.

    The method is differential evolution as a Markov chain (ter Braak, Statistics and Computing 16,
    239, 2006). Its steps are vectors between other walkers, which cross jumps and give a wide basin
    its full weight against a narrow one that fits better by chance. Each half of the walkers steps
    by vectors of the other half, so that a half is one call.
    """
    rng = np.random.default_rng(_SEED)
    walkers = first_walkers(search, fit, known, population_of(search.model), rng)
    logs = np.array([log_likelihood(fit, trial) for trial in walkers])
    kept: list[Trial] = []
    for generation in range(_GENERATIONS):
        for first in (0, 1):
            half = np.arange(first, len(walkers), 2)
            others = np.array([walker.u for walker in walkers[1 - first :: 2]])
            places = np.array([walkers[one].u for one in half]) + _steps(search, others, rng)
            inside = np.flatnonzero(search.model.are_inside(places))
            chances = np.log(rng.random(len(half)))
            for place, trial in zip(inside, search.glance(places[inside]), strict=True):
                log, own = log_likelihood(fit, trial), half[place]
                if log - logs[own] >= chances[place]:
                    walkers[own], logs[own] = trial, log
        if generation >= _FIRST:
            kept += walkers
    return kept


def first_walkers(
    search: Search, fit: Fit, known: Statistics, count: int, rng: np.random.Generator
) -> list[Trial]:
    """Return the first `count` walkers, trials that fit and lie as far apart as possible.

    Every valley or basin that the search saw needs walkers, since random moves are unlikely to find
    it again.
    """
    wide = search.model.wide
    far = [seen for seen in search.seen if log_likelihood(fit, seen) > _LEAST]
    places = np.array([trial.u for trial in far]) / wide
    chosen: list[Trial] = []
    distances = np.linalg.norm(places - fit.trial.u / wide, axis=1)
    while len(chosen) < count and distances.max(initial=0.0) > _SHAKE:
        number = int(distances.argmax())
        chosen.append(far[number])
        distances = np.minimum(distances, np.linalg.norm(places - places[number], axis=1))
    errors = np.minimum(np.nan_to_num(known.errors), wide)
    correlations = np.nan_to_num(known.correlations)
    np.fill_diagonal(correlations, 1.0)
    around = rng.multivariate_normal(
        fit.trial.u, correlations * np.outer(errors, errors), size=count - len(chosen)
    )
    return [*chosen, *search.glance(search.model.inside(around))]


def _steps(search: Search, others: Floats, rng: np.random.Generator) -> Floats:
    """Return a step for each walker of one half, (n, p), from the other half (n, p)."""
    count, size = others.shape
    one = rng.integers(count, size=count)
    two = (one + rng.integers(1, count, size=count)) % count
    factor = np.where(rng.random(count) < _WHOLE, 1.0, 2.38 / np.sqrt(2.0 * size))
    shake = _SHAKE * search.model.wide * rng.standard_normal(others.shape)
    return np.asarray(factor[:, None] * (others[one] - others[two]) + shake)
