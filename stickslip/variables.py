"""The registry of all named quantities: parameters, trajectories, results.

Each quantity is declared here once; its documentation, axis label, valid range and NetCDF
attributes follow. The symbols come from the paper (Lyashenko & Zaskoka 2013).
"""

from __future__ import annotations

import math
import re
import sys
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from functools import partial
from types import MappingProxyType
from typing import Annotated, Any, NamedTuple, TypedDict, TypeVar, get_origin, get_type_hints

from stickslip.regime import Regime
from stickslip.status import Status
from stickslip.symbols import LOWERED


@dataclass(frozen=True)
class Variable:
    """A named quantity: its symbol in ASCII and in mathtext, its unit (UDUNITS) and its meaning.

    `written` is the unit for readers, where it depends on another quantity, which UDUNITS cannot
    express. `name` is the declared name, `kind` the type of the values.
    """

    symbol: str
    tex: str
    units: str
    meaning: str
    comment: str = ""
    written: str = field(default="", kw_only=True)
    name: str = field(default="", kw_only=True)
    kind: type = field(default=float, kw_only=True)

    @property
    def unit(self) -> str:
        """The unit for readers; empty if dimensionless."""
        return self.written or ("" if self.units == "1" else self.units)

    @property
    def attributes(self) -> dict[str, str]:
        """The CF attributes: long_name, units, symbol, and comment if there is one."""
        named = {"long_name": self.meaning, "units": self.units, "symbol": self.symbol}
        return named | ({"comment": self.comment} if self.comment else {})


@dataclass(frozen=True)
class ParameterVariable(Variable):
    """A model parameter: its default (Fig. 3 of the paper) and the interval of its valid values.

    A parameter that is not `in_paper` enters the key of a point's random numbers only if it differs
    from its default. So points that do not use a new parameter keep their numbers.

    A coefficient of the free energy has a `phi_power`: in the force on ln(phi) it multiplies this
    power of the order parameter, with the sign `phi_sign`, +1 or -1. `model/film.py` derives its
    terms in the energy and the force, and the phases, from that. `directed` marks a parameter whose
    sign is a direction of motion and changes in the mirror image. Changes of a parameter are
    relative to its value or, unless `measured_in` is None, to the product of the parameters in it
    (1 if it is empty).
    """

    default: float = math.nan
    lower: float = -math.inf
    upper: float = math.inf
    lower_open: bool = False
    nonzero: bool = False
    in_paper: bool = True
    phi_power: int = 0
    phi_sign: int = 1
    directed: bool = False
    measured_in: tuple[str, ...] | None = None

    def complaint(self, value: float) -> str | None:
        """Return what is wrong with `value`, as the end of a sentence; None if it is valid."""
        if not math.isfinite(value):
            return f"must be a finite number, not {value!r}"
        if self.nonzero and value == 0:
            return "must not be 0"
        if self.lower_open and value <= self.lower:
            return f"must be greater than {self.lower:g}, not {value!r}"
        if value < self.lower:
            return f"must be at least {self.lower:g}, not {value!r}"
        if value > self.upper:
            return f"must be at most {self.upper:g}, not {value!r}"
        return None


@dataclass(frozen=True)
class ResultVariable(Variable):
    """An observable of a stationary orbit: a column of result rows and a variable of files.

    In a point with a result the value is finite and between `lower` and `upper`. It may be missing
    there unless the variable is `always` present.
    """

    lower: float = -sys.float_info.max
    upper: float = sys.float_info.max
    always: bool = True

    @property
    def dtype(self) -> str:
        """The data type in files."""
        return _IN_FILES[self.kind][0]

    @property
    def missing(self) -> float:
        """The value of points without a result."""
        return _IN_FILES[self.kind][1]


_IN_FILES: dict[type, tuple[str, float]] = {
    float: ("f8", math.nan), int: ("i4", -1), Regime: ("i1", 127), Status: ("i1", 127)
}  # fmt: skip

