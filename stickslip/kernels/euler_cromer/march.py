"""The kernels of Euler-Cromer, which march many points through drive periods in lanes.

A point marches in its own units (step_units.py), and its row of numbers keeps them from the first
period to the last. A kernel works for a given number of steps. Its arrays then hold everything that
it needs to continue. The results equal those of the scalar integrator up to rounding.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from stickslip.compiled.decorators import inline, kernel_factory, named_kernel
from stickslip.compiled.elementary import reciprocal
from stickslip.compiled.fields import make_lane_reader
from stickslip.kernels.euler_cromer.layout import (
    PARAMETERS_BEGIN,
    RECORD_BEGIN,
    row_length,
)
from stickslip.kernels.euler_cromer.step_units import StepParameters, step_values
from stickslip.kernels.families import Family
from stickslip.measure.accumulate import (
    ELAPSED,
    FORCE_MAX,
    STRESS_MAX,
    Moment,
    accumulator,
    make_see_integrals,
)
from stickslip.model import block, drive, film
from stickslip.model.models import model_of
from stickslip.model.noise import TYPICAL_FRACTION
from stickslip.model.rhs import film_melting_function
from stickslip.model.solids import Thresholds, is_soft
from stickslip.model.state import State
from stickslip.numerics.euler_cromer_lanes import (
    NO_RANDOM_NUMBERS,
    WIDTH,
    Chance,
    Tasks,
    get,
    make_euler_cromer_lanes,
)
from stickslip.options import COSINE
from stickslip.parameters import ParameterValues

_record = accumulator(WIDTH, RECORD_BEGIN)
_see_extremum, _see_phase = _record.see_extremum, _record.see_phase
_see_solid = _record.see_solid
_own_parameters = make_lane_reader(StepParameters, PARAMETERS_BEGIN, get)

# sqrt(2 D dt), the random kick of phi in a step, divided by sqrt(D_eff dt).
_RANDOM_KICK = math.sqrt(2.0 / TYPICAL_FRACTION)


class _Lane(NamedTuple):
    """The parameters of a lane in the two forms that a step needs."""

    values: ParameterValues
    own: StepParameters


def _make_sine(tone: drive.Tone) -> Any:
    """Return the function (p, n) of a tone's velocity at step n, and its change from step n - 1."""
    _, velocity, acceleration, _ = drive.upper_of((tone,))
    times = float(tone.harmonic)

    @inline
    def sine(p: _Lane, n: int) -> tuple[float, float]:
        # The exact difference over a step is the slope in its middle times sin(angle/2)/(angle/2).
        angle = times * p.values.angular_frequency
        slope = acceleration(p.values, n - 0.5)
        return velocity(p.values, float(n)), slope * (2.0 * math.sin(0.5 * angle) / angle)

    return sine


@inline
def _kick(phi: float, own: StepParameters) -> float:
    """`noise.typical_kick` for a step of 1, without square root and division."""
    return own.D_eff * reciprocal(phi if phi > own.least_phi else own.least_phi)


def _make_parameters(family: Family) -> Any:
    """Return the function that reads the parameters of a lane, for one family of fluids."""
    one_tone = family.physics.drive == COSINE
    values_of = step_values(family.gamma, higher=family.higher, one_tone=one_tone)

    @inline
    def parameters(lanes: np.ndarray, lane: int) -> _Lane:
        own = _own_parameters(lanes, lane)
        return _Lane(values_of(own), own)

    return parameters


def _make_increments(stress_and_force: Any, *, noisy: bool, chance: bool) -> Any:
    """Return the function of the increments of v and phi in a step from the old state (Eqs. 3, 26).

    It maps (p, V, y, xi) to (dv, dphi), where xi is the random number of stochastic noise.
    """

    @inline
    def increments(p: _Lane, V: float, y: State, xi: float) -> tuple[float, float]:
        x, v, phi = y
        u = V - v
        _, F = stress_and_force(p.values, u, phi)
        rate = film.order_parameter_rate(p.values, phi, film_melting_function(p.values, u))
        return block.acceleration(p.values, x, v, F), rate

    @inline
    def noisy_increments(p: _Lane, V: float, y: State, xi: float) -> tuple[float, float]:
        dv, dphi = increments(p, V, y, xi)
        return dv, dphi + _kick(y[2], p.own)

    @inline
    def random_increments(p: _Lane, V: float, y: State, xi: float) -> tuple[float, float]:
        dv, dphi = increments(p, V, y, xi)
        return dv, dphi + _RANDOM_KICK * p.own.least_phi * xi

    if chance:
        return random_increments
    return noisy_increments if noisy else increments


