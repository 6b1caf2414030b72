"""The recipes of CONTRIBUTING.md as lists of edits, carried out on copies of the sources.

`sources` has the files that they add, `scripts` the code that runs on a copy.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import stickslip
import sweeps
from support.package import ENDED, copy_of_package

_HERE = Path(__file__).parent
_TESTS = _HERE.parents[1]


class Edit(NamedTuple):
    """New text in a file, before the text `before`; a new file if that is empty."""

    file: str
    before: str
    text: str


def source(file: str) -> str:
    """Return the text of a file that a recipe adds."""
    return (_HERE / "sources" / file).read_text()


def script(file: str) -> str:
    """Return code that runs on a copy."""
    return (_HERE / "scripts" / file).read_text()


def carried_out(recipe: list[Edit], copy: Path) -> set[str]:
    """Apply a recipe to a copy of the sources; return the files that it touched."""
    for edit in recipe:
        path = copy / edit.file
        if not edit.before:
            path.parent.mkdir(exist_ok=True)
            path.write_text(edit.text)
            continue
        text = path.read_text()
        assert text.count(edit.before) == 1, f"{edit.file}: {edit.before!r}"
        path.write_text(text.replace(edit.before, edit.text + edit.before))
    return {edit.file for edit in recipe}


def copied(folder: Path) -> Path:
    """Copy the sources."""
    for package in (stickslip, sweeps):
        copy_of_package(folder, Path(package.__file__).parent)
    return folder


def output_of(
    code: str, copy: Path, *arguments: str, cache: Path | None = None
) -> subprocess.CompletedProcess[str]:
    """Run code on a copy of the sources."""
    environment = os.environ | {"PYTHONPATH": str(copy)}
    if cache is not None:
        environment["NUMBA_CACHE_DIR"] = str(cache)
    return subprocess.run(
        [sys.executable, "-c", code, *arguments],
        cwd=copy,
        env=environment,
        capture_output=True,
        text=True,
        timeout=ENDED,
        check=False,
    )


def refusal(copy: Path, code: str, *arguments: str, cache: Path | None = None) -> str:
    """Return the error with which code ends on a copy of the sources."""
    done = output_of(code, copy, *arguments, cache=cache)
    assert done.returncode != 0
    return done.stderr


def said_by_tests(copy: Path, tests: str, *chosen: str) -> str:
    """Return the output of the project's tests on a copy of the sources."""
    options = ["-q", "-p", "no:cacheprovider", *chosen, str(_TESTS / tests)]
    code = f"import sys, pytest; sys.path.insert(0, {str(_TESTS)!r}); pytest.main({options!r})"
    return output_of(code, copy, cache=copy / "cache").stdout


LAST_PARAMETER = "    noise_intensity: "


def parameter(name: str, symbol: str, unit: str, more: str) -> Edit:
    """Return the edit that adds a parameter to the registry."""
    declared = f'_not_negative("{symbol}", "{symbol}", "{unit}", "{name}", {more})'
    text = f"    {name}: Annotated[float, {declared}]\n"
    return Edit("stickslip/variables.py", LAST_PARAMETER, text)


RK4 = """        "rk4": Method(
            meaning="classical Runge-Kutta with a fixed step, order 4, for teaching",
            module="stickslip.kernels.rk4",
            own_option="dt",
            max_steps=10**15,
            accelerates=False,
            refines=False,
            strains=(ADIABATIC,),
            noises=(TYPICAL_PATH, NO_NOISE),
        ),
"""

STATUS_COLUMN = "    status: Annotated"