_positive = partial(ParameterVariable, lower=0.0, lower_open=True)
_not_negative = partial(ParameterVariable, lower=0.0)


_V = TypeVar("_V", bound=Variable)
_Value = TypeVar("_Value")


def _by_name(**variables: _V) -> Mapping[str, _V]:
    named = {name: replace(variable, name=name) for name, variable in variables.items()}
    return MappingProxyType(named)


def _declared(values: type) -> Mapping[str, Any]:
    """Return the variables in the annotations of a NamedTuple, by field."""
    hints = get_type_hints(values, include_extras=True)
    return MappingProxyType(
        {
            name: replace(hint.__metadata__[0], name=name, kind=hint.__origin__)
            for name, hint in hints.items()
            if get_origin(hint) is Annotated
        }
    )


# Formatted by hand, to keep each declaration on as few lines as it needs.
# fmt: off
class ParameterValues(NamedTuple):
    """The parameters: a tuple of floats, which compiled code takes as it is.

    It has no defaults, so that code that forgets a parameter does not compile.
    """

    temperature: Annotated[float, _not_negative("T", "T", "K", "lubricant temperature",
        default=200.0)]
    viscosity_coefficient: Annotated[float, _not_negative("k", "k", "Pa s", "viscosity coefficient",
        "numerically the effective viscosity at a strain rate of 1 s-1; "
        "its dimension is Pa s^(gamma+1), Eq. 7",
        default=5e4, written="Pa s^(gamma+1)")]
    spring_stiffness: Annotated[float, _not_negative("K", "K", "N m-1",
        "stiffness of each of the two springs", default=3000.0)]
    rheological_index: Annotated[float, ParameterVariable("gamma", r"\gamma", "1",
        "rheological index", "pseudoplastic below 0, Newtonian at 0, dilatant above 0", lower=-1.0,
        lower_open=True, default=-2 / 3, measured_in=())]
    angular_frequency: Annotated[float, _positive("omega", r"\omega", "rad s-1",
        "angular frequency of the drive", default=10.0)]
    drive_amplitude: Annotated[float, ParameterVariable("X_m", "X_m", "m",
        "displacement amplitude of the drive", nonzero=True, default=0.8e-6, directed=True)]
    block_mass: Annotated[float, _positive("M", "M", "kg", "mass of the lower block", default=0.4)]
    initial_displacement: Annotated[float, ParameterVariable("x_0", "x_0", "m",
        "initial displacement of the lower block", default=0.0, directed=True,
        measured_in=("drive_amplitude",))]
    initial_velocity: Annotated[float, ParameterVariable("v_0", "v_0", "m s-1",
        "initial velocity of the lower block", default=0.0, directed=True,
        measured_in=("drive_amplitude", "angular_frequency"))]
    initial_order_parameter: Annotated[float, ParameterVariable("phi_0", r"\varphi_0", "1",
        "initial order parameter", lower=0.0, upper=2.0, default=0.0, measured_in=())]
    film_thickness: Annotated[float, _positive("h", "h", "m", "thickness of the lubricant film",
        default=1e-9)]
    strain_relaxation_time: Annotated[float, _positive("tau", r"\tau_\varepsilon", "s",
        "strain relaxation time", default=1e-8)]
    contact_area: Annotated[float, _positive("A", "A", "m2", "contact area of the blocks",
        default=0.6e-9)]
    kinetic_coefficient: Annotated[float, _positive("delta", r"\delta", "m3 J-1 s-1",
        "kinetic coefficient", default=100.0)]
    thermal_coefficient: Annotated[float, _not_negative("alpha", r"\alpha", "J K-1 m-3",
        "thermal coefficient of the free energy", default=0.95)]
    critical_temperature: Annotated[float, _not_negative("T_c", "T_c", "K", "critical temperature",
        default=290.0)]
    elastic_coefficient: Annotated[float, _not_negative("a", "a", "Pa",
        "elastic coefficient of the free energy", default=4e12)]
    cubic_coefficient: Annotated[float, _not_negative("b", "b", "J m-3",
        "cubic coefficient of the free energy", default=230.0, phi_power=1, phi_sign=-1)]
    quartic_coefficient: Annotated[float, _not_negative("c", "c", "J m-3",
        "quartic coefficient of the free energy", default=850.0, phi_power=2)]
    noise_intensity: Annotated[float, _not_negative("D", "D", "s-1", "noise intensity",
        "dphi = -delta f'(phi) dt + sqrt(2 D) dW, reflected at phi = 0", default=1e-18)]
    quintic_coefficient: Annotated[float, _not_negative("d", "d", "J m-3",
        "quintic coefficient of the free energy", "needs a sextic coefficient e > 0", default=0.0,
        in_paper=False, phi_power=3, phi_sign=-1, measured_in=("quartic_coefficient",))]
    sextic_coefficient: Annotated[float, _not_negative("e", "e", "J m-3",
        "sextic coefficient of the free energy",
        "together with d, lets a soft solid exist beside a hard one", default=0.0, in_paper=False,
        phi_power=4, measured_in=("quartic_coefficient",))]
    third_harmonic: Annotated[float, ParameterVariable("a_3", "a_3", "1",
        "amplitude of the drive's third harmonic, relative to X_m",
        "X = X_m (cos(omega t) + a_3 cos(3 omega t) + a_5 cos(5 omega t))", default=0.0,
        in_paper=False, measured_in=())]
    fifth_harmonic: Annotated[float, ParameterVariable("a_5", "a_5", "1",
        "amplitude of the drive's fifth harmonic, relative to X_m", default=0.0, in_paper=False,
        measured_in=())]


