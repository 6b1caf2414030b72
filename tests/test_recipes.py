"""The recipes of CONTRIBUTING.md, each carried out on a copy of the sources, run and seen to work.

A recipe is a list of edits of files. All are applied to one copy, so that it is compiled once; a
small sweep in each method then shows that the numbers change as they should.
"""

from __future__ import annotations

import json
import math
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pytest
from support.marks import one_then

import stickslip
import sweeps

ENDED = 540.0  # seconds: a hang, on any machine


class Edit(NamedTuple):
    """In a file, `before` this text stands the new one; a new file where that is empty."""

    file: str
    before: str
    text: str


EYRING = '''"""Eyring's law of thermally activated flow: the stress grows as asinh of the speed."""

from __future__ import annotations

import math

from stickslip.compiled.decorators import inline
from stickslip.model.laws import FrictionLaw
from stickslip.parameters import Parameters


@inline
def _stress(p: Parameters, u: float) -> float:
    x = abs(u) / p.eyring_speed
    size = p.eyring_stress * math.log(x + math.sqrt(x * x + 1.0))
    return math.copysign(size, u)


@inline
def _slope(p: Parameters, u: float) -> float:
    x = u / p.eyring_speed
    return p.eyring_stress / p.eyring_speed / math.sqrt(x * x + 1.0)


@inline
def _rounded(p: Parameters, u: float, u_s: float) -> tuple[float, float]:
    return _stress(p, u), _slope(p, u)


@inline
def _never(p: Parameters) -> bool:
    return False


@inline
def _stable_slope(p: Parameters, u: float) -> float:
    return _slope(p, 0.0)


LAW = FrictionLaw(
    name="eyring",
    stress=_stress,
    rounded=_rounded,
    has_cusp=_never,
    stable_slope=_stable_slope,
    parameters=("eyring_stress", "eyring_speed"),
)
'''

LAST_PARAMETER = '    _not_negative("noise_intensity",'


def parameter(name: str, symbol: str, unit: str, more: str) -> Edit:
    """A parameter in the registry."""
    text = f'    _not_negative("{name}", "{symbol}", "{symbol}", "{unit}", "{name}", {more}),\n'
    return Edit("stickslip/variables.py", LAST_PARAMETER, text)


STATUS_COLUMN = '    ResultVariable("status",'

RECIPES = {
    "friction law": [
        Edit("stickslip/model/laws/eyring.py", "", EYRING),
        Edit(
            "stickslip/options.py",
            '        "power-law": "stickslip.model.laws.power_law",\n',
            '        "eyring": "stickslip.model.laws.eyring",\n',
        ),
        parameter("eyring_stress", "sigma_0", "Pa", "default=2e5, neutral=2e5"),
        parameter("eyring_speed", "u_0", "m s-1", "default=1e-6, neutral=1e-6"),
    ],
    "free energy": [
        parameter("sextic_coefficient", "e", "J m-3", "default=0.0, neutral=0.0, phi_power=4"),
        Edit(
            "stickslip/model/film.py",
            "    return harmonic - cubic",
            "    sextic = p.sextic_coefficient / 6.0 * (phi2 * phi2 * phi2)\n"
            "    harmonic = harmonic + sextic\n",
        ),
        Edit(
            "stickslip/model/film.py",
            "    return B - p.cubic_coefficient * phi",
            "    B = B + p.sextic_coefficient * (phi * phi) * (phi * phi)\n",
        ),
        Edit(
            "stickslip/model/film.py",
            "    return phi * (2.0 * p.quartic_coefficient * phi",
            "    if p.sextic_coefficient > 0.0:\n"
            "        sextic = 4.0 * p.sextic_coefficient * (phi * phi) * (phi * phi)\n"
            "        quartic = 2.0 * p.quartic_coefficient * phi - p.cubic_coefficient\n"
            "        return phi * quartic + sextic\n",
        ),
    ],
    "parameter": [
        parameter("plateau_viscosity", "k_inf", "Pa s", "default=0.0, neutral=0.0"),
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
            "        return viscosity * rate, viscosity / h * (1.0 + gamma)\n",
            "        k_inf = p.plateau_viscosity\n"
            "        return (\n"
            "            viscosity * rate + k_inf * rate,\n"
            "            viscosity / h * (1.0 + gamma) + k_inf / h,\n"
            "        )\n",
        ),
    ],
    "result variable": [
        Edit(
            "stickslip/variables.py",
            STATUS_COLUMN,
            '    ResultVariable("friction_work", "W", "W", "J", "work of the friction force"),\n',
        ),
        Edit(
            "stickslip/measure/results.py",
            "        status=float(m.status),\n",
            "        friction_work=m.record[ABSOLUTE_WORK],\n",
        ),
    ],
}
"""The recipes that are carried out; the figure comes below."""

