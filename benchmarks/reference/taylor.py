"""Half a drive period of the model by Taylor series.

Independent of `stickslip.model` and `stickslip.numerics`: the equations of docs/equations.md are
written out once more, for a pseudoplastic film with gamma = -2/3 and a drive of one cosine, and
each step sums the series of the exact solution. All state variables are summed with compensation,
so that rounding does not add up.

The viscous force goes with the cube root g of the relative velocity u, and its slope is infinite
where u = 0. That kink is located and crossed without being rounded, in one of two ways.

* A block that passes it at speed: g is the independent variable, in which everything is smooth.
* A block that sticks: there the viscous force balances the others, and the attraction to the
  balance is infinite at u = 0. The motion is then the series about that moment which begins with
  g = 0; the moment and the order parameter there are corrected until it leads back to the present.

Units: 1/omega for the time, X_m for the displacement, X_m omega for the velocity, M X_m omega^2 for
the force, X_m omega tau/h for the strain.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from stickslip.parameters import Parameters

Floats = NDArray[np.float64]

# The rows of a table of series.
PHASE, DISPLACEMENT, VELOCITY, FILM, STRAIN, WORK = range(6)
COSINE, SINE, ROOT, STRESS, FORCE = range(6, 11)
_ROWS = 11
_STATES = 6

_BY_PHASE, _BY_ROOT, _BALANCED = range(3)
_NEAR = 0.03  # radians before the kink from which a sticking block may be taken across it
_STRAIN_PASSES = 8
"""A relaxing strain in balance lags by ever higher derivatives of u, each far smaller."""

EXTREMES = ("elastic_stress_max", "elastic_stress_min", "friction_force_max", "friction_force_min")


class Film(NamedTuple):
    """The coefficients of the equations in the units above; `relaxation` is 0 in Eq. 24."""

    spring: float
    elastic: float
    viscous: float
    rest: float
    stretch: float
    cubic: float
    quartic: float
    noise: float
    relaxation: float
    stress_unit: float
    force_unit: float


def film_of(p: Parameters, *, relaxing: bool) -> Film:
    """Return the coefficients of a film with rheological index -2/3."""
    if abs(3.0 * p.rheological_index + 2.0) > 1e-12 or p.third_harmonic or p.fifth_harmonic:
        raise ValueError("only for a rheological index of -2/3 and a drive of one cosine")
    if p.quintic_coefficient or p.sextic_coefficient:
        raise ValueError("only for a free energy of fourth order")
    omega, delta = p.angular_frequency, p.kinetic_coefficient
    speed = p.drive_amplitude * omega
    strain = speed * p.strain_relaxation_time / p.film_thickness
    force = p.block_mass * speed * omega
    viscous_stress = p.viscosity_coefficient * math.cbrt(speed / p.film_thickness)
    return Film(
        spring=2.0 * p.spring_stiffness / (p.block_mass * omega**2),
        elastic=p.contact_area * p.elastic_coefficient * strain / force,
        viscous=p.contact_area * viscous_stress / force,
        rest=2.0 * p.thermal_coefficient * (p.temperature - p.critical_temperature) * delta / omega,
        stretch=p.elastic_coefficient * strain**2 * delta / omega,
        cubic=p.cubic_coefficient * delta / omega,
        quartic=p.quartic_coefficient * delta / omega,
        noise=0.5 * math.exp(-np.euler_gamma) * p.noise_intensity / omega,
        relaxation=1.0 / (omega * p.strain_relaxation_time) if relaxing else 0.0,
        stress_unit=p.elastic_coefficient * strain,
        force_unit=force,
    )


@njit(error_model="numpy")
def half_period(
    film: Film, start: Floats, order: int, tolerance: float, most_steps: int
) -> tuple[Floats, Floats, int]:
    """Return the state half a period later, mirrored; extremes and work; and the number of steps.

    States (6,) are 0, x, u, ln(phi), strain, 0. `tolerance` bounds the last terms of the series.
    """
    state, lost = start.copy(), np.zeros(_STATES)
    reached = np.array([-np.inf, np.inf, -np.inf, np.inf, 0.0])
    for count in range(most_steps):
        y, low, step = _next(film, state, order, tolerance)
        for at, row in ((0, STRESS), (2, FORCE)):
            _note(y[row], low, step, reached[at : at + 2])
        _advance(y, low, step, state, lost)
        if state[PHASE] >= math.pi - 4e-16:
            reached[:2] *= film.stress_unit
            reached[2:4] *= film.force_unit
            reached[4] = state[WORK]
            end = -state
            end[PHASE], end[FILM], end[WORK] = 0.0, state[FILM], 0.0
            return end, reached, count + 1
    return np.full(_STATES, np.nan), reached, most_steps


@njit(error_model="numpy")
def _next(film: Film, state: Floats, order: int, tolerance: float) -> tuple[Floats, float, float]:
    """Return series from a state or near it, where in them it is, and where the step ends."""
    root = np.cbrt(state[VELOCITY])
    cosine = math.cos(state[PHASE])
    elastic = film.elastic * math.exp(2.0 * state[FILM]) * state[STRAIN]
    growth = film.spring * state[DISPLACEMENT] - elastic - film.viscous * root - cosine
    left = math.pi - state[PHASE]
    if abs(growth) < 0.1 * abs(root) * film.viscous and root * growth < 0.0:
        ahead = -3.0 * root**3 / growth
        if ahead < _NEAR and ahead < left:
            y, back, step = _crossing(film, state, ahead, order, tolerance)
            if step > 0.0:
                return y, back, min(step, left + back)
    if abs(root) * film.viscous < abs(growth):
        y = _series(film, state, order, _BY_ROOT)
        step = math.copysign(_longest(y, tolerance), growth)
        if _sum(y[PHASE], step) > math.pi:
            step = _where(y[PHASE], math.pi, 0.0, step)
        return y, 0.0, step
    y = _series(film, state, order, _BY_PHASE)
    return y, 0.0, min(_longest(y, tolerance), left)


@njit(error_model="numpy")
def _crossing(
    film: Film, state: Floats, ahead: float, order: int, tolerance: float
) -> tuple[Floats, float, float]:
    """Return the series of a sticking block about the moment when u = 0, some way `ahead`.

    With the way back to the state, and the longest step ahead, 0 where the series is too short.
    """
    there = state.copy()
    there[PHASE] += ahead
    there[VELOCITY] = there[STRAIN] = there[WORK] = 0.0
    before, missed_before = there[FILM], np.nan
    for _ in range(30):
        y = _series(film, there, order, _BALANCED)
        back, length = state[PHASE] - there[PHASE], _longest(y, tolerance)
        if length < -back:
            return y, 0.0, 0.0
        off = _sum(y[DISPLACEMENT], back) - state[DISPLACEMENT]
        missed = _sum(y[FILM], back) - state[FILM]
        if abs(off) + abs(missed) < 1e-15 * max(1.0, abs(state[FILM])):
            return y, back, length
        there[PHASE] -= off / (math.sin(there[PHASE]) * (1.0 - 1.0 / film.spring))
        slope = (missed - missed_before) / (there[FILM] - before)  # NaN at first
        before, missed_before = there[FILM], missed
        there[FILM] -= missed / slope if abs(slope) > 1e-3 else missed
    return y, 0.0, 0.0


@njit(error_model="numpy")
def _series(film: Film, state: Floats, order: int, kind: int) -> Floats:
    """Return the series of all rows from a state on, in the phase or in the root of u."""
    if kind == _BALANCED and film.relaxation > 0.0:
        strain = np.zeros(order + 1)
        there = state.copy()
        for _ in range(_STRAIN_PASSES):
            y = _filled(film, there, order, kind, strain)
            strain = y[VELOCITY].copy()
            for n in range(order - 1, -1, -1):
                strain[n] -= (n + 1) * strain[n + 1] / film.relaxation
            there[STRAIN] = strain[0]
        return y
    return _filled(film, state, order, kind, np.zeros(0))


@njit(error_model="numpy")
def _filled(film: Film, state: Floats, order: int, kind: int, strain: Floats) -> Floats:
    """Return the series; in balance the strain, if it relaxes, is the one that is given."""
    y = np.zeros((_ROWS, order + 2))
    y[:_STATES, 0] = state
    s, x, w, psi, e = y[PHASE], y[DISPLACEMENT], y[VELOCITY], y[FILM], y[STRAIN]
    c, d, g, stress, force = y[COSINE], y[SINE], y[ROOT], y[STRESS], y[FORCE]
    phi, inverse, phi2, growth, pace = np.zeros((5, order + 2))
    rates = np.zeros((_ROWS, order + 2))
    adiabatic = film.relaxation == 0.0
    c[0], d[0], g[0] = math.cos(s[0]), math.sin(s[0]), np.cbrt(w[0])
    phi[0], inverse[0] = math.exp(psi[0]), math.exp(-2.0 * psi[0])
    if kind == _BY_ROOT:
        g[1] = 1.0
        w[1:4] = 3.0 * g[0] ** 2, 3.0 * g[0], 1.0
    elif kind == _BALANCED:
        e[: strain.size] = strain
        x[0] = (c[0] + film.elastic * phi[0] ** 2 * e[0]) / film.spring
    for n in range(order + 1):
        if n:
            phi[n] = _exponential(psi, phi, n)
            inverse[n] = -2.0 * _exponential(psi, inverse, n)
        if adiabatic:
            e[n] = w[n]
        phi2[n] = _product(phi, phi, n)
        stress[n] = _product(phi2, e, n)
        others = film.spring * x[n] - film.elastic * stress[n] - c[n]
        if n and kind != _BY_ROOT:
            g[n] = _balanced(film, w, g, others, n) if kind == _BALANCED else _root(w, g, n)
        force[n] = film.elastic * stress[n] + film.viscous * g[n]
        growth[n] = others - film.viscous * g[n]
        if n == order:
            break
        melting = film.stretch * _product(e, e, n) - film.cubic * phi[n] + film.quartic * phi2[n]
        rates[PHASE, 0], rates[COSINE, n], rates[SINE, n] = 1.0, -d[n], c[n]
        rates[DISPLACEMENT, n], rates[VELOCITY, n] = -d[n] - w[n], growth[n]
        rates[FILM, n] = film.noise * inverse[n] - melting - (0.0 if n else film.rest)
        rates[STRAIN, n] = film.relaxation * (w[n] - e[n])
        rates[WORK, n] = -_product(force, d, n)
        pace[n] = _pace(w, growth, pace, n) if kind == _BY_ROOT else 0.0
        for row in (PHASE, COSINE, SINE, DISPLACEMENT, VELOCITY, FILM, STRAIN, WORK):
            own = row == VELOCITY and kind != _BY_PHASE
            if not own and not (row == STRAIN and (adiabatic or kind == _BALANCED)):
                rate = _product(rates[row], pace, n) if kind == _BY_ROOT else rates[row, n]
                y[row, n + 1] = rate / (n + 1)
    return y[:, : order + 1]


@njit(error_model="numpy")
def _exponential(psi: Floats, phi: Floats, n: int) -> float:
    """Return coefficient `n` of an exponential: phi' = psi' phi."""
    total = 0.0
    for k in range(1, n + 1):
        total += k * psi[k] * phi[n - k]
    return total / n


@njit(error_model="numpy")
def _root(w: Floats, g: Floats, n: int) -> float:
    """Return coefficient `n` of a cube root: 3 w g' = w' g."""
    total = 0.0
    for k in range(1, n + 1):
        total += (4 * k - 3 * n) * w[k] * g[n - k]
    return float(total / (3 * n * w[0]))


@njit(error_model="numpy")
def _balanced(film: Film, w: Floats, g: Floats, others: float, n: int) -> float:
    """Return coefficient `n` of the root where it begins with 0; writes the next one of u = g^3.

    The viscous force is what the `others` leave when u' has taken its part.
    """
    cube = 0.0
    for k in range(1, n):
        cube += _product(g, g, n + 1 - k) * g[k]
    w[n + 1] = cube
    return (others - (n + 1) * cube) / film.viscous


@njit(error_model="numpy")
def _pace(w: Floats, growth: Floats, pace: Floats, n: int) -> float:
    """Return coefficient `n` of d phase/d g = 3 g^2/u'."""
    total = (n + 1) * w[n + 1]
    for k in range(1, n + 1):
        total -= growth[k] * pace[n - k]
    return float(total / growth[0])


