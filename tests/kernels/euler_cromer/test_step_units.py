"""Fixed-step lanes have the same equations, with the step as the unit of time."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pytest
from support.parameters import random_parameters
from support.reduced import step_parameters_of

from stickslip.kernels.euler_cromer.step_units import (
    StepParameters,
    step_units,
    step_values,
    to_lane,
)
from stickslip.model import block, drive, film, noise, solids
from stickslip.model.models import model_of
from stickslip.model.rhs import film_melting_function, relative_velocity
from stickslip.model.scaling import Units
from stickslip.options import FRICTION_LAWS, Physics
from stickslip.parameters import Parameters, ParameterValues

INDICES = [-2 / 3, -0.5, 0.0, 0.3, 2 / 3]


class Lane(NamedTuple):
    """A point in SI units and in the units of a lane."""

    p: Parameters
    dt: float
    values: ParameterValues
    own: StepParameters
    units: Units


@pytest.fixture(scope="module", params=FRICTION_LAWS)
def law(request: pytest.FixtureRequest) -> str:
    return request.param


def lane_of(law: str, p: Parameters, steps: int) -> Lane:
    own = step_parameters_of(p, steps, law)
    values, units = step_values(None)(own), step_units(p, steps)
    return Lane(p, drive.period(p) / steps, values, own, units)


def lanes(law: str, count: int = 40) -> list[Lane]:
    rng = np.random.default_rng(20130720)
    return [
        lane_of(law, random_parameters(rng, gamma), int(10.0 ** rng.uniform(2.0, 8.0)))
        for gamma in INDICES
        for _ in range(count)
    ]


def test_a_step_of_a_lane_is_a_step_of_the_point_in_other_units(law: str) -> None:
    stress_and_force, rng = model_of(Physics(law)).equations.exact, np.random.default_rng(1)
    for p, dt, values, own, units in lanes(law):
        n, phi = (
            rng.uniform(0.0, 2 * math.pi) / own.angular_frequency,
            10.0 ** rng.uniform(-9.0, 0.2),
        )
        V = drive.upper_velocity(p, n * dt)
        speed = abs(p.drive_amplitude) * p.angular_frequency
        u = speed * 10.0 ** rng.uniform(-3.0, 0.5) * rng.choice([-1.0, 1.0])
        y = p.drive_amplitude * rng.uniform(-1.5, 1.5), V - u, phi
        x_lane, v_lane, phi_lane = to_lane(units, y)
        u_lane = relative_velocity(values, n, v_lane)
        assert u_lane * units.speed == pytest.approx(u, rel=1e-12 * (1 + speed / abs(u)), abs=0)
        # From here on the slip must agree to the last bits, which a thin film amplifies.
        u = u_lane * units.speed
        stress, F = stress_and_force(p, u, phi)
        stress_lane, F_lane = stress_and_force(values, u_lane, phi_lane)
        assert stress_lane * units.stress == pytest.approx(stress, rel=1e-12, abs=0)
        assert F_lane * units.force == pytest.approx(F, rel=1e-12, abs=0)
        gain = block.acceleration(values, x_lane, v_lane, F_lane) * units.speed
        largest = (abs(F) + 2 * p.spring_stiffness * abs(y[0])) / p.block_mass * dt
        assert gain == pytest.approx(block.acceleration(p, y[0], y[1], F) * dt, abs=1e-12 * largest)
        B = film_melting_function(p, u)
        rate_lane = film.order_parameter_rate(
            values, phi_lane, film_melting_function(values, u_lane)
        )
        strain = u * p.strain_relaxation_time / p.film_thickness
        terms = abs(film.heating(p)) + p.elastic_coefficient * strain**2
        terms += p.cubic_coefficient * phi + p.quartic_coefficient * phi**2
        largest = p.kinetic_coefficient * phi * terms * dt
        rate = film.order_parameter_rate(p, phi, B) * dt
        assert rate_lane == pytest.approx(rate, abs=1e-12 * largest)


def test_the_kick_of_the_noise_is_the_same_in_other_units(law: str) -> None:
    for p, dt, _, own, _ in lanes(law, 10):
        least = own.least_phi
        assert least == pytest.approx(
            math.sqrt(noise.effective_intensity(p) * dt), rel=1e-12, abs=0
        )
        for phi in (0.1 * least, 3.0 * least, 0.5):
            kick = own.D_eff / max(phi, own.least_phi)
            assert kick == pytest.approx(noise.typical_kick(p, phi, dt), rel=1e-12, abs=0)


def test_the_thresholds_of_the_film_are_the_same_in_other_units(law: str) -> None:
    for p, _, values, own, _ in lanes(law, 10):
        solid = solids.solid_threshold(p)
        assert own.solid == pytest.approx(solid, rel=1e-12, abs=0)
        assert own.melted == pytest.approx(solids.MELTED_PART * solid, rel=1e-12, abs=0)
        assert solids.solid_threshold(values) == pytest.approx(own.solid, rel=1e-12, abs=0)


def test_a_film_that_is_always_solid_never_melts(law: str) -> None:
    p = Parameters(cubic_coefficient=0.0, temperature=300.0)
    assert lane_of(law, p, 1000).own.solid == 0.0
    assert lane_of(law, p, 1000).own.melted < 0.0


def test_a_lane_without_elasticity_has_finite_units_and_no_elastic_stress(law: str) -> None:
    lane = lane_of(law, Parameters(elastic_coefficient=0.0), 1000)
    limits = ("soft", "hard")  # a second solid would have these limits, but there is none
    assert all(math.isfinite(x) for name, x in lane.own._asdict().items() if name not in limits)
    assert np.all(np.isfinite(lane.units))
    stress, _ = model_of(Physics(law)).equations.exact(lane.values, 0.3, 0.5)
    assert stress == 0.0
    B = film_melting_function(lane.values, 0.3)
    heating = film.heating(lane.p) * lane.p.kinetic_coefficient / lane.p.angular_frequency
    assert pytest.approx(heating * lane.own.angular_frequency, rel=1e-12, abs=0) == B