FIGURE = '''"""The stated error of the amplitudes, along the first axis."""

from __future__ import annotations

import xarray as xr
from matplotlib.figure import Figure


def errors(ds: xr.Dataset) -> Figure:
    """The amplitude errors of a sweep."""
    figure = Figure()
    axes = figure.add_subplot()
    axes.semilogy(ds.amplitude_error.values.ravel())
    return figure
'''

FIGURE_RECIPE = [
    Edit("sweeps/figures/errors.py", "", FIGURE),
    Edit(
        "sweeps/figure_table.py",
        '        "time_courses": FigureEntry(',
        '        "errors": FigureEntry("errors.errors", "sweep", ("amplitude_error",)),\n',
    ),
]
DRAWN = """
import json, sys
import numpy as np, xarray as xr
from sweeps.config.load import from_mapping
from sweeps.figures import draw
ds = xr.Dataset({"amplitude_error": ("temperature", [1e-7, 2e-7])}, {"temperature": [200.0, 250.0]})
line = draw(ds, from_mapping({"plot": {"figure": "errors"}}).plot.figure).axes[0].lines[0]
json.dump(line.get_ydata().tolist(), sys.stdout)
"""

MOST_FILES = {
    "friction law": 3,
    "free energy": 2,
    "parameter": 2,
    "result variable": 2,
    "figure": 2,
}
"""Files at most, as the table of CONTRIBUTING.md says."""

SMALL_SWEEPS = """
import json, sys
from sweeps import run

MODEL = {"gamma": 0, "T": 250, "delta": 1.0, "omega": 30, "x_0": 0.8e-6, "phi_0": 0.6}
METHODS = {"adaptive": {"rtol": 1e-5}, "euler-cromer": {"method": "euler-cromer", "dt": 1e-6}}
EYRING = {"friction": "eyring"}
CASES = {
    "plain": ({}, {}),
    "eyring": ({"gamma": "-2/3"}, EYRING),
    "stiffer eyring": ({"gamma": "-2/3", "eyring_stress": 4e5}, EYRING),
    "liquid eyring": ({"gamma": "-2/3", "T": 310, "K": 1e4}, EYRING),
    "sextic": ({"sextic_coefficient": 400.0}, {}),
    "plateau": ({"plateau_viscosity": 5e4}, {}),
}
found = {}
for case, (changes, film) in CASES.items():
    ds = run(
        {
            "model": MODEL | changes,
            "film": film,
            "integrator": METHODS[sys.argv[1]],
            "stationary": {"rtol": 1e-5},
        },
        workers=1,
    )
    found[case] = {name: float(ds[name]) for name in ds.data_vars}
json.dump(found, sys.stdout)
"""


def carried_out(recipe: list[Edit], copy: Path) -> set[str]:
    """Apply a recipe to a copy of the sources; the files that it touched."""
    for edit in recipe:
        path = copy / edit.file
        if not edit.before:
            path.write_text(edit.text)
            continue
        source = path.read_text()
        assert source.count(edit.before) == 1, f"{edit.file}: {edit.before!r}"
        path.write_text(source.replace(edit.before, edit.text + edit.before))
    return {edit.file for edit in recipe}


