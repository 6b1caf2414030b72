"""The recipes of CONTRIBUTING.md as lists of edits, and what is run with them."""

from __future__ import annotations

from pathlib import Path
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
def _stress(p: Parameters, u: float, phi: float) -> float:
    x = abs(u) / p.eyring_speed
    size = p.eyring_stress * math.log(x + math.sqrt(x * x + 1.0))
    return math.copysign(size, u)


@inline
def _slope(p: Parameters, u: float) -> float:
    x = u / p.eyring_speed
    return p.eyring_stress / p.eyring_speed / math.sqrt(x * x + 1.0)


@inline
def _rounded(
    p: Parameters, u: float, phi: float, u_s: float
) -> tuple[float, float, float]:
    return _stress(p, u, phi), _slope(p, u), 0.0


@inline
def _never(p: Parameters) -> bool:
    return False


@inline
def _stable_slope(p: Parameters, u: float, phi: float) -> float:
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

OF_THE_SOLID = '''"""The paper's law, the viscosity growing with the order by 1 + kappa phi^2."""

from __future__ import annotations

from stickslip.compiled.decorators import inline
from stickslip.model.laws import FrictionLaw, power_law
from stickslip.parameters import Parameters


_paper_slope = power_law.LAW.stable_slope


@inline
def _growth(p: Parameters, phi: float) -> float:
    return 1.0 + p.viscosity_growth * (phi * phi)


@inline
def _stress(p: Parameters, u: float, phi: float) -> float:
    return _growth(p, phi) * power_law.viscous_stress(p, u, phi)


@inline
def _rounded(
    p: Parameters, u: float, phi: float, u_s: float
) -> tuple[float, float, float]:
    stress, slope, _ = power_law.rounded_viscous_stress(p, u, phi, u_s)
    growth = _growth(p, phi)
    return growth * stress, growth * slope, 2.0 * (growth - 1.0) * stress


@inline
def _stable_slope(p: Parameters, u: float, phi: float) -> float:
    return _growth(p, phi) * _paper_slope(p, u, phi)


LAW = FrictionLaw(
    name="of-the-solid",
    stress=_stress,
    rounded=_rounded,
    has_cusp=power_law.LAW.has_cusp,
    stable_slope=_stable_slope,
    scaled=power_law.LAW.scaled,
    parameters=(*power_law.LAW.parameters, "viscosity_growth"),
    special_indices=power_law.LAW.special_indices,
)
'''

SPRUNG_BLOCK = (Path(__file__).parent / "sprung_block.py").read_text()

LAST_PARAMETER = '    _not_negative("noise_intensity",'


def parameter(name: str, symbol: str, unit: str, more: str) -> Edit:
    """A parameter in the registry."""
    text = f'    _not_negative("{name}", "{symbol}", "{symbol}", "{unit}", "{name}", {more}),\n'
    return Edit("stickslip/variables.py", LAST_PARAMETER, text)