def _make_observe(stress_and_force: Any, *, measured: bool, two_solids: bool) -> Any:
    """Return the function (p, V, y, lanes, lane) that records a step by the state at its start."""
    see_integrals = make_see_integrals(_record, (1.0,))

    @inline
    def ignore(p: _Lane, V: float, y: State, lanes: np.ndarray, lane: int) -> None:
        pass

    @inline
    def measure(p: _Lane, V: float, y: State, lanes: np.ndarray, lane: int) -> None:
        x, v, phi = y
        u = V - v
        sigma_el, F = stress_and_force(p.values, u, phi)
        _see_extremum(lanes, lane, STRESS_MAX, sigma_el, True)
        _see_extremum(lanes, lane, FORCE_MAX, F, True)
        own = block.own_loss(p.values, x, v)
        # A record begins at phase 0.
        phase = p.values.angular_frequency * get(lanes, RECORD_BEGIN + ELAPSED, lane)
        power, loss = F * v - own, F * u + own
        # F replaces the force computed from the motion. That force shares terms with the step,
        # which the compiler would then round in another way.
        moment = Moment(x, V, u, phi, sigma_el, F, power, loss, F, phase)
        see_integrals(lanes, lane, (moment,), 1.0, True)
        _see_phase(lanes, lane, phi, p.own.solid, p.own.melted, 1.0, True)

    @inline
    def measure_solids(p: _Lane, V: float, y: State, lanes: np.ndarray, lane: int) -> None:
        measure(p, V, y, lanes, lane)
        own, B = p.own, film_melting_function(p.values, V - y[1])
        phases = Thresholds(own.solid, own.soft, own.hard, own.weakest, own.strongest)
        phi = y[2]
        is_liquid, is_hard = phi <= own.melted, phi >= own.hard
        _see_solid(lanes, lane, is_liquid, is_soft(phases, phi, B), is_hard, True)

    if not measured:
        return ignore
    return measure_solids if two_solids else measure


def _chance_of(family: Family) -> Chance:
    """Return the random numbers of lanes; only stochastic noise has any."""
    if not family.physics.chance:
        return NO_RANDOM_NUMBERS
    # Imported here since only stochastic films need it.
    from stickslip.kernels.euler_cromer.stochastic import SIGNS_IN_LANES

    return SIGNS_IN_LANES


@kernel_factory
def march_kernel(family: Family, noisy: bool, measured: bool) -> Any:
    """Return the kernel that marches fluids of one family, with or without noise and record.

    It maps (tasks, queue, budget) to the unused budget. It marches the PENDING rows of `queue` for
    at most `budget` steps of all lanes together; with 0 left, some may still be PENDING. Each case
    has a separate kernel, because each takes seconds to compile and few are used.
    """
    stress_and_force = model_of(family.physics).equations.exact
    chance = _chance_of(family)
    march = make_euler_cromer_lanes(
        _make_parameters(family),
        _make_increments(stress_and_force, noisy=noisy, chance=chance is not NO_RANDOM_NUMBERS),
        _make_observe(stress_and_force, measured=measured, two_solids=family.higher),
        [_make_sine(tone) for tone in drive.TONES_OF[family.physics.drive]],
        row_length(family.physics),
        chance,
    )

    def work(tasks: Tasks, queue: np.ndarray, budget: int) -> int:
        return int(march(tasks, queue, budget))

    name = f"euler_cromer_march[{family},noisy={noisy},measured={measured}]"
    return named_kernel(name, work)