RECIPES = {
    "friction law": [
        Edit("stickslip/model/laws/eyring.py", "", source("eyring.py")),
        Edit(
            "stickslip/options.py",
            '        "power-law": "stickslip.model.laws.power_law",\n',
            '        "eyring": "stickslip.model.laws.eyring",\n',
        ),
        parameter("eyring_stress", "sigma_0", "Pa", "default=2e5, in_paper=False"),
        parameter("eyring_speed", "u_0", "m s-1", "default=1e-6, in_paper=False-6"),
    ],
    "law of the order parameter": [
        Edit("stickslip/model/laws/of_the_solid.py", "", source("of_the_solid.py")),
        Edit(
            "stickslip/options.py",
            '        "power-law": "stickslip.model.laws.power_law",\n',
            '        "of-the-solid": "stickslip.model.laws.of_the_solid",\n',
        ),
        parameter("viscosity_growth", "kappa", "1", "default=0.0, in_paper=False"),
    ],
    "state variables": [
        Edit("stickslip/model/sprung.py", "", source("sprung_block.py")),
        Edit(
            "stickslip/model/models.py",
            "    RELAXING: relaxing.RELAXING,\n",
            '    "sprung": sprung.SPRUNG,\n',
        ),
        Edit(
            "stickslip/model/models.py",
            "from stickslip.model.laws import friction_law\n",
            "from stickslip.model import sprung\n",
        ),
        Edit(
            "stickslip/options.py",
            '        RELAXING: "it is an independent variable',
            '        "sprung": "the upper block on a spring of its own",\n',
        ),
        parameter("upper_mass", "M_2", "kg", "default=0.4, in_paper=False"),
        parameter("upper_stiffness", "K_2", "N m-1", "default=1e9, in_paper=False"),
    ],
    "integral": [
        Edit(
            "stickslip/variables.py",
            STATUS_COLUMN,
            "    dissipated_work: Annotated[\n"
            '        float, ResultVariable("W_d", "W_d", "J", "work lost in the film")]\n',
        ),
        Edit(
            "stickslip/measure/results.py",
            "        status=float(m.statuses[i]),\n",
            "        dissipated_work=m.records[i, DISSIPATED_WORK],\n",
        ),
        Edit(
            "stickslip/measure/results.py",
            "    FIRST_PHASE,\n    FIRST_SOLID,\n    FORCE_MAX,\n",
            "    DISSIPATED_WORK,\n",
        ),
        Edit(
            "stickslip/measure/accumulate.py",
            "RECORD_TABLE = (",
            "@inline\ndef _dissipated_power(m: Moment) -> float:\n    return m.F * m.u\n\n\n",
        ),
        Edit(
            "stickslip/measure/accumulate.py",
            '    Slot("largest order parameter",',
            '    Slot("integral of F (V - v)", SUM, WORK, _dissipated_power),\n',
        ),
        Edit(
            "stickslip/measure/accumulate.py",
            "    PHI_MAX,\n    MELTINGS,\n",
            "    DISSIPATED_WORK,\n",
        ),
    ],
    "free energy": [
        parameter("octic_coefficient", "g", "J m-3", "default=0.0, in_paper=False, phi_power=6"),
    ],
    "parameter": [
        parameter("plateau_viscosity", "k_inf", "Pa s", "default=0.0, in_paper=False"),
        Edit(
            "stickslip/model/laws/power_law.py",
            "    return math.copysign(p.viscosity_coefficient * _rate_power",
            "    plateau = p.plateau_viscosity * rate\n"
            "    stress = p.viscosity_coefficient * _rate_power(rate, p.rheological_index)\n"
            "    if p.plateau_viscosity > 0.0:\n"
            "        return math.copysign(stress + plateau, u)\n",
        ),
        Edit(
            "stickslip/model/laws/power_law.py",
            "        return viscosity * rate, viscosity / h * (1.0 + gamma), 0.0\n",
            "        k_inf = p.plateau_viscosity\n"
            "        return (\n"
            "            viscosity * rate + k_inf * rate,\n"
            "            viscosity / h * (1.0 + gamma) + k_inf / h,\n"
            "            0.0,\n"
            "        )\n",
        ),
    ],
    "force on the block": [
        parameter("block_damping", "c_d", "N s m-1", "default=0.0, in_paper=False"),
        Edit(
            "stickslip/model/block.py",
            "    return -2.0 * p.spring_stiffness * x\n",
            "    if p.block_damping > 0.0:\n"
            "        return -2.0 * p.spring_stiffness * x - p.block_damping * v\n",
        ),
        Edit(
            "stickslip/model/block.py",
            "    return -2.0 * p.spring_stiffness, 0.0\n",
            "    if p.block_damping > 0.0:\n"
            "        return -2.0 * p.spring_stiffness, -p.block_damping\n",
        ),
        Edit(
            "stickslip/model/block.py",
            "    return 0.0\n",
            "    if p.block_damping > 0.0:\n        return p.block_damping * v * v\n",
        ),
    ],
    "drive tone": [
        Edit(
            "stickslip/variables.py",
            LAST_PARAMETER,
            "    seventh_harmonic: Annotated[float, ParameterVariable(\n"
            '        "a_7", "a_7", "1", "seventh harmonic", default=0.0,\n'
            "        in_paper=False, measured_in=())]\n",
        ),
        Edit(
            "stickslip/model/drive.py",
            '    tone(5, "fifth_harmonic"),\n',
            '    tone(7, "seventh_harmonic"),\n',
        ),
    ],
    "result variable": [
        Edit(
            "stickslip/variables.py",
            STATUS_COLUMN,
            '    friction_work: Annotated[float, ResultVariable("W_f", "W_f", "J", "friction")]\n',
        ),
        Edit(
            "stickslip/measure/results.py",
            "        status=float(m.statuses[i]),\n",
            "        friction_work=m.records[i, ABSOLUTE_WORK],\n",
        ),
    ],
    "method": [
        Edit("stickslip/kernels/rk4/__init__.py", "", source("runge_kutta.py")),
        Edit("stickslip/options.py", '        "euler-cromer": Method(', RK4),
    ],
}
"""The recipes of what is integrated and measured."""

OF_THE_SHELL = {
    "figure": [
        Edit("sweeps/figures/errors.py", "", source("errors.py")),
        Edit(
            "sweeps/figure_table.py",
            '        "time_courses": FigureEntry(',
            '        "errors": FigureEntry("errors.errors", "sweep", ("amplitude_error",)),\n',
        ),
    ],
    "executor": [
        Edit("sweeps/engine/executors/serial.py", "", source("serial.py")),
        Edit(
            "sweeps/executor_table.py",
            '        "dask": ExecutorEntry(',
            '        "serial": ExecutorEntry("blocks one after the other", "serial"),\n',
        ),
    ],
}
"""The recipes that add nothing to what is integrated or measured."""

SEPTIC = parameter(
    "septic_coefficient", "s", "J m-3", "default=0.0, in_paper=False, phi_power=5, phi_sign=-1"
)
"""With the octic one it allows three solids."""
