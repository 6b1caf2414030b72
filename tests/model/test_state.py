"""The table of the state: its variables agree with the equations, the units and the symmetry."""

import numpy as np
import pytest

from stickslip.model import scaling
from stickslip.model.rhs import equations, starting_state
from stickslip.model.state import STATE
from stickslip.options import FRICTION_LAWS, Physics
from stickslip.parameters import Parameters

PAPER = Parameters()
WIDTH = len(STATE)
MIRROR = np.array([component.mirror for component in STATE])


def test_the_table_declares_each_variable_once() -> None:
    names = [component.name for component in STATE]
    assert len(set(names)) == len(names) == WIDTH


def test_units_are_fields_of_the_units_of_the_model() -> None:
    for component in STATE:
        assert component.unit == "" or component.unit in scaling.Units._fields


def test_weights_are_positive_and_that_of_the_displacement_is_one() -> None:
    assert STATE[0].weight == 1.0
    assert all(0.0 < component.weight <= 1.0 for component in STATE)


def test_what_is_mirrored_changes_sign_with_the_drive_and_nothing_else_does() -> None:
    there, back = (scaling.units_of(PAPER._replace(drive_amplitude=x)) for x in (1e-6, -1e-6))
    for component in STATE:
        one, other = (getattr(u, component.unit) if component.unit else 1.0 for u in (there, back))
        assert other == component.mirror * one


def test_the_start_is_a_state() -> None:
    assert len(starting_state(PAPER)) == WIDTH


@pytest.mark.parametrize("law", FRICTION_LAWS)
def test_the_equations_have_the_width_of_the_table(law: str) -> None:
    model, y = equations(Physics(law)), starting_state(PAPER)
    assert len(model.rhs(PAPER, 0.1, y, 0.0)) == WIDTH
    assert np.shape(model.jacobian(PAPER, 0.1, y, 0.0)) == (WIDTH + 1, WIDTH)


@pytest.mark.parametrize("law", FRICTION_LAWS)
def test_the_rates_of_the_mirror_image_are_the_mirror_image_of_the_rates(law: str) -> None:
    rhs, rng = equations(Physics(law)).rhs, np.random.default_rng(1)
    for gamma in (-2 / 3, 0.0, 0.7):
        p = PAPER._replace(rheological_index=gamma)
        mirrored = p._replace(drive_amplitude=-p.drive_amplitude)  # what half a period does
        y = rng.uniform(-1.0, 1.0, WIDTH) * [1e-6, 1e-5, 3.0]
        image = rhs(mirrored, 0.1, tuple((MIRROR * y).tolist()), 1e-9)
        np.testing.assert_array_equal(image, MIRROR * rhs(p, 0.1, tuple(y.tolist()), 1e-9))