PARAMETERS: Mapping[str, ParameterVariable] = _declared(ParameterValues)

ParameterKeywords = TypedDict("ParameterKeywords", {  # noqa: UP013 - a line for each is longer
    "temperature": float, "T": float, "viscosity_coefficient": float, "k": float,
    "spring_stiffness": float, "K": float, "rheological_index": float, "gamma": float, "γ": float,
    "angular_frequency": float, "omega": float, "ω": float, "drive_amplitude": float, "X_m": float,
    "block_mass": float, "M": float, "initial_displacement": float, "x_0": float,
    "initial_velocity": float, "v_0": float, "initial_order_parameter": float, "phi_0": float,
    "φ_0": float, "film_thickness": float, "h": float, "strain_relaxation_time": float,
    "tau": float, "τ": float, "contact_area": float, "A": float, "kinetic_coefficient": float,
    "delta": float, "δ": float, "thermal_coefficient": float, "alpha": float, "α": float,
    "critical_temperature": float, "T_c": float, "elastic_coefficient": float, "a": float,
    "cubic_coefficient": float, "b": float, "quartic_coefficient": float, "c": float,
    "noise_intensity": float, "D": float, "quintic_coefficient": float, "d": float,
    "sextic_coefficient": float, "e": float, "third_harmonic": float, "a_3": float,
    "fifth_harmonic": float, "a_5": float,
}, total=False)
"""The names and symbols of the parameters, for type checkers and editors."""

_ORDER_PARAMETER = Variable("phi", r"\varphi", "1", "order parameter of the film")
_ELASTIC_STRAIN = Variable(
    "epsilon_el", r"\varepsilon_\mathrm{el}", "1", "elastic shear strain")

TRAJECTORY: Mapping[str, Variable] = _by_name(
    elapsed_time=Variable("t", "t", "s", "time since the start"),
    upper_displacement=Variable("X", "X", "m", "displacement of the upper block"),
    lower_displacement=Variable("x", "x", "m", "displacement of the lower block"),
    upper_velocity=Variable("V", "V", "m s-1", "velocity of the upper block"),
    lower_velocity=Variable("v", "v", "m s-1", "velocity of the lower block"),
    order_parameter=_ORDER_PARAMETER,
    elastic_strain=_ELASTIC_STRAIN,
    elastic_stress=Variable("sigma_el", r"\sigma_\mathrm{el}", "Pa", "elastic shear stress"),
    viscous_stress=Variable("sigma_v", r"\sigma_v", "Pa", "viscous shear stress"),
    friction_force=Variable("F", "F", "N", "friction force between the blocks"),
)

