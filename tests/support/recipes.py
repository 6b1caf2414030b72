"""The recipes of CONTRIBUTING.md as lists of edits, and what is run with them."""

from __future__ import annotations

from typing import NamedTuple


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
        parameter("octic_coefficient", "g", "J m-3", "default=0.0, neutral=0.0, phi_power=6"),
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
    "force on the block": [
        parameter("block_damping", "c_d", "N s m-1", "default=0.0, neutral=0.0"),
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

SEPTIC = parameter(
    "septic_coefficient", "s", "J m-3", "default=0.0, neutral=0.0, phi_power=5, phi_sign=-1"
)
"""With the octic one it allows three solids."""

PHASES_OF_FILMS = """
import json, sys
import stickslip
from stickslip import Parameters, phase_diagram
from stickslip.model import solids

found = []
for values in json.loads(sys.argv[1]):
    p = Parameters(**values)
    ds = phase_diagram(p, temperatures=[p.temperature], samples=201)
    found.append(
        {
            "turning points": solids.turning_points(p),
            "thresholds": solids.thresholds(p),
            "largest": solids.largest_order_parameter(p),
            "melting strain": solids.melting_strain(p),
            "melting strain of the page": float(ds.melting_strain[0]),
            "order parameter": ds.order_parameter.values.tolist(),
            "stable": ds.equilibrium_stability.values[0].tolist(),
            "ramp": ds.ramped_order_parameter.values[0].tolist(),
            "strain": ds.ramped_strain.values.tolist(),
        }
    )
json.dump(found, sys.stdout)
"""

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

SMALL_SWEEPS = """
import json, sys
from sweeps import run

MODEL = {"gamma": 0, "T": 250, "delta": 1.0, "omega": 30, "x_0": 0.8e-6, "phi_0": 0.6}
METHODS = {"adaptive": {"rtol": 1e-5}, "euler-cromer": {"method": "euler-cromer", "dt": 1e-7}}
EYRING = {"friction": "eyring"}
CASES = {
    "plain": ({}, {}),
    "eyring": ({"gamma": "-2/3"}, EYRING),
    "stiffer eyring": ({"gamma": "-2/3", "eyring_stress": 4e5}, EYRING),
    "liquid eyring": ({"gamma": "-2/3", "T": 310, "K": 1e4}, EYRING),
    "octic": ({"octic_coefficient": 400.0}, {}),
    "plateau": ({"plateau_viscosity": 5e4}, {}),
    "damped": ({"block_damping": 100.0}, {}),
}
CASES = {case: CASES[case] for case in sys.argv[2:] or CASES}
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
