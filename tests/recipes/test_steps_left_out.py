"""Leaving out a step of a recipe causes an error, a status or a failing test."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from support.marks import one_then
from support.recipes import (
    OF_THE_SHELL,
    RECIPES,
    Edit,
    carried_out,
    copied,
    output_of,
    refusal,
    said_by_tests,
    script,
)

from stickslip.options import OFFERED
from stickslip.status import Status


def test_a_figure_without_its_line_is_unknown(tmp_path: Path) -> None:
    copy = copied(tmp_path)
    carried_out(OF_THE_SHELL["figure"][:1], copy)
    assert "errors" in refusal(copy, script("drawn.py"))


@pytest.mark.parametrize(
    ("left_out", "message"),
    [
        ("executor_table", "a.yaml:2: execution.backend: must be 'threads', 'loky' or 'dask', not"),
        ("serial", "No module named 'sweeps.engine.executors.serial'"),
    ],
    ids=["line", "file"],
)
def test_an_executor_without_its_line_or_its_file_is_refused(
    left_out: str, message: str, tmp_path: Path
) -> None:
    copy = copied(tmp_path)
    carried_out([edit for edit in OF_THE_SHELL["executor"] if left_out not in edit.file], copy)
    (copy / "a.yaml").write_text("execution:\n  backend: serial\n")
    assert message in refusal(copy, "from sweeps import run; run('a.yaml')")


CHOSEN = "from stickslip import stationary_orbit; stationary_orbit(method='rk4', max_steps=1)"


def test_a_method_without_its_line_is_unknown(tmp_path: Path) -> None:
    copy = copied(tmp_path)
    carried_out(RECIPES["method"][:1], copy)
    assert "method must be one of adaptive, euler-cromer, not 'rk4'" in refusal(copy, CHOSEN)


@pytest.mark.parametrize("left_out", one_then("stress", OFFERED))
def test_a_method_without_a_function_is_refused_by_its_name(left_out: str, tmp_path: Path) -> None:
    copy, (module, line) = copied(tmp_path), RECIPES["method"]
    less = module.text.replace(f"\ndef {left_out}(", f"\ndef another_{left_out}(")
    carried_out([module._replace(text=less), line], copy)
    assert f"the method stickslip.kernels.rk4 lacks the function {left_out}\n" in refusal(
        copy, CHOSEN
    )


def test_a_config_refuses_noise_that_its_method_lacks(tmp_path: Path) -> None:
    copy = copied(tmp_path)
    carried_out(RECIPES["method"], copy)
    asked = {"integrator": {"method": "rk4", "dt": 1e-6}, "noise": {"treatment": "stochastic"}}
    code = f"from sweeps.config.load import from_mapping; from_mapping({asked})"
    assert "stochastic needs `integrator: {method: adaptive or euler-cromer}`" in refusal(
        copy, code
    )


def without(recipe: str, left_out: str, folder: Path) -> Path:
    """Return a copy with a recipe carried out, except for the step with this text."""
    copy = copied(folder)
    kept = [edit for edit in RECIPES[recipe] if left_out not in f"{edit.file}: {edit.text}"]
    assert len(kept) == len(RECIPES[recipe]) - 1
    carried_out(kept, copy)
    return copy


@pytest.mark.parametrize(
    ("recipe", "left_out", "message"),
    [
        ("integral", "accumulate.py:     DISSIPATED_WORK,", "too many values to unpack"),
        ("state variables", "sprung.SPRUNG", "KeyError: 'sprung'"),
        ("state variables", 'options.py:         "sprung"', "strain must be one of"),
    ],
)
def test_leaving_out_a_step_is_an_error_at_the_start(
    recipe: str, left_out: str, message: str, tmp_path: Path
) -> None:
    copy = without(recipe, left_out, tmp_path)
    code = (
        "from stickslip import Options\n"
        "from stickslip.kernels.adaptive import rows\n"
        "from stickslip.model.models import model_of\n"
        "model_of(Options(strain='sprung').physics)\n"
    )
    assert message in refusal(copy, code)


LEFT_OUT: dict[str, tuple[str, Callable[[Edit], bool], str]] = {
    "the name of the law": ("friction law", lambda e: "options" in e.file, "friction must be one"),
    "the parameter of the law": (
        "friction law",
        lambda e: "eyring_speed" in e.text and "variables" in e.file,
        "eyring_speed",
    ),
    "the new parameter": ("parameter", lambda e: "variables" in e.file, "plateau_viscosity"),
    "the registry": ("result variable", lambda e: "variables" in e.file, "friction_work"),
    "the column": ("result variable", lambda e: "results" in e.file, "friction_work"),
}


@pytest.mark.slow
@pytest.mark.parametrize("step", one_then("stress", [*LEFT_OUT]))
def test_leaving_out_a_step_is_an_error_and_not_a_wrong_number(step: str, tmp_path: Path) -> None:
    name, left_out, message = LEFT_OUT[step]
    copy = copied(tmp_path)
    carried_out([edit for edit in RECIPES[name] if not left_out(edit)], copy)
    law = "eyring" if name == "friction law" else "power-law"
    assert message in refusal(copy, script("row_of_a_law.py"), law, cache=copy / "cache")


@pytest.mark.stress
@pytest.mark.parametrize("method", ["adaptive", "euler-cromer"])
def test_leaving_out_the_loss_of_the_block_violates_the_power_balance(
    method: str, tmp_path: Path
) -> None:
    copy, recipe = copied(tmp_path), RECIPES["force on the block"]
    carried_out([edit for edit in recipe if edit.before != "    return 0.0\n"], copy)
    done = output_of(script("small_sweeps.py"), copy, method, "damped", cache=copy / "cache")
    assert json.loads(done.stdout)["damped"]["status"] == Status.INVARIANT_VIOLATED


@pytest.mark.stress
def test_leaving_out_the_slope_of_the_block_fails_a_test_of_the_model(tmp_path: Path) -> None:
    copy, recipe = copied(tmp_path), RECIPES["force on the block"]
    carried_out([edit for edit in recipe if "stiffness, 0.0" not in edit.before], copy)
    said = said_by_tests(copy, "model/test_block.py")
    assert "5 failed" in said, said
    assert "test_the_slopes_are_those_of_the_force" in said


@pytest.mark.stress
def test_a_law_without_its_derivative_over_phi_fails_a_test_of_laws(tmp_path: Path) -> None:
    copy = copied(tmp_path)
    carried_out(RECIPES["law of the order parameter"], copy)
    law, slope = copy / "stickslip/model/laws/of_the_solid.py", "2.0 * (growth - 1.0) * stress"
    assert slope in law.read_text()
    law.write_text(law.read_text().replace(slope, "0.0"))
    fluid = copy / "stickslip/variables.py"
    fluid.write_text(
        fluid.read_text().replace('"viscosity_growth", default=0.0', '"", default=3.0')
    )
    said = said_by_tests(copy, "model/laws/test_laws.py", "-k", "derivative_over_the_log and solid")
    assert re.search(r"\d+ failed, \d+ deselected", said), said