PULLED: Mapping[str, Variable] = _by_name(
    spring_force=Variable("2Kx", "2Kx", "N", "force of the springs of the lower block"),
    melting_time=Variable("t_m", r"t_\mathrm{m}", "s", "time at which the film melts"),
    slip_period=Variable("t_s", r"t_\mathrm{s}", "s", "time since the previous melting"),
    spring_force_max=Variable("max 2Kx", r"\max 2Kx", "N",
        "largest spring force of a cycle, from one melting to the next"),
    spring_force_min=Variable("min 2Kx", r"\min 2Kx", "N", "smallest spring force of a cycle"),
    slip_force_max=Variable("max F", r"\max F", "N", "largest friction force of a cycle"),
    slip_force_min=Variable("min F", r"\min F", "N", "smallest friction force of a cycle"),
    slip_force_mean=Variable("mean F", r"\overline{F}", "N", "mean friction force of a cycle"),
)
"""Further variables of a trajectory under a pull: the spring force, and the slip cycles."""

STROBOSCOPIC: Mapping[str, Variable] = _by_name(
    period=Variable("n", "n", "1", "drive periods since the start"),
    stroboscopic_displacement=Variable("x_n", "x_n", "m",
        "displacement of the lower block at the beginning of a drive period"),
    stroboscopic_velocity=Variable("v_n", "v_n", "m s-1",
        "velocity of the lower block at the beginning of a drive period"),
)

PHASES: Mapping[str, Variable] = _by_name(
    order_parameter=_ORDER_PARAMETER,
    elastic_strain=_ELASTIC_STRAIN,
    free_energy=Variable("f", "f", "J m-3", "density of the free energy"),
    melting_temperature=Variable("T_c0", r"T_{c0}", "K",
        "temperature above which a solid film melts"),
    solidification_temperature=Variable("T_c^0", r"T_c^0", "K",
        "temperature below which a liquid film solidifies"),
    melting_strain=Variable("epsilon_c0", r"\varepsilon_{c0}", "1",
        "strain above which a solid film melts", "0 if it is liquid at every strain"),
    solidification_strain=Variable("epsilon_c^0", r"\varepsilon_c^0", "1",
        "strain below which a liquid film solidifies", "0 if it solidifies at no strain"),
    equilibrium_strain=Variable("epsilon_el", r"\varepsilon_\mathrm{el}", "1",
        "strain at which a film with this order parameter is stationary"),
    equilibrium_stability=Variable("stable", r"\mathrm{stable}", "1",
        "1 if a film that is stationary at this order parameter is stable there, else 0"),
    ramped_strain=Variable("epsilon_el", r"\varepsilon_\mathrm{el}", "1",
        "elastic strain that slowly rises from 0 and falls again"),
    ramp_direction=Variable("ramp", r"\mathrm{ramp}", "1",
        "whether the strain rises or falls"),
    ramped_order_parameter=Variable("phi", r"\varphi", "1",
        "order parameter of a film that follows this strain"),
)

OBSERVABLES = ("harmonics", "moments")
"""The values of the option `observables`, which has no effect: all variables are computed."""

