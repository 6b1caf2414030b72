"""From a start to the best minimum: an evolution of trials, and fits from its best."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import lmfit
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import OptimizeResult, differential_evolution

from sweeps.fitting.together import Together
from sweeps.fitting.trials import Budget, Model, Trial, refuse_other_units
from sweeps.measurements import Floats

# Budgets of trials that only show where to begin, of those that lead to the minimum. Nearly
# all orbits are found within the first; one that goes on is mostly chaotic and costs hundreds.
GLANCE, PATIENCE = Budget(64, 30_000), Budget(256, 300_000)
# Then of trials that could be the best but for data without a value: up to that of a sweep, which
# is all that the options allow.
_BUDGETS: tuple[Budget | None, ...] = (PATIENCE, Budget(1024, 3_000_000), None)
_FINALISTS = 4  # trials that are computed in full before they are compared

# Differential evolution: trials for each free parameter, to the next power of 2, and generations.
_TRIALS, _GENERATIONS = 16, 40
# It ends before where chi2 varies by no more than these parts of itself, or of the squares of the
# data, and trials by no more than this part of the box: a plateau alone is no minimum.
_ALIKE, _ALIKE_EXACT, _NEAR = 0.1, 1e-7, 0.1
# By how much of its extent a population that is looked at more closely may leave it.
_BEYOND = 0.5
# A vector between two others is taken whole: valleys lie askew to the axes.
_RECOMBINATION = 1.0

_PARTS = 16  # of the box along a parameter that is not determined
_STARTS, _APART = 3, 0.1  # fits of other kinds, and apart from each other by a part of the box

# Of a fit in lmfit and scipy: relative changes of chi2 and of parameters. The gradient is no
# measure, since residuals have no scale. Below, the roughness of the amplitudes would decide.
_TOLERANCES: dict[str, Any] = {"ftol": 1e-6, "xtol": 1e-7, "gtol": None}
_PULL = 1e-9  # of a natural unit by which a parameter is off, relative to the amplitudes
_EVALUATIONS, _FEW_EVALUATIONS = 40, 12

_IMPROVED = 1e-6  # part of chi2
_CLEARLY = 1e-5  # part of it that is more than the last steps may give away
_EXACT = 1e-15  # of the squares of the data: the rest is roughness
_SEED = 1

_LAST_STEPS, _SMALL_STEP = 2, 0.1
_RANK = 1e-6  # a singular value below this part of the largest is none


@dataclass
class Fit:
    """A minimum: the trial there, the derivatives (n, p), data next to a jump (n,).

    `scale` is the variance of residuals: chi2/dof, or 1 where that is less and errors are known.
    """

    model: Model
    trial: Trial
    slopes: Floats
    at_jump: NDArray[np.bool_]

    @property
    def left_out(self) -> NDArray[np.bool_]:
        """Data (n,) of which the statistics take no account: those with an orbit at a jump."""
        left_out: NDArray[np.bool_] = self.at_jump & self.trial.is_settled[self.model.data.row]
        return left_out

    @property
    def dof(self) -> int:
        """Degrees of freedom: data that have a value, minus parameters."""
        return int(self.trial.known.sum()) - len(self.trial.u)

    @property
    def reduced(self) -> float:
        """chi2/dof; NaN without degrees of freedom."""
        return self.trial.chi2 / self.dof if self.dof > 0 else math.nan

    @property
    def scale(self) -> float:
        """The variance of a residual, as far as it is known."""
        if self.model.data.relative:
            return self.reduced
        return max(1.0, self.reduced) if self.dof > 0 else 1.0


def population_of(model: Model) -> int:
    """Return how many trials are a generation."""
    return int(2 ** math.ceil(math.log2(_TRIALS * len(model.free))))


@dataclass
class Search:
    """The search for the best minimum of a model; deterministic, whatever the start.

    `computed` counts trials; `seen` are those on the way, without those for derivatives; `sweep`
    are the first, evenly spread over the box. `budget` is that of the trials that lead to a
    minimum: what the best of them needed.
    """

    model: Model
    computed: int = 0
    seen: list[Trial] = field(default_factory=list)
    sweep: list[Trial] = field(default_factory=list)
    budget: Budget | None = PATIENCE
    _least_cost: float = math.inf  # of whole trials so far

    def run(self, starts: Sequence[Trial] = (), population: Sequence[Trial] = ()) -> Fit:
        """Return the best minimum that was found, from `starts` or by an evolution of trials.

        It begins all over the box or, to look closer, with a `population`.
        """
        if not starts:
            self._evolve(np.array([trial.u for trial in population]))
            starts = self._distinct(self.seen)
        best = self._refined(starts, _FEW_EVALUATIONS)
        return self._in_full(self._settled(self._refined([best.trial])))

    def along(self, fit: Fit, numbers: Iterable[int]) -> Fit:
        """Return the best minimum along parameters (numbers) that a minimum does not determine.

        They lie along a valley, whose floor may have several minima: fits begin at the best trial
        in each part of the box along each of them.
        """
        starts: dict[int, Trial] = {}
        for number in numbers:
            low, high = self.model.free[number].box
            parts: dict[int, Trial] = {}
            for trial in sorted(self.seen, key=lambda trial: -trial.cost):
                parts[math.floor(_PARTS * (trial.u[number] - low) / (high - low))] = trial
            starts |= {id(trial): trial for trial in parts.values()}
        if not starts or self.is_exact(fit):
            return fit
        better = self._refined([*starts.values()], _FEW_EVALUATIONS)
        if better.trial.cost >= fit.trial.cost * (1.0 - _IMPROVED):
            return fit
        return self._in_full(self._settled(self._refined([better.trial])))

    def _settled(self, fit: Fit) -> Fit:
        """Return a minimum after some steps of Gauss and Newton, where they lead within it.

        The roughness of chi2 ends a fit some 1e-3 standard errors from its minimum, elsewhere from
        each start; its derivative is smooth.
        """
        for _ in range(_LAST_STEPS):
            step = -np.linalg.pinv(fit.slopes, rcond=_RANK) @ fit.trial.residuals
            u = fit.trial.u + step
            if not (np.all(np.abs(step) < _SMALL_STEP) and self.model.are_inside(u[None])[0]):
                break
            (trial,) = self.answers([Question(u)])
            allowed = fit.trial.cost * (1.0 + _IMPROVED) + self._least()
            if trial.signature != fit.trial.signature or trial.cost > allowed:
                break
            ((slopes, at_jump),) = self.answers([Question(u, trial)])
            fit = Fit(self.model, trial, slopes, at_jump)
        return fit

    def _evolve(self, population: Floats) -> None:
        """See the trials of a differential evolution, from places (m, p) or all over the box."""
        low, high = np.array([each.box for each in self.model.free]).T
        begin: dict[str, Any] = {"x0": [each.start for each in self.model.free], "init": "sobol"}
        if len(population):
            begin = {"init": population}
            ends = np.quantile(population, [0.0, 1.0], axis=0)
            low, high = self.model.inside(ends + _BEYOND * np.diff(ends, axis=0) * [[-1.0], [1.0]])
        exact = _ALIKE_EXACT * self._squares()

        def chi2(places: Floats) -> Floats:
            generation = self.glance(places.T)
            if not self.sweep:
                self.sweep = generation
            return np.array([trial.cost for trial in generation])

        def is_found(intermediate_result: OptimizeResult) -> bool:
            if intermediate_result.nit == 1:  # errors of chi2 itself scipy would take for its own
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

    def _distinct(self, trials: Sequence[Trial]) -> list[Trial]:
        """Return the best trials of different kinds of motion, and the best apart from each other.

        A kind of its own may have the best minimum in a place too narrow for the evolution.
        """
        low, high = np.array([each.box for each in self.model.free]).T
        ranked = sorted(trials, key=_cost)
        of_kinds = {trial.signature: trial for trial in reversed(ranked)}
        chosen = sorted(of_kinds.values(), key=_cost)[:_STARTS]
        apart: list[Trial] = []
        for trial in ranked:
            near = (np.all(np.abs(trial.u - one.u) < _APART * (high - low)) for one in apart)
            if len(apart) < _STARTS and not any(near):
                apart.append(trial)
        hopeful = self._hopeful(of_kinds.values())[:_STARTS]
        return [*{id(trial): trial for trial in (*chosen, *hopeful, *apart)}.values()]

    def glance(self, places: Floats) -> list[Trial]:
        """Return trials at places (m, p) that show where to look."""
        if not len(places):
            return []
        self.computed += len(places)
        trials = self.model.trials(places, GLANCE)
        self._note(trials)
        # What is missing in the others could not make them the best.
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
        """Return trials without some values that are the best so far by their others, in order."""
        could = (t for t in trials if not t.is_whole and t.chi2 < t.part * self._least_cost)
        return sorted(could, key=_chi2)

    def _refined(self, starts: Sequence[Trial], evaluations: int = _EVALUATIONS) -> Fit:
        """Return the best minimum that fits from these starts, side by side, lead to."""
        together = Together(self.answers)
        fits = together.run(
            lambda start: minimum(self.model, start.u, together.ask, evaluations), starts
        )
        best = self._compared([fit.trial for fit in fits])
        for fit in fits:
            if fit.trial is best:
                return fit
        return self._fit_at(best)

    def _in_full(self, fit: Fit) -> Fit:
        """Return a minimum whose orbits are computed as by a sweep, or a better one."""
        best = self._compared([fit.trial])
        return fit if best is fit.trial else self._fit_at(best)

    def _fit_at(self, trial: Trial) -> Fit:
        ((slopes, at_jump),) = self.answers([Question(trial.u, trial)])
        return Fit(self.model, trial, slopes, at_jump)

    def _compared(self, trials: Sequence[Trial]) -> Trial:
        """Return the best of trials and of what was seen; those that could be it are completed.

        Those are the ones that fit better by the data that they have a value of.
        """
        limit = (1.0 - _CLEARLY) * min(trial.cost for trial in trials)
        seen = min((trial for trial in self.seen if trial.is_whole), key=_cost, default=None)
        if seen and seen.cost < limit:
            trials = [*trials, seen]
        settled = [trial for trial in trials if trial.is_settled.all()]
        best, needed = min(settled, key=_cost, default=None), self.budget
        others = [trial for trial in trials if not trial.is_settled.all()]
        for trial in sorted(others, key=_chi2)[:_FINALISTS]:
            limit = math.inf if best is None else best.cost
            if trial.chi2 < trial.part * limit or best is None:
                found, budget = self._completed(trial, limit)
                if found.cost < limit:
                    best, needed = found, budget if found.is_whole else self.budget
        self.budget = needed
        assert best is not None  # there are trials, all settled or not
        return best

    def _completed(self, trial: Trial, limit: float) -> tuple[Trial, Budget | None]:
        """Return a trial computed in full, unless it proves worse, and the budget it needed."""
        found, needed = trial, self.budget
        for budget in _BUDGETS[_BUDGETS.index(self.budget) + 1 :]:
            if found.is_whole or found.chi2 >= limit:
                break
            (found,), needed = self.model.completed([found], budget), budget
        if found.chi2 < limit and needed is not None:
            (found,) = self.model.completed([found], None)
        self.seen = [found if seen is trial else seen for seen in self.seen]
        return found, needed

    def answers(self, questions: list[Question]) -> list[Any]:
        """Return a trial for each question or, where it has one already, its derivatives."""
        fresh = [question.u for question in questions if question.trial is None]
        found = self.model.trials(np.array(fresh), self.budget) if fresh else []
        self.seen += found
        self._note(found)
        trials = iter(found)
        given = [question.trial for question in questions if question.trial is not None]
        slopes = iter(self.model.all_slopes(given, self.budget))
        self.computed += len(fresh) + 2 * len(self.model.free) * len(given)
        return [next(trials) if q.trial is None else next(slopes) for q in questions]

    def is_exact(self, fit: Fit) -> bool:
        """Tell whether the data are met to all digits that count."""
        return fit.trial.cost <= self._least()

    def _least(self) -> float:
        """Return what chi2 cannot tell from 0."""
        return _EXACT * self._squares()

    def _squares(self) -> float:
        """Return chi2 of a model that gives 0."""
        data = self.model.data
        return float(np.sum((data.value / data.error) ** 2))


def _cost(trial: Trial) -> float:
    return trial.cost


def _chi2(trial: Trial) -> float:
    return trial.chi2


class Question(NamedTuple):
    """A place to try or, with a trial, a question for the derivatives there."""

    u: Floats
    trial: Trial | None = None


def minimum(model: Model, start: Floats, ask: Any, evaluations: int) -> Fit:
    """Return the minimum that lmfit finds from a place (p,), a valley or the edge of a jump."""
    trial = Minimizer(model, ask, evaluations).fit(start)
    slopes, at_jump = ask(Question(trial.u, trial))
    return Fit(model, trial, slopes, at_jump)


class Minimizer:
    """lmfit's view of a model: residuals and derivatives as functions of its Parameters.

    Its parameters are distances from an origin. That of a fit is its start, so that the first step
    is one of a unit, not of the size of a logarithm. A spring holds them there, so weak that it
    moves only those that change nothing: solvers cannot do with derivatives that are all 0.
    """

    def __init__(
        self,
        model: Model,
        ask: Any,
        evaluations: int = _EVALUATIONS,
        left_out: NDArray[np.bool_] | None = None,
    ) -> None:
        none = np.zeros(len(model.data.value), dtype=bool)
        self._model = model
        self._left_out = none if left_out is None else left_out
        self._evaluations = evaluations
        self._ask = ask
        self._pull = _PULL * float(np.linalg.norm(model.data.value / model.data.error))
        self._origin = np.zeros(len(model.free))
        self._gaps = none  # data without a value at the start
        self._tried: list[Trial] = []

    def fit(self, start: Floats, fixed: int | None = None) -> Trial:
        """Return the minimum that lmfit finds from a place (p,); one parameter may be fixed.

        It is the best trial on the way: lmfit's result is the last one where evaluations run out.
        Data that have no value at the start are left out, for as long as they have none.
        """
        self._origin = start
        self._tried = [self.trial(start)]
        self._gaps = ~self._tried[0].known
        parameters = self._parameters(start, fixed)
        if any(parameter.vary for parameter in parameters.values()):
            minimizer = lmfit.Minimizer(
                self._residuals, parameters, calc_covar=False, max_nfev=self._evaluations
            )
            with np.errstate(all="ignore"):  # of lmfit's covariance, which is not used
                minimizer.least_squares(jac=self._slopes, **_TOLERANCES)
        return min(self._tried, key=lambda trial: float(np.sum(self._misfits(trial) ** 2)))

    def at(self, u: Floats, errors: Floats) -> tuple[Any, Any]:
        """Return lmfit's Minimizer and result for a minimum (p,) with these standard errors."""
        self._origin = np.zeros(len(u))  # the first step of a profile is a part of the value
        # lmfit makes profiles with another solver, which has other options.
        minimizer = lmfit.Minimizer(
            self._residuals,
            self._parameters(u),
            scale_covar=False,
            Dfun=self._slopes,
            ftol=_TOLERANCES["ftol"],
            xtol=_TOLERANCES["ftol"],
        )
        result = minimizer.prepare_fit()
        for free, error in zip(self._model.free, errors, strict=True):
            result.params[free.name].stderr = error
        self._gaps = ~self.trial(u).known
        result.residual = self._misfits(self.trial(u))
        result._calculate_statistics()
        return minimizer, result

    def _parameters(self, start: Floats, fixed: int | None = None) -> Any:
        parameters = lmfit.Parameters()
        for number, (free, u) in enumerate(zip(self._model.free, start, strict=True)):
            origin = self._origin[number]
            limits = {"min": free.lower - origin, "max": free.upper - origin}
            parameters.add(free.name, value=float(u - origin), vary=number != fixed, **limits)
        return parameters

    def trial(self, u: Floats) -> Trial:
        """Return the trial at a place (p,); the last one is not computed again."""
        if not self._tried or not np.array_equal(self._tried[-1].u, u):
            self._tried.append(self._ask(Question(u)))
        return self._tried[-1]

    def _residuals(self, parameters: Any) -> Floats:
        u = self._place(parameters)
        pulled = self._pull * (u - self._origin)[self._varied(parameters)]
        return np.append(self._misfits(self.trial(u)), pulled)

    def _misfits(self, trial: Trial) -> Floats:
        """Return the residuals (n,) that lmfit is to make small."""
        return np.where(self._left_out | self._gaps & ~trial.known, 0.0, trial.residuals)

    def _slopes(self, parameters: Any) -> Floats:
        u = self._place(parameters)
        slopes = np.where(self._left_out[:, None], 0.0, self._ask(Question(u, self.trial(u)))[0])
        pulled = self._pull * np.eye(len(u))
        return np.concatenate([slopes, pulled[self._varied(parameters)]])[
            :, self._varied(parameters)
        ]

    def _varied(self, parameters: Any) -> list[int]:
        """Return the numbers of the parameters that are not fixed."""
        return [
            number for number, free in enumerate(self._model.free) if parameters[free.name].vary
        ]

    def _place(self, parameters: Any) -> Floats:
        distances = [parameters[free.name].value for free in self._model.free]
        return self._model.inside(self._origin + distances)
