"""The variables of a model agree with its equations, its units and the symmetry."""

import ast
from pathlib import Path

import numpy as np
import pytest

import stickslip
from stickslip.model.models import Model, model_of
from stickslip.options import FRICTION_LAWS, STRAINS, Physics
from stickslip.parameters import Parameters

PAPER = Parameters()
MODELS = [model_of(Physics(law, strain)) for law in FRICTION_LAWS for strain in STRAINS]

of_each = pytest.mark.parametrize("model", MODELS, ids=lambda model: str(model.physics))


@of_each
def test_the_table_declares_each_variable_once(model: Model) -> None:
    names = [component.name for component in model.components]
    assert len(set(names)) == len(names) == model.width


@of_each
def test_weights_are_positive_and_the_displacement_has_weight_one(model: Model) -> None:
    assert model.components[0].weight == 1.0
    assert all(0.0 < component.weight <= 1.0 for component in model.components)


@of_each
def test_only_mirrored_variables_change_sign_with_the_drive(model: Model) -> None:
    there, back = (
        model.state_units(model.scaling.units_of(PAPER._replace(drive_amplitude=x)))
        for x in (1e-6, -1e-6)
    )
    mirror = [component.mirror for component in model.components]
    assert list(back) == [sign * unit for sign, unit in zip(mirror, there, strict=True)]


@of_each
def test_start_equations_and_weights_have_the_width_of_the_table(model: Model) -> None:
    y, bound = model.start(PAPER), model.equations
    jacobian = bound.jacobian(PAPER, 0.1, y, 0.0)
    assert len(y) == len(bound.rhs(PAPER, 0.1, y, 0.0)) == model.width
    assert np.shape(jacobian) == (model.width + 1, model.width)
    assert len(bound.error_weight(PAPER, 1e-6, y, y, jacobian)) == model.width


@of_each
def test_the_rates_of_the_mirror_image_are_the_mirror_image_of_the_rates(model: Model) -> None:
    rhs, rng = model.equations.rhs, np.random.default_rng(1)
    mirror = np.array([component.mirror for component in model.components])
    sizes = np.array([1e-6, 1e-5, 3.0, 1e-6])[: model.width]
    for gamma in (-2 / 3, 0.0, 0.7):
        p = PAPER._replace(rheological_index=gamma)
        mirrored = p._replace(drive_amplitude=-p.drive_amplitude)  # as half a period later
        y = rng.uniform(-1.0, 1.0, model.width) * sizes
        image = rhs(mirrored, 0.1, tuple((mirror * y).tolist()), 1e-9)
        np.testing.assert_array_equal(image, mirror * rhs(p, 0.1, tuple(y.tolist()), 1e-9))


def test_only_one_module_uses_the_names_of_the_strains() -> None:
    root = Path(stickslip.__file__).parents[1]
    asking = {
        str(file.relative_to(root))
        for package in ("stickslip", "sweeps")
        for file in (root / package).rglob("*.py")
        for node in ast.walk(ast.parse(file.read_text()))
        if isinstance(node, ast.ImportFrom) and node.module == "stickslip.options"
        if {"ADIABATIC", "RELAXING"} & {alias.name for alias in node.names}
    }
    assert asking == {"stickslip/model/models.py"}