_ORBIT = "over the stationary orbit"
_HALF = (
    f"half the difference of maximum and minimum {_ORBIT}; for aperiodic orbits and stochastic "
    "films, the mean over single periods"
)
_SPREAD = (
    "over the orbit, the window of an aperiodic orbit, or all periods of all realizations; 0 if "
    "the orbit closes after one period"
)
_ALL = "for a stochastic film, over all periods of all realizations"
_TYPICAL = "for a stochastic film, that of its typical path"
_FIRST = "F = F' X/|X_m| + F'' (dX/dt)/(|X_m| omega) at the frequency of the drive"
_MACHINE = "|X_m| describes the whole machine, with springs and block; it is not a film modulus"
_PERIODS = "for aperiodic orbits and stochastic films, over all measured periods"
_WINDOW = (
    f"{_PERIODS}, with a standard error of at most about amplitude_error/3 times friction_force_rms"
)
_STATED = "for aperiodic orbits and stochastic films, three standard errors of the mean"

class OrbitValues(NamedTuple):
    """The values of an orbit: a result row and a state."""

    elastic_stress_amplitude: Annotated[float, ResultVariable("sigma_el,max",
        r"\sigma_\mathrm{el,max}", "Pa", "amplitude of the elastic stress", _HALF, lower=0.0)]
    friction_force_amplitude: Annotated[float, ResultVariable("F_max", r"F_\mathrm{max}", "N",
        "amplitude of the friction force", _HALF, lower=0.0)]
    elastic_stress_max: Annotated[float, ResultVariable("max sigma_el", r"\max\sigma_\mathrm{el}",
        "Pa", f"maximum of the elastic stress {_ORBIT}", _ALL)]
    elastic_stress_min: Annotated[float, ResultVariable("min sigma_el", r"\min\sigma_\mathrm{el}",
        "Pa", f"minimum of the elastic stress {_ORBIT}", _ALL)]
    friction_force_max: Annotated[float, ResultVariable("max F", r"\max F", "N",
        f"maximum of the friction force {_ORBIT}", _ALL)]
    friction_force_min: Annotated[float, ResultVariable("min F", r"\min F", "N",
        f"minimum of the friction force {_ORBIT}", _ALL)]
    dissipated_energy: Annotated[float, ResultVariable("W", "W", "J",
        "work of the drive per drive period, over the stationary orbit",
        "the integral of F V; as the orbit closes, it is measured as that of F (V - v), which film "
        "and block dissipate in a period; for aperiodic orbits and stochastic films, the mean "
        "over the measured periods")]
    dissipated_energy_error: Annotated[float, ResultVariable("error of W", r"\mathrm{error\ of}\ W",
        "J", "estimated error of the dissipated energy", _STATED, lower=0.0)]
    amplitude_error: Annotated[float, ResultVariable("error", r"\mathrm{error}", "1",
        "estimated relative error of the worse of the two amplitudes",
        "relative to max(amplitude, 1 % of max(2K, M omega^2)|X_m|, summed over the harmonics), "
        "divided by A for the stress; "
        "for aperiodic orbits and stochastic films, three standard errors of the mean plus the "
        "error of the typical path",
        lower=0.0, upper=100.0)]
    power_balance_error: Annotated[float, ResultVariable("power balance",
        r"\mathrm{power\ balance}", "1", f"relative violation of the power balance {_ORBIT}",
        "|work of the drive - dissipation - energy gained| / integral of |F V|", lower=0.0)]
    orbit_periods: Annotated[int, ResultVariable("n", "n", "1",
        "drive periods after which the stationary orbit closes",
        "0 if it is aperiodic, or the film stochastic", lower=0.0)]
    melting_count: Annotated[int, ResultVariable("meltings", r"n_\mathrm{melt}", "1",
        f"number of solid-to-liquid transitions {_ORBIT}",
        f"solid from a threshold of phi, the paper's b/(2c), and melted at a tenth of it; {_ALL}",
        lower=0.0)]
    solid_transition_count: Annotated[int, ResultVariable("solid transitions", r"n_\mathrm{solid}",
        "1", f"number of changes between a soft and a hard solid {_ORBIT}",
        "sixth-order free energy only; changes through the liquid do not count", lower=0.0)]
    asymmetry: Annotated[float, ResultVariable("asymmetry", r"\mathrm{asymmetry}", "1",
        "asymmetry of the elastic stress: |max + min| / (max - min)", "0 if max - min < 1 Pa",
        lower=0.0)]
    periods_integrated: Annotated[int, ResultVariable("periods", r"n_\mathrm{periods}", "1",
        "drive periods integrated for this point",
        "including confirmation and measurement, but not the error estimate's run", lower=0.0)]
    solid_fraction: Annotated[float, ResultVariable("solid fraction", r"\mathrm{solid\ fraction}",
        "1", f"fraction of the time in which the film is solid, {_ORBIT}",
        "with the thresholds of the melting count", lower=0.0, upper=1.0)]
    regime: Annotated[Regime, ResultVariable("regime", r"\mathrm{regime}", "1",
        "kind of motion of the orbit", _TYPICAL, lower=0.0, upper=5.0)]
    floquet_multiplier: Annotated[float, ResultVariable("multiplier", r"|\mu|", "1",
        "modulus of the largest Floquet multiplier of the orbit",
        "from the variational equations of (x, v, ln phi) over the orbit, in steps that resolve "
        f"free oscillations of the block, or missing if that needs too many steps; {_TYPICAL}",
        lower=0.0, always=False)]
    lyapunov_exponent: Annotated[float, ResultVariable("Lyapunov exponent", r"\lambda", "1",
        "largest Lyapunov exponent of an aperiodic orbit, per drive period", always=False)]
    elastic_stress_amplitude_spread: Annotated[float, ResultVariable("spread of sigma_el,max",
        r"\mathrm{sd}\,\sigma_\mathrm{el,max}", "Pa",
        "standard deviation of the elastic stress amplitudes of single drive periods", _SPREAD,
        lower=0.0)]
    friction_force_amplitude_spread: Annotated[float, ResultVariable("spread of F_max",
        r"\mathrm{sd}\,F_\mathrm{max}", "N",
        "standard deviation of the friction force amplitudes of single drive periods", _SPREAD,
        lower=0.0)]
    friction_force_in_phase: Annotated[float, ResultVariable("F'", "F'", "N",
        "first harmonic of the friction force, in phase with the drive",
        f"{_FIRST}, {_PERIODS}; F'/{_MACHINE}")]
    friction_force_in_phase_error: Annotated[float, ResultVariable("error of F'",
        r"\mathrm{error\ of}\ F'", "N",
        "estimated error of the first harmonic in phase with the drive", _STATED, lower=0.0)]
    friction_force_out_of_phase: Annotated[float, ResultVariable("F''", "F''", "N",
        "first harmonic of the friction force, in phase with the velocity of the drive",
        f"{_FIRST}, {_PERIODS}; F''/{_MACHINE}")]
    friction_force_out_of_phase_error: Annotated[float, ResultVariable("error of F''",
        r"\mathrm{error\ of}\ F''", "N",
        "estimated error of the first harmonic in phase with the velocity of the drive", _STATED,
        lower=0.0)]
    friction_force_rms: Annotated[float, ResultVariable("F_rms", r"F_\mathrm{rms}", "N",
        f"root mean square of the friction force {_ORBIT}", _WINDOW, lower=0.0)]
    friction_force_mean_abs: Annotated[float, ResultVariable("mean |F|", r"\mathrm{mean}\,|F|", "N",
        f"mean absolute value of the friction force {_ORBIT}", _WINDOW, lower=0.0)]
    status: Annotated[Status, ResultVariable("status", r"\mathrm{status}", "1",
        "how the computation of the point ended", lower=0.0, upper=127.0)]
    state: tuple[float, ...]