def copied(folder: Path) -> Path:
    for package in (stickslip, sweeps):
        source = Path(package.__file__).parent
        ignore = shutil.ignore_patterns("__pycache__")
        shutil.copytree(source, folder / package.__name__, ignore=ignore)
    return folder


def output_of(
    code: str, copy: Path, *arguments: str, cache: Path | None = None
) -> subprocess.CompletedProcess[str]:
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


@pytest.fixture(scope="module")
def changed_copy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The sources with all recipes carried out."""
    copy = copied(tmp_path_factory.mktemp("copy"))
    for recipe in RECIPES.values():
        carried_out(recipe, copy)
    return copy


def results_of(copy: Path, method: str) -> dict[str, dict[str, float]]:
    """What small sweeps by a method give, by case."""
    done = output_of(SMALL_SWEEPS, copy, method, cache=copy / "cache")
    assert done.returncode == 0, done.stderr
    found: dict[str, dict[str, float]] = json.loads(done.stdout)
    return found


@pytest.fixture(scope="module")
def adaptive(changed_copy: Path) -> dict[str, dict[str, float]]:
    return results_of(changed_copy, "adaptive")


@pytest.fixture(scope="module")
def fixed(changed_copy: Path) -> dict[str, dict[str, float]]:
    return results_of(changed_copy, "euler-cromer")


@pytest.mark.parametrize("name", RECIPES)
def test_a_recipe_touches_no_more_files_than_promised(name: str, tmp_path: Path) -> None:
    touched = carried_out(RECIPES[name], copied(tmp_path))
    sys.stdout.write(f"{name}: {len(touched)} files: {', '.join(sorted(touched))}\n")
    assert len(touched) <= MOST_FILES[name]


def test_a_figure_is_drawn_from_a_file_and_a_line(tmp_path: Path) -> None:
    copy = copied(tmp_path)
    touched = carried_out(FIGURE_RECIPE, copy)
    sys.stdout.write(f"figure: {len(touched)} files: {', '.join(sorted(touched))}\n")
    assert len(touched) <= MOST_FILES["figure"]
    done = output_of(DRAWN, copy)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == [1e-7, 2e-7]


def test_a_figure_without_its_line_is_unknown(tmp_path: Path) -> None:
    copy = copied(tmp_path)
    carried_out(FIGURE_RECIPE[:1], copy)
    done = output_of(DRAWN, copy)
    assert done.returncode != 0
    assert "errors" in done.stderr


CASES = ("plain", "eyring", "stiffer eyring", "liquid eyring", "sextic", "plateau")
METHODS = ("adaptive", "fixed")
"""Fixtures; either takes a minute to compile."""


@pytest.mark.stress
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("case", CASES)
def test_what_is_measured_is_what_is_integrated(
    request: pytest.FixtureRequest, method: str, case: str
) -> None:
    found = request.getfixturevalue(method)[case]
    assert found["status"] == 0
    assert found["power_balance_error"] < 1e-3


@pytest.mark.stress
@pytest.mark.parametrize("case", CASES)
def test_both_methods_compute_the_same_physics(
    adaptive: dict[str, dict[str, float]], fixed: dict[str, dict[str, float]], case: str
) -> None:
    for name in ("elastic_stress_amplitude", "friction_force_amplitude", "friction_work"):
        assert fixed[case][name] == pytest.approx(adaptive[case][name], rel=2e-3)


@pytest.mark.stress
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    ("case", "against"),
    [("eyring", "plain"), ("stiffer eyring", "eyring"), ("sextic", "plain"), ("plateau", "plain")],
)
def test_the_numbers_change(
    request: pytest.FixtureRequest, case: str, against: str, method: str
) -> None:
    results = request.getfixturevalue(method)
    found, before = results[case], results[against]
    amplitudes = ("elastic_stress_amplitude", "friction_force_amplitude")
    assert any(abs(found[name] / before[name] - 1.0) > 1e-3 for name in amplitudes)


@pytest.mark.stress
def test_a_parameter_at_its_neutral_value_changes_nothing(
    adaptive: dict[str, dict[str, float]],
) -> None:
    model = {"gamma": 0, "T": 250, "delta": 1.0, "omega": 30, "x_0": 0.8e-6, "phi_0": 0.6}
    config = {"model": model, "integrator": {"rtol": 1e-5}, "stationary": {"rtol": 1e-5}}
    today = sweeps.run(config, workers=1)
    # More parameters make other code: the last digits differ, and the steps that hang on them.
    error = float(today.amplitude_error)
    for name in ("elastic_stress_amplitude", "friction_force_amplitude"):
        assert adaptive["plain"][name] == pytest.approx(float(today[name]), rel=error)


@pytest.mark.stress
def test_a_liquid_film_passes_on_the_stress_of_the_new_law(
    adaptive: dict[str, dict[str, float]],
) -> None:
    """Stiff springs hold the block, so the film shears at the speed of the drive."""
    expected = 0.6e-9 * 2e5 * math.asinh(0.8e-6 * 30 / 1e-6)
    found = adaptive["liquid eyring"]["friction_force_amplitude"]
    assert found == pytest.approx(expected, rel=0.02)


LEFT_OUT: dict[str, tuple[str, Callable[[Edit], bool], str]] = {
    "the name of the law": ("friction law", lambda e: "options" in e.file, "friction must be one"),
    "the parameter of the law": (
        "friction law",
        lambda e: "eyring_speed" in e.text and "variables" in e.file,
        "eyring_speed",
    ),
    "the parameter of the energy": (
        "free energy",
        lambda e: "variables" in e.file,
        "sextic_coefficient",
    ),
    "the new parameter": ("parameter", lambda e: "variables" in e.file, "plateau_viscosity"),
    "the registry": ("result variable", lambda e: "variables" in e.file, "friction_work"),
    "the column": ("result variable", lambda e: "results" in e.file, "friction_work"),
}


@pytest.mark.slow
@pytest.mark.parametrize("step", one_then("stress", [*LEFT_OUT]))
def test_a_step_that_is_left_out_is_an_error_and_no_wrong_number(step: str, tmp_path: Path) -> None:
    name, left_out, message = LEFT_OUT[step]
    copy = copied(tmp_path)
    carried_out([edit for edit in RECIPES[name] if not left_out(edit)], copy)
    law = "eyring" if name == "friction law" else "power-law"
    code = (
        "import numpy as np\n"
        "from stickslip import Options, Parameters\n"
        "from stickslip.kernels.adaptive import conversion\n"
        "from stickslip.kernels.stability import fastest_rate\n"
        f"law = Options(friction={law!r}).friction\n"
        "points = np.array([Parameters()])\n"
        "print(fastest_rate(points, law))\n"
        "from stickslip.kernels.trajectories import observables_kernel\n"
        "observables_kernel(law)(points[0], np.zeros(1), np.ones((1, 3)), 0.0, np.zeros((1, 6)))\n"
        "from stickslip.kernels.adaptive.passes import new_queue\n"
        "queue = new_queue(np.zeros((1, 40)), np.zeros((1, 4)))\n"
        "orbits = conversion.Orbits(np.zeros((1, 4)), queue.measured.copy(), np.zeros(1, bool),\n"
        "    np.zeros((1, 2)), np.zeros(1))\n"
        "conversion.write_results(points, queue, orbits, 1e-6, np.zeros((1, 30)))\n"
    )
    done = output_of(code, copy, cache=copy / "cache")
    assert done.returncode != 0
    assert message in done.stderr