@njit(error_model="numpy")
def _product(a: Floats, b: Floats, n: int) -> float:
    """Return coefficient `n` of the product of two series."""
    total = 0.0
    for k in range(n + 1):
        total += a[k] * b[n - k]
    return total


@njit(error_model="numpy")
def _longest(y: Floats, tolerance: float) -> float:
    """Return the step whose last two terms are within the tolerance, for each state variable."""
    step = np.inf
    for row in range(WORK):
        for k in range(y.shape[1] - 2, y.shape[1]):
            if y[row, k] != 0.0:
                step = min(step, (tolerance / abs(y[row, k])) ** (1.0 / k))
    return step


@njit(error_model="numpy")
def _sum(series: Floats, step: float) -> float:
    total = 0.0
    for k in range(series.size - 1, -1, -1):
        total = total * step + series[k]
    return total


@njit(error_model="numpy")
def _slope(series: Floats, step: float) -> float:
    total = 0.0
    for k in range(series.size - 1, 0, -1):
        total = total * step + k * series[k]
    return total


@njit(error_model="numpy")
def _where(series: Floats, value: float, low: float, high: float) -> float:
    """Return where a sum is `value`, by bisection."""
    rising = _sum(series, high) > value
    for _ in range(80):
        middle = 0.5 * (low + high)
        if (_sum(series, middle) > value) == rising:
            high = middle
        else:
            low = middle
    return high


