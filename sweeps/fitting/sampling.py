"""Trials drawn with their likelihood, for minima among jumps, where chi2 is no parabola."""

from __future__ import annotations

import numpy as np

from sweeps.fitting.refinement import Fit, Search, population_of
from sweeps.fitting.statistics import Statistics, log_likelihood
from sweeps.fitting.trials import Trial
from sweeps.measurements import Floats

# Generations, of which the first lead to where the likelihood lies.
_GENERATIONS, _FIRST = 32, 12
_POOL = 4  # times as many of the best trials of the evolution, from which half of the walkers start
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
    walkers = _begun(search, fit, known, rng)
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


def _begun(search: Search, fit: Fit, known: Statistics, rng: np.random.Generator) -> list[Trial]:
    """Return the first walkers: from the best of the evolution, and around the minimum."""
    count = population_of(search.model)
    whole = sorted((t for t in search.glances if t.is_whole), key=lambda trial: trial.cost)
    pool = whole[: _POOL * count // 2]
    chosen = [pool[number] for number in rng.integers(len(pool), size=count // 2)] if pool else []
    errors = np.nan_to_num(known.errors)
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
    wide = np.array([free.box[1] - free.box[0] for free in search.model.free])
    shake = _SHAKE * wide * rng.standard_normal(others.shape)
    return np.asarray(factor[:, None] * (others[one] - others[two]) + shake)
