"""Sample trials by likelihood, for minima where chi2 jumps and is not parabolic."""

from __future__ import annotations

import numpy as np

from sweeps.fitting.least_squares import Fit
from sweeps.fitting.minima import Search, population_of
from sweeps.fitting.statistics import Statistics, log_likelihood
from sweeps.fitting.trials import Trial
from sweeps.measurements import Floats

# Generations, of which the first lead to where the likelihood lies.
_GENERATIONS, _FIRST = 32, 12
# Of the logarithm of the likelihood of trials from which walkers start; less is of no interest.
_LEAST = -10.0
# How often a vector between two walkers is taken whole: it may lead from one basin to another.
_WHOLE = 0.1
_SHAKE = 1e-4  # of the box: else all steps would lie in the space between the first walkers
_SEED = 2


def drawn(search: Search, fit: Fit, known: Statistics) -> list[Trial]:
    """Return trials drawn with their likelihood from all that the bounds allow.

    Differential evolution as a Markov chain (ter Braak, Statistics and Computing 16, 239, 2006):
    its steps are vectors between other walkers, so that jumps do not hold it up, and a wide basin
    gets its weight beside a narrow one that fits better by chance. Each half of the walkers steps
    by vectors of the other, so that each half is one call.
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
    """Return so many walkers to begin with, as far from each other as trials that fit are.

    A valley or another basin that the search has seen is not found again by chance.
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
    """Return as many steps (n, p) as there are other walkers (n, p)."""
    count, size = others.shape
    one = rng.integers(count, size=count)
    two = (one + rng.integers(1, count, size=count)) % count
    factor = np.where(rng.random(count) < _WHOLE, 1.0, 2.38 / np.sqrt(2.0 * size))
    shake = _SHAKE * search.model.wide * rng.standard_normal(others.shape)
    return np.asarray(factor[:, None] * (others[one] - others[two]) + shake)