@njit(error_model="numpy")
def _note(series: Floats, low: float, high: float, reached: Floats) -> None:
    """Widen the range that was `reached` by the end of a step and an extremum within it."""
    at, falls = high, _slope(series, high) < 0.0
    if (_slope(series, low) < 0.0) != falls:
        ends = (low, high)
        for _ in range(60):
            at = 0.5 * (ends[0] + ends[1])
            ends = (ends[0], at) if (_slope(series, at) < 0.0) == falls else (at, ends[1])
    for value in (_sum(series, at), _sum(series, high)):
        reached[0] = max(reached[0], value)
        reached[1] = min(reached[1], value)


@njit(error_model="numpy")
def _advance(y: Floats, low: float, high: float, state: Floats, lost: Floats) -> None:
    """Add the change over a step to a state, with what rounding has `lost` so far (Kahan)."""
    for row in range(_STATES):
        series = y[row].copy()
        if low == 0.0:
            series[0] = 0.0
            change = _sum(series, high)
        elif row == PHASE:
            change = high - low
        elif row in (VELOCITY, STRAIN, DISPLACEMENT, FILM):
            change = _sum(series, high) - state[row]
        else:
            change = _sum(series, high) - _sum(series, low)
        wanted = change - lost[row]
        total = state[row] + wanted
        lost[row] = (total - state[row]) - wanted
        state[row] = total