RESULTS: Mapping[str, ResultVariable] = _declared(OrbitValues)

# fmt: on

ENERGY_COEFFICIENTS: tuple[str, ...] = tuple(
    v.name for v in sorted(PARAMETERS.values(), key=lambda v: v.phi_power) if v.phi_power > 1
)
"""The coefficients that decide whether the order parameter is bounded, lowest power first."""


def unbounded(*coefficients: float) -> str | None:
    """Return why the order parameter can grow without bound at these coefficients, or None.

    They are in the order of `ENERGY_COEFFICIENTS`. The term of the highest nonzero one must be
    positive.
    """
    named = zip(ENERGY_COEFFICIENTS, coefficients, strict=True)
    *_, (name, value) = (ENERGY_COEFFICIENTS[0], 0.0), *((n, v) for n, v in named if v != 0)
    if value * PARAMETERS[name].phi_sign > 0:
        return None
    higher = ENERGY_COEFFICIENTS[ENERGY_COEFFICIENTS.index(name) + 1 :]
    needed = [f"{n} ({PARAMETERS[n].symbol})" for n in higher if PARAMETERS[n].phi_sign > 0]
    condition = f"{name} ({PARAMETERS[name].symbol}) {'>' if value else '='} 0"
    return f"{condition} needs a {' or '.join(needed) or 'higher coefficient'} > 0"


