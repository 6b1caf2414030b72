"""The search for the best minimum: an evolution of trials, then least squares from the best."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from itertools import islice
from operator import attrgetter
from typing import Any, TypeVar

import numpy as np
from scipy.optimize import OptimizeResult, differential_evolution

from sweeps.fitting.least_squares import (
    EVALUATIONS,
    IMPROVED,
    Fit,
    Question,
    Steps,
    fit_at,
    minimum,
    settled,
    trial_at,
)
from sweeps.fitting.trials import Budget, Model, Trial, refuse_other_units
from sweeps.measurements import Floats

_Result = TypeVar("_Result")

# Budgets for trials that only show where to begin, and for trials on the way to the minimum. Nearly
# all orbits are found within the first. An orbit that takes longer is mostly chaotic, and costs as
# much as hundreds of others.
GLANCE, PATIENCE = Budget(64, 30_000), Budget(256, 300_000)
# Budgets for trials that could be the best but lack values; the last, None, is the full budget of a
# sweep.
_BUDGETS: tuple[Budget | None, ...] = (PATIENCE, Budget(1024, 3_000_000), None)
_FINALISTS = 4  # trials to compute in full before they are compared

# Differential evolution: trials per free parameter, up to the next power of 2, and generations.
_TRIALS, _GENERATIONS = 16, 40
# It ends early if chi2 varies by no more than these fractions of itself, or of the squares of the
# data, and trials by no more than this fraction of the box. A plateau alone is no minimum.
_ALIKE, _ALIKE_EXACT, _NEAR = 0.1, 1e-7, 0.1
# A closer search may go beyond the extent of its first population by this fraction of it.
_BEYOND = 0.5
# SciPy refuses a start at an end of the box if its scaling rounds it to the outside, so a start
# stays this fraction of the box within.
_ROUNDING = 1e-6
# Trials take all components of a new vector, because valleys lie askew to the axes.
_RECOMBINATION = 1.0

_PARTS = 16  # parts of the box along an undetermined parameter
# Number of fits of different kinds of motion, and of fits this fraction of the box apart.
_STARTS, _APART = 3, 0.1
_CLOSE_BY = 1e-3  # the distance between fits that end at the same jump, as a fraction of the box

_FEW_EVALUATIONS = 12  # steps of a fit that is only compared with others

_CLEARLY = 1e-5  # fraction of chi2; more than the last steps may lose
_EXACT = 1e-15  # fraction of the squares of the data; less is roughness
_SEED = 1

_by_cost, _by_chi2 = attrgetter("cost"), attrgetter("chi2")


def population_of(model: Model) -> int:
    """Return the number of trials in a generation."""
    return int(2 ** math.ceil(math.log2(_TRIALS * len(model.free))))


@dataclass
class Search:
    """A deterministic search for the best minimum of a model, whatever the start.

    `computed` counts all trials. `seen` has all except those for derivatives, and `sweep` the first
    ones, evenly spread over the box. `budget` is the budget that the trial at the best minimum
    needed; it holds for all trials on the way to a minimum.
    """

    model: Model
    computed: int = 0
    seen: list[Trial] = field(default_factory=list)
    sweep: list[Trial] = field(default_factory=list)
    budget: Budget | None = PATIENCE
    _least_cost: float = math.inf  # among trials with all values so far

    def run(self, starts: Sequence[Trial] = (), population: Sequence[Trial] = ()) -> Fit:
        """Return the best minimum found from `starts`, or by an evolution of trials.

        The evolution begins with trials all over the box, or with a `population` to look closer.
        """
        if not starts:
            self._evolve(np.array([trial.u for trial in population]))
            starts = self._distinct()
        return self._finished(self._best_from(starts, _FEW_EVALUATIONS))

    def along(self, fit: Fit, numbers: Iterable[int]) -> Fit:
        """Return the best minimum along parameters, given by number, that a fit does not determine.

        The fit lies in a valley whose floor may have several minima. New fits begin at the best
        trial in each part of the box along each such parameter.
        """
        starts: dict[int, Trial] = {}
        for number in numbers:
            low, high = self.model.free[number].box
            parts: dict[int, Trial] = {}
            for trial in sorted(self.seen, key=_by_cost, reverse=True):
                parts[math.floor(_PARTS * (trial.u[number] - low) / (high - low))] = trial
            starts |= {id(trial): trial for trial in parts.values()}
        if not starts or self.is_exact(fit):
            return fit
        better = self._best_from([*starts.values()], _FEW_EVALUATIONS)
        is_improved = better.trial.cost < fit.trial.cost * (1.0 - IMPROVED)
        return self._finished(better) if is_improved else fit

    def side_by_side(self, calculations: Sequence[Steps[_Result]]) -> list[_Result]:
        """Return the results of several calculations, and answer their questions in one call."""
        results: dict[int, _Result] = {}
        answers: dict[int, Any] = dict.fromkeys(range(len(calculations)))
        while answers:
            questions: dict[int, Question] = {}
            for number, trials in answers.items():
                try:
                    questions[number] = calculations[number].send(trials)
                except StopIteration as end:
                    results[number] = end.value
            answers = dict(zip(questions, self._answers([*questions.values()]), strict=True))
        return [results[number] for number in range(len(calculations))]

    def _answers(self, questions: Sequence[Question]) -> list[list[Trial]]:
        """Return the trials for each of several questions, computed together."""
        if not questions:
            return []
        wanted = [
            np.ones((len(each.places), self.model.data.rows), dtype=bool)
            if each.rows is None
            else each.rows
            for each in questions
        ]
        places = np.concatenate([question.places for question in questions])
        self.computed += len(places)
        found = iter(self.model.trials(places, self.budget, np.concatenate(wanted)))
        answers = [[*islice(found, len(question.places))] for question in questions]
        for question, trials in zip(questions, answers, strict=True):
            if question.rows is None:
                self.seen += trials
                self._note(trials)
        return answers

    def _evolve(self, population: Floats) -> None:
        """Run a differential evolution, from a population (m, p) or from all over the box."""
        low, high = np.array([each.box for each in self.model.free]).T
        start = np.array([each.start for each in self.model.free])
        rounding = _ROUNDING * (high - low)
        begin: dict[str, Any] = {
            "x0": np.clip(start, low + rounding, high - rounding),
            "init": "sobol",
        }
        if len(population):
            begin = {"init": population}
            ends = np.quantile(population, [0.0, 1.0], axis=0)
            low, high = self.model.inside(ends + _BEYOND * np.diff(ends, axis=0) * [[-1.0], [1.0]])
        exact = _ALIKE_EXACT * self.model.squares

        def chi2(places: Floats) -> Floats:
            generation = self.glance(places.T)
            if not self.sweep:
                self.sweep = generation
            return np.array([trial.cost for trial in generation])

        def is_found(intermediate_result: OptimizeResult) -> bool:
            if intermediate_result.nit == 1:  # scipy would take an error in chi2 for its own
                refuse_other_units(self.model.data, self.sweep)
            near = np.ptp(intermediate_result.population, axis=0) < _NEAR * (high - low)
            found = intermediate_result.population_energies
            return bool(near.all() and np.std(found) <= _ALIKE * np.mean(found) + exact)

        differential_evolution(
            chi2,
            list(zip(low, high, strict=True)),
            **begin,
            popsize=_TRIALS,
            maxiter=_GENERATIONS,
            recombination=_RECOMBINATION,
            callback=is_found,
            tol=0.0,
            rng=np.random.default_rng(_SEED),
            vectorized=True,
            updating="deferred",
            polish=False,
        )

    def _distinct(self) -> list[Trial]:
        """Return the best trials seen of different kinds of motion, and the best at a distance.

        The best minimum may belong to a kind of motion whose basin is too narrow for the evolution.
        """
        ranked = sorted(self.seen, key=_by_cost)
        of_kinds = {trial.signature: trial for trial in reversed(ranked)}
        chosen = sorted(of_kinds.values(), key=_by_cost)[:_STARTS]
        apart = self._apart(ranked, _APART)
        hopeful = self._hopeful(of_kinds.values())[:_STARTS]
        return [*{id(trial): trial for trial in (*chosen, *hopeful, *apart)}.values()]

    def _apart(self, ranked: Sequence[Trial], part: float) -> list[Trial]:
        """Return the first trials that lie a fraction of the box apart."""
        apart: list[Trial] = []
        for trial in ranked:
            near = (np.all(np.abs(trial.u - one.u) < part * self.model.wide) for one in apart)
            if len(apart) < _STARTS and not any(near):
                apart.append(trial)
        return apart

    def glance(self, places: Floats) -> list[Trial]:
        """Return quick trials at places (m, p), which show where to look."""
        if not len(places):
            return []
        self.computed += len(places)
        trials = self.model.trials(places, GLANCE)
        self._note(trials)
        # The others could not become the best, whatever their missing values.
        hopeful = self._hopeful(trials)[:_FINALISTS]
        completed = self.model.completed(hopeful, PATIENCE)
        instead = {id(old): new for old, new in zip(hopeful, completed, strict=True)}
        trials = [instead.get(id(trial), trial) for trial in trials]
        self._note(trials)
        self.seen += trials
        return trials

    def _note(self, trials: Iterable[Trial]) -> None:
        whole = (trial.cost for trial in trials if trial.is_whole)
        self._least_cost = min(self._least_cost, *whole, math.inf)

    def _hopeful(self, trials: Iterable[Trial]) -> list[Trial]:
        """Return the incomplete trials that could be the best so far, in order of chi2."""
        could = (t for t in trials if not t.is_whole and t.chi2 < t.part * self._least_cost)
        return sorted(could, key=_by_chi2)

    def _best_from(self, starts: Sequence[Trial], evaluations: int) -> Fit:
        """Return the best minimum reached from these starts."""

        def minimum_from(start: Trial) -> Steps[Fit]:
            # An orbit that was not found at a glance may be found within the budget of a fit.
            trial = start if start.is_settled.all() else (yield from trial_at(start.u))
            fit = yield from fit_at(self.model, trial)
            return (yield from minimum(fit, evaluations))

        return self._best(self.side_by_side([minimum_from(start) for start in starts]))

    def _finished(self, fit: Fit) -> Fit:
        """Return the minimum close to the end of a short fit, with the orbits of a sweep."""
        starts = [fit.trial]
        if fit.at_jump.any():  # a fit ends where it meets the jump, and others meet it elsewhere
            alike = (seen for seen in self.seen if seen.signature == fit.trial.signature)
            starts = self._apart(starts + sorted(alike, key=_by_cost), _CLOSE_BY)
        fit = self._best_from(starts, EVALUATIONS)
        return self._best(self.side_by_side([settled(fit, self._least())]))

    def _best(self, fits: Sequence[Fit]) -> Fit:
        """Return the best of several fits, or of all trials seen if one of them is better.

        A trial that lacks values is completed if it fits better by the data that have values.
        """
        trials = [fit.trial for fit in fits]
        limit = (1.0 - _CLEARLY) * min(trial.cost for trial in trials)
        seen = min((trial for trial in self.seen if trial.is_whole), key=_by_cost, default=None)
        if seen and seen.cost < limit:
            trials.append(seen)
        known = [trial for trial in trials if trial.is_settled.all()]
        best, needed = min(known, key=_by_cost, default=None), self.budget
        others = [trial for trial in trials if not trial.is_settled.all()]
        for trial in sorted(others, key=_by_chi2)[:_FINALISTS]:
            limit = math.inf if best is None else best.cost
            if best is None or trial.chi2 < trial.part * limit:
                found, budget = self._completed(trial, limit)
                if found.cost < limit:
                    best, needed = found, budget if found.is_whole else self.budget
        self.budget = needed
        assert best is not None  # there are trials, settled or completed
        for fit in fits:
            if fit.trial is best:
                return fit
        (fit,) = self.side_by_side([fit_at(self.model, best)])
        return fit

    def _completed(self, trial: Trial, limit: float) -> tuple[Trial, Budget | None]:
        """Return a trial computed in full unless it proves worse, and the budget that it needed."""
        found, needed = trial, self.budget
        for budget in _BUDGETS[_BUDGETS.index(self.budget) + 1 :]:
            if found.is_whole or found.chi2 >= limit:
                break
            (found,), needed = self.model.completed([found], budget), budget
        if found.chi2 < limit and needed is not None:
            (found,) = self.model.completed([found], None)
        self.seen = [found if seen is trial else seen for seen in self.seen]
        return found, needed

    def is_exact(self, fit: Fit) -> bool:
        """Return whether the fit meets the data to all significant digits."""
        return fit.trial.cost <= self._least()

    def _least(self) -> float:
        """Return the largest chi2 that roughness hides."""
        return _EXACT * self.model.squares
