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

# Differential evolution: trials for each free parameter, to the next power of 2, and generations.
_TRIALS, _GENERATIONS = 16, 40
# It ends before where chi2 varies by no more than these parts of itself, or of the squares of the
# data, and trials by no more than this part of the box: a plateau alone is no minimum.
_ALIKE, _ALIKE_EXACT, _NEAR = 0.1, 1e-7, 0.1
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
    def dof(self) -> int:
        """Degrees of freedom: data minus parameters."""
        return len(self.trial.residuals) - len(self.trial.u)

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


@dataclass
class Search:
    """The search for the best minimum of a model; deterministic, whatever the start.

    `computed` counts trials; `seen` are those on the way, without those for derivatives; `sweep`
    are the first, evenly spread over the box.
    """

    model: Model
    computed: int = 0
    seen: list[Trial] = field(default_factory=list)
    sweep: list[Trial] = field(default_factory=list)

    def run(self, starts: Sequence[Trial] = ()) -> Fit:
        """Return the best minimum that was found, by an evolution of trials or from `starts`."""
        if not starts:
            self._evolve()
            starts = self._distinct(self.seen)
        best = self._refined(starts, _FEW_EVALUATIONS)
        return self._settled(self._refined([best.trial]))

    def along(self, fit: Fit, numbers: Iterable[int]) -> Fit:
        """Return the best minimum along parameters (numbers) that a minimum does not determine.

        They lie along a valley, whose floor may have several minima: fits begin at the best trial
        in each part of the box along each of them.
        """
        starts: dict[int, Trial] = {}
        for number in numbers:
            low, high = self.model.free[number].box
            parts: dict[int, Trial] = {}
            for trial in sorted(self.seen, key=lambda trial: -trial.chi2):
                parts[math.floor(_PARTS * (trial.u[number] - low) / (high - low))] = trial
            starts |= {id(trial): trial for trial in parts.values()}
        if not starts or self.is_exact(fit):
            return fit
        better = self._refined([*starts.values()], _FEW_EVALUATIONS)
        if better.trial.chi2 >= fit.trial.chi2 * (1.0 - _IMPROVED):
            return fit
        return self._settled(self._refined([better.trial]))

    def _settled(self, fit: Fit) -> Fit:
        """Return a minimum after some steps of Gauss and Newton, where they lead within it.

        The roughness of chi2 ends a fit some 1e-3 standard errors from its minimum, elsewhere from
        each start; its derivative is smooth.
        """
        low, high = np.array([(each.lower, each.upper) for each in self.model.free]).T
        for _ in range(_LAST_STEPS):
            step = -np.linalg.pinv(fit.slopes, rcond=_RANK) @ fit.trial.residuals
            u = fit.trial.u + step
            if not (np.all(np.abs(step) < _SMALL_STEP) and np.all((low < u) & (u < high))):
                break
            (trial,) = self.answers([Question(u)])
            allowed = fit.trial.chi2 * (1.0 + _IMPROVED) + self._least()
            if trial.signature != fit.trial.signature or trial.chi2 > allowed:
                break
            ((slopes, at_jump),) = self.answers([Question(u, trial)])
            fit = Fit(self.model, trial, slopes, at_jump)
        return fit

    def _evolve(self) -> None:
        """See the trials of a differential evolution in the box; the first is the start."""
        low, high = np.array([each.box for each in self.model.free]).T
        exact = _ALIKE_EXACT * self._squares()

        def chi2(places: Floats) -> Floats:
            generation = self._glance(places.T)
            if not self.sweep:
                self.sweep = generation
            return np.array([trial.chi2 for trial in generation])

        def is_found(intermediate_result: OptimizeResult) -> bool:
            if intermediate_result.nit == 1:  # errors of chi2 itself scipy would take for its own
                refuse_other_units(self.model.data, self.sweep)
            near = np.ptp(intermediate_result.population, axis=0) < _NEAR * (high - low)
            found = intermediate_result.population_energies
            return bool(near.all() and np.std(found) <= _ALIKE * np.mean(found) + exact)

        differential_evolution(
            chi2,
            list(zip(low, high, strict=True)),
            x0=[each.start for each in self.model.free],
            init="sobol",
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
        ranked = sorted(trials, key=lambda trial: trial.chi2)
        of_kinds = {trial.signature: trial for trial in reversed(ranked)}
        chosen = sorted(of_kinds.values(), key=lambda trial: trial.chi2)[:_STARTS]
        apart: list[Trial] = []
        for trial in ranked:
            near = (np.all(np.abs(trial.u - one.u) < _APART * (high - low)) for one in apart)
            if len(apart) < _STARTS and not any(near):
                apart.append(trial)
        return [*chosen, *(trial for trial in apart if all(trial is not one for one in chosen))]

    def _glance(self, places: Floats) -> list[Trial]:
        self.computed += len(places)
        trials = self.model.trials(places, GLANCE)
        self.seen += trials
        return trials

    def _refined(self, starts: Sequence[Trial], evaluations: int = _EVALUATIONS) -> Fit:
        """Return the best minimum that fits from these starts, side by side, lead to."""
        together = Together(self.answers)
        fits = together.run(
            lambda start: minimum(self.model, start.u, together.ask, evaluations), starts
        )
        return min(fits, key=lambda fit: fit.trial.chi2)

    def answers(self, questions: list[Question]) -> list[Any]:
        """Return a trial for each question or, where it has one already, its derivatives."""
        fresh = [question.u for question in questions if question.trial is None]
        found = self.model.trials(np.array(fresh), PATIENCE) if fresh else []
        self.seen += found
        trials = iter(found)
        given = [question.trial for question in questions if question.trial is not None]
        slopes = iter(self.model.all_slopes(given, PATIENCE))
        self.computed += len(fresh) + 2 * len(self.model.free) * len(given)
        return [next(trials) if q.trial is None else next(slopes) for q in questions]

    def is_exact(self, fit: Fit) -> bool:
        """Tell whether the data are met to all digits that count."""
        return fit.trial.chi2 <= self._least()

    def _least(self) -> float:
        """Return what chi2 cannot tell from 0."""
        return _EXACT * self._squares()

    def _squares(self) -> float:
        """Return chi2 of a model that gives 0."""
        data = self.model.data
        return float(np.sum((data.value / data.error) ** 2))


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

    def __init__(self, model: Model, ask: Any, evaluations: int = _EVALUATIONS) -> None:
        self._model = model
        self._evaluations = evaluations
        self._ask = ask
        self._pull = _PULL * float(np.linalg.norm(model.data.value / model.data.error))
        self._origin = np.zeros(len(model.free))
        self._tried: list[Trial] = []

    def fit(self, start: Floats, fixed: int | None = None) -> Trial:
        """Return the minimum that lmfit finds from a place (p,); one parameter may be fixed.

        It is the best trial on the way: lmfit's result is the last one where evaluations run out.
        """
        self._origin = start
        self._tried = [self.trial(start)]
        parameters = self._parameters(start, fixed)
        if any(parameter.vary for parameter in parameters.values()):
            minimizer = lmfit.Minimizer(
                self._residuals, parameters, calc_covar=False, max_nfev=self._evaluations
            )
            with np.errstate(all="ignore"):  # of lmfit's covariance, which is not used
                minimizer.least_squares(jac=self._slopes, **_TOLERANCES)
        return min(self._tried, key=lambda trial: trial.chi2)

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
        result.residual = self.trial(u).residuals
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
        return np.append(self.trial(u).residuals, pulled)

    def _slopes(self, parameters: Any) -> Floats:
        u = self._place(parameters)
        slopes: Floats = self._ask(Question(u, self.trial(u)))[0]
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
        low, high = np.array([(free.lower, free.upper) for free in self._model.free]).T
        place: Floats = np.clip(self._origin + distances, low, high)
        return place