RESULT_COLUMNS: tuple[str, ...] = tuple(RESULTS)
"""The columns of a result row, in the order of the registry."""

STARTING = ("initial_displacement", "initial_velocity", "initial_order_parameter")
"""The parameters that only set how a motion begins."""

BY_SYMBOL: Mapping[str, str] = MappingProxyType(
    {variable.symbol: name for name, variable in PARAMETERS.items()}
)

_RESULT_BY_SYMBOL = {variable.symbol: name for name, variable in RESULTS.items()}

GREEK = {
    letter: unicodedata.lookup(f"GREEK SMALL LETTER {letter}")
    for letter in ("alpha", "gamma", "delta", "sigma", "tau", "phi", "omega")
}
"""Greek letters, by their names in symbols."""

# Symbols may also be spelled as figures and pages print them. U+03D5 is another phi.
_LETTERS = str.maketrans(
    {greek: name for name, greek in GREEK.items()}
    | {"\u03d5": "phi"}
    | {lowered: letter for letter, lowered in LOWERED.items()}
)
_INDEX = re.compile(r"[{0}]+(?:,[{0}]+)*".format("".join(LOWERED.values())))


def _spelled_out(symbol: str) -> str:
    """Return a symbol in the spelling of the registry: `sigma_el,max` for `σₑₗ,ₘₐₓ`."""
    return _INDEX.sub(lambda index: f"_{index[0]}", symbol).translate(_LETTERS)


def canonical_name(name: str) -> str | None:
    """Return the full name of a parameter from its name or the paper's symbol; None if unknown.

    Symbols may have Greek letters and subscripts: `gamma`, `γ`; `phi_0`, `φ_0`, `φ₀`.
    """
    return name if name in PARAMETERS else BY_SYMBOL.get(_spelled_out(name))


def canonical_result(name: str) -> str | None:
    """Return the full name of a result variable from its name or symbol; None if unknown."""
    return name if name in RESULTS else _RESULT_BY_SYMBOL.get(_spelled_out(name))


def full_name(name: str) -> str:
    """Return the full name of a parameter from its name or symbol.

    Raises TypeError for any other name, and suggests a similar one.
    """
    known = canonical_name(name)
    if known is None:
        near = get_close_matches(name, [*PARAMETERS, *BY_SYMBOL], n=1)
        hint = f"; did you mean {near[0]!r}?" if near else ""
        raise TypeError(f"there is no parameter {name!r}{hint}")
    return known


def full_names(given: Mapping[Any, _Value]) -> dict[str, _Value]:
    """Return values by the full names of parameters, from a mapping by names or symbols.

    Raises TypeError for a name that is not a parameter, and for a parameter that is given twice.
    """
    values: dict[str, _Value] = {}
    for key, value in given.items():
        name = full_name(str(key))
        if name in values:
            raise TypeError(f"{name} is given twice, by name and by symbol")
        values[name] = value
    return values