RUNGE_KUTTA = (Path(__file__).parent / "runge_kutta.py").read_text()
"""Classical Runge-Kutta, order 4: a whole method."""

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
    "law of the order parameter": [
        Edit("stickslip/model/laws/of_the_solid.py", "", OF_THE_SOLID),
        Edit(
            "stickslip/options.py",
            '        "power-law": "stickslip.model.laws.power_law",\n',
            '        "of-the-solid": "stickslip.model.laws.of_the_solid",\n',
        ),
        parameter("viscosity_growth", "kappa", "1", "default=0.0, neutral=0.0"),
    ],
    "state variables": [
        Edit("stickslip/model/sprung.py", "", SPRUNG_BLOCK),
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
            '        RELAXING: "it is a variable',
            '        "sprung": "the upper block on a spring of its own",\n',
        ),
        parameter("upper_mass", "M_2", "kg", "default=0.4, neutral=0.4"),
        parameter("upper_stiffness", "K_2", "N m-1", "default=1e9, neutral=1e9"),
    ],
    "integral": [
        Edit(
            "stickslip/variables.py",
            STATUS_COLUMN,
            '    ResultVariable("dissipated_work", "W_d", "W_d", "J", "work lost in the film"),\n',
        ),
        Edit(
            "stickslip/measure/results.py",
            "        status=float(m.status),\n",
            "        dissipated_work=m.record[DISSIPATED_WORK],\n",
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
    "drive tone": [
        Edit(
            "stickslip/variables.py",
            LAST_PARAMETER,
            '    ParameterVariable("third_amplitude", "X_3", "X_3", "m", "third_amplitude",\n'
            "        default=0.0, neutral=0.0, directed=True),\n",
        ),
        Edit(
            "stickslip/model/drive.py",
            "TONES: tuple[Tone, ...] = (",
            "@inline\n"
            "def _third_amplitude(p: Parameters) -> float:\n"
            "    return p.third_amplitude\n\n\n",
        ),
        Edit("stickslip/model/drive.py", "    tone(1, ", "    tone(3, _third_amplitude),\n"),
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
    "method": [
        Edit("stickslip/kernels/rk4/__init__.py", "", RUNGE_KUTTA),
        Edit("stickslip/options.py", '        "euler-cromer": Method(', RK4),
    ],
}
"""The recipes of what is integrated and measured; the figure and the executor come below."""

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

EXECUTOR = '''"""One block after the other, in the process that asks for them."""

from __future__ import annotations

from concurrent.futures import Future

from sweeps.config.schema import Execution
from sweeps.engine.executors.base import Executor
from sweeps.engine.executors.worker import Block, Task, compute_block


class SerialExecutor(Executor):
    """Computes a task while it is handed over."""

    def __exit__(self, *exception: object) -> None:
        pass

    def most_in_flight(self) -> int:
        """One task: the next would be computed before this one is taken."""
        return 1

    def submit(self, task: Task) -> Future[Block]:
        """Compute a task."""
        future: Future[Block] = Future()
        future.set_result(compute_block(task))
        return future


def executor_for(execution: Execution) -> Executor:  # noqa: ARG001 - as of any executor
    """One slot, however many workers the config has."""
    return SerialExecutor(slots=1)
'''

EXECUTOR_RECIPE = [
    Edit("sweeps/engine/executors/serial.py", "", EXECUTOR),
    Edit(
        "sweeps/executor_table.py",
        '        "dask": ExecutorEntry(',
        '        "serial": ExecutorEntry("blocks one after the other", "serial"),\n',
    ),
]
# In memory and into a file; `threads` are those that computed a block of the two.
SERIAL_SWEEPS = """
import json, sys, threading
from sweeps import run
from sweeps.cli.sweeps import BackendOption
from sweeps.engine.executors import serial
from sweeps.files.datasets import content_hash

threads, compute_block = [], serial.compute_block

def watched(task):
    threads.append(threading.current_thread().name)
    return compute_block(task)

serial.compute_block = watched
config = {
    "sweep": {"temperature": [240, 250, 260]},
    "integrator": {"rtol": 1e-4},
    "stationary": {"rtol": 1e-4},
    "execution": {"block_points": 1},
}
asked = config | {"execution": {"block_points": 1, "backend": "serial"}}
found = {
    "by threads": content_hash(run(config)),
    "in memory": content_hash(run(asked)),
    "into a file": content_hash(run(config, output="a.nc", backend="serial")),
    "threads": threads,
    "help": BackendOption.__metadata__[0].metavar,
}
json.dump(found, sys.stdout)
"""

SPRUNG_SWEEPS = """
import json, sys
from sweeps import run

CASES = {
    "locked": {"gamma": 0, "T": 200, "K": 500, "omega": 30, "x_0": 0.8e-6, "phi_0": 0.6},
    "liquid": {"gamma": 0, "T": 310, "K": 1e4, "omega": 30, "x_0": 0.8e-6},
}
found = {}
for case, model in CASES.items():
    sprung = [({"strain": "sprung"}, {"upper_stiffness": K_2}) for K_2 in (1e7, 1e8, 1e9)]
    found[case] = []
    for film, more in [({}, {}), *sprung]:
        ds = run(
            {
                "model": model | more,
                "film": film,
                "integrator": {"rtol": 1e-8},
                "stationary": {"rtol": 1e-8},
            },
            workers=1,
        )
        found[case].append({name: float(ds[name]) for name in ds.data_vars})
json.dump(found, sys.stdout)
"""

REFUSED = """
from sweeps import run
run({"film": {"strain": "sprung"}, "integrator": {"method": "euler-cromer"}})
"""

SPRUNG_SWEEPS = """
import json, sys
from sweeps import run

CASES = {
    "locked": {"gamma": 0, "T": 200, "K": 500, "omega": 30, "x_0": 0.8e-6, "phi_0": 0.6},
    "liquid": {"gamma": 0, "T": 310, "K": 1e4, "omega": 30, "x_0": 0.8e-6},
}
found = {}
for case, model in CASES.items():
    sprung = [({"strain": "sprung"}, {"upper_stiffness": K_2}) for K_2 in (1e7, 1e8, 1e9)]
    found[case] = []
    for film, more in [({}, {}), *sprung]:
        ds = run(
            {
                "model": model | more,
                "film": film,
                "integrator": {"rtol": 1e-8},
                "stationary": {"rtol": 1e-8},
            },
            workers=1,
        )
        found[case].append({name: float(ds[name]) for name in ds.data_vars})
json.dump(found, sys.stdout)
"""

REFUSED = """
from sweeps import run
run({"film": {"strain": "sprung"}, "integrator": {"method": "euler-cromer"}})
"""

SMALL_SWEEPS = """
import json, sys
from sweeps import run

MODEL = {"gamma": 0, "T": 250, "delta": 1.0, "omega": 30, "x_0": 0.8e-6, "phi_0": 0.6}
METHODS = {
    "adaptive": {"rtol": 1e-5},
    "euler-cromer": {"method": "euler-cromer", "dt": 1e-7},
    "rk4": {"method": "rk4", "dt": 2e-6},
}
EYRING = {"friction": "eyring"}
CASES = {
    "plain": ({}, {}),
    "eyring": ({"gamma": "-2/3"}, EYRING),
    "stiffer eyring": ({"gamma": "-2/3", "eyring_stress": 4e5}, EYRING),
    "liquid eyring": ({"gamma": "-2/3", "T": 310, "K": 1e4}, EYRING),
    "octic": ({"octic_coefficient": 400.0}, {}),
    "plateau": ({"plateau_viscosity": 5e4}, {}),
    "damped": ({"block_damping": 100.0}, {}),
    "two tones": ({"third_amplitude": 0.2e-6}, {}),
    "two tones of a mirrored drive": (
        {"third_amplitude": -0.2e-6, "X_m": -0.8e-6, "x_0": -0.8e-6}, {}
    ),
    "thickened": ({"viscosity_growth": 3.0}, {"friction": "of-the-solid"}),
    "not thickened": ({}, {"friction": "of-the-solid"}),
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

LIQUID = """
import json, sys
from stickslip import Parameters, simulate

NEWTONIAN = Parameters(
    temperature=310.0,
    rheological_index=0.0,
    viscosity_coefficient=1e3,
    kinetic_coefficient=1e-2,
    angular_frequency=30.0,
    initial_order_parameter=0.05,
)

def motion(**options):
    return simulate(NEWTONIAN, periods=1, samples_per_period=16, **options)

exact, names = motion(rtol=1e-12), ("lower_velocity", "order_parameter", "friction_force")
errors = {name: [] for name in names}
for dt in (2e-4, 1e-4, 5e-5):
    found = motion(method="rk4", dt=dt)
    for name in names:
        miss = abs(found[name] - exact[name]).max() / abs(exact[name]).max()
        errors[name].append(float(miss))
json.dump(errors, sys.stdout)
"""
"""Errors of a smooth motion by the new method, each step half of the one before."""
