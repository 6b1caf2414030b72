"""Options of a computation: methods, noise treatments, friction laws, tolerances and budgets.

Each name, default and range is declared here once. The module imports fast: it compiles nothing.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields
from importlib import import_module
from numbers import Real
from types import MappingProxyType
from typing import Any, NamedTuple

from stickslip.laws import LawError, UnknownLawError, origin_of
from stickslip.variables import OBSERVABLES

ADIABATIC, RELAXING = "adiabatic", "relaxing"

TYPICAL_PATH, NO_NOISE, STOCHASTIC = "typical-path", "none", "stochastic"

STRAINS: Mapping[str, str] = MappingProxyType(
    {
        ADIABATIC: "it follows the relative velocity instantly (Eq. 24)",
        RELAXING: "it is an independent variable (Eq. 23; adaptive method)",
    }
)
"""The models of the elastic strain of the film."""


OFFERED = (
    "family_kernels", "orbits", "trajectory_kernel", "largest_step", "rounding",
)  # fmt: skip
"""The functions that the module of a method provides, described in `kernels/adaptive/driver.py`.
A method with stochastic noise also provides `stochastic_walk`."""


@dataclass(frozen=True)
class Method:
    """A method that a user can choose.

    `module` implements it and provides everything in OFFERED. `own_option` sets its accuracy: the
    tolerance "rtol" or a fixed step "dt". `max_steps` is the default budget of steps per point.
    `refines` says whether finer tolerances make it more accurate. `strains` and `noises` list the
    models of the strain and the treatments of the noise that it supports.
    """

    meaning: str
    module: str
    own_option: str
    max_steps: int
    accelerates: bool
    refines: bool
    strains: tuple[str, ...]
    noises: tuple[str, ...]

    @property
    def kernels(self) -> Any:
        """The module of the method, imported on first use.

        Raises TypeError, with the names of the missing functions.
        """
        module = import_module(self.module)
        required = (*OFFERED, "stochastic_walk") if STOCHASTIC in self.noises else OFFERED
        missing = [name for name in required if not callable(getattr(module, name, None))]
        if missing:
            raise TypeError(f"the method {self.module} lacks the function {', '.join(missing)}")
        return module


METHODS: Mapping[str, Method] = MappingProxyType(
    {
        "adaptive": Method(
            meaning="stiff, order 4, with error control",
            module="stickslip.kernels.adaptive.driver",
            own_option="rtol",
            max_steps=20_000_000,  # a point of the paper's figures takes 1e4 to 1e6
            accelerates=True,
            refines=True,
            strains=tuple(STRAINS),
            noises=(TYPICAL_PATH, NO_NOISE, STOCHASTIC),
        ),
        "euler-cromer": Method(
            meaning="the paper's explicit scheme with a fixed step, order 1",
            module="stickslip.kernels.euler_cromer.driver",
            own_option="dt",
            max_steps=10**15,  # known in advance: 1e10 per period at the paper's step
            accelerates=False,
            refines=False,
            strains=(ADIABATIC,),
            noises=(TYPICAL_PATH, NO_NOISE, STOCHASTIC),
        ),
    }
)


def methods_for(field: str, choice: str) -> list[str]:
    """Return the names of the methods whose `field`, "strains" or "noises", has this choice."""
    return [name for name, method in METHODS.items() if choice in getattr(method, field)]


NOISE_TREATMENTS: Mapping[str, str] = MappingProxyType(
    {
        TYPICAL_PATH: "the geometric mean of the fluctuating order parameter, not random",
        NO_NOISE: "the deterministic equation",
        STOCHASTIC: "random realizations, and their statistics",
    }
)

FRICTION_LAWS: Mapping[str, str] = MappingProxyType(
    {
        "power-law": "stickslip.model.laws.power_law",
    }
)
"""The laws of the viscous stress that come with stickslip, and the module of each."""


def full_law_name(name: str) -> str:
    """Return the name of a law, with its identity if it comes from outside; raises LawError."""
    if name in FRICTION_LAWS:
        return name
    try:
        return origin_of(name).full_name
    except UnknownLawError as error:
        ours = ", ".join(FRICTION_LAWS)
        raise UnknownLawError(f"must be one of {ours}, not {name!r}; {error}") from None


COSINE, HARMONICS, PULL = "cosine", "harmonics", "pull"
"""The motions of the upper block: a single tone, all tones, or a pull, which has no orbit."""


class Physics(NamedTuple):
    """The choice of the equations to integrate; each choice has its own kernels."""

    friction: str
    strain: str = ADIABATIC
    chance: bool = False
    """True if every step draws a random number, False for the typical path of the noise."""
    drive: str = COSINE
    """The motion of the upper block, a name in `model.drive.UPPER`; it follows from the point."""

    @property
    def typical(self) -> Physics:
        """The same equations, with the typical path of the noise."""
        return self._replace(chance=False)

    def __str__(self) -> str:
        strain = "" if self.strain == ADIABATIC else f",strain={self.strain}"
        drive = "" if self.drive == COSINE else f",{self.drive}"
        chance = ",stochastic" if self.chance else ""
        return f"{self.friction}{strain}{drive}{chance}"


class Range(NamedTuple):
    """The valid values of a number."""

    lower: float
    upper: float = math.inf
    lower_open: bool = False
    whole: bool = False

    def holds(self, value: Any) -> bool:
        """Return whether `value` is a number within the range."""
        is_number = isinstance(value, Real) and not isinstance(value, bool)
        if not is_number:
            return False
        above = value > self.lower if self.lower_open else value >= self.lower
        inside = bool(above and value <= self.upper and math.isfinite(value))
        return inside and (value == int(value) or not self.whole)

    def __str__(self) -> str:
        limits = f"{'greater than' if self.lower_open else 'at least'} {self.lower:g}"
        if self.upper < math.inf:
            limits = f"{self.lower:g} {'<' if self.lower_open else '<='} value <= {self.upper:g}"
        return f"a whole number, {limits}" if self.whole else limits


@dataclass(frozen=True)
class Option:
    """A number that a user can set: its default, valid range and meaning."""

    default: Any
    range: Range
    meaning: str


# Below 1e-13 rounding dominates; above 1e-2 the result is meaningless.
_TOLERANCE = Range(1e-13, 1e-2, lower_open=True)

# Kernels count in 64-bit integers.
_COUNT = Range(1, 2**63 - 1, whole=True)

OPTIONS: Mapping[str, Option] = MappingProxyType(
    {
        "rtol": Option(1e-6, _TOLERANCE, "relative tolerance of a step (adaptive)"),
        "dt": Option(1e-10, Range(0.0, lower_open=True), "time step in s (euler-cromer)"),
        "max_steps": Option(
            None, _COUNT, "budget of steps for one point; if omitted, the method's own"
        ),
        "stationary_rtol": Option(1e-6, _TOLERANCE, "remaining distance to the limit orbit"),
        "max_error": Option(
            1e-2,
            Range(0.0, 1.0, lower_open=True),
            "largest numerical error of an ok point, by its estimate; 1 accepts any",
        ),
        "max_periods": Option(5000, _COUNT, "drive periods after which a point is abandoned"),
        "window": Option(
            200,
            Range(20, 1_000_000, whole=True),
            "drive periods over which an aperiodic orbit or each realization is measured; for "
            "realizations 32 by default",
        ),
        "realizations": Option(64, Range(1, 1_000_000, whole=True), "paths of a stochastic film"),
        "seed": Option(1, Range(0, 2**64 - 1, whole=True), "seed of the random numbers"),
    }
)


_WINDOW_OF_A_REALIZATION = 32


def default_window(noise: str) -> int:
    """Return the default number of drive periods of the statistics: fewer for many random paths."""
    window = _WINDOW_OF_A_REALIZATION if noise == STOCHASTIC else OPTIONS["window"].default
    return int(window)


_FROZEN = (
    "initial_order_parameter (phi_0) = 0 without noise: phi = 0 is an exact zero of the kinetic "
    "equation, so the film could never solidify; use noise treatment 'typical-path' with "
    "noise_intensity > 0, or phi_0 > 0"
)


class NoiseError(ValueError):
    """A start at phi = 0 without noise: the film would stay liquid forever, or its state is lost.

    >>> stationary_orbit(noise="none")
    Traceback (most recent call last):
    stickslip.options.NoiseError: initial_order_parameter (phi_0) = 0 without noise: ...
    """

    def __init__(self, message: str = _FROZEN) -> None:
        super().__init__(message)


class OptionError(ValueError):
    """Options are outside their valid ranges; the message names each one.

    >>> stationary_orbit(rtol=2)
    Traceback (most recent call last):
    stickslip.options.OptionError: rtol must be ..., not 2
    """


class Settings(NamedTuple):
    """The options as plain numbers, which kernels take in one compiled specialisation."""

    rtol: float
    dt: float
    max_steps: int
    stationary_rtol: float
    max_periods: int
    window: int
    accelerate: bool


@dataclass(frozen=True)
class Options:
    """Options of the computation of an orbit, named as in a config.

    `rtol` belongs to the adaptive method, `dt` [s] to euler-cromer. `max_steps` None means the
    budget of the method. A point whose error estimate exceeds `max_error` is computed again with
    finer tolerances, and is not ok if these do not help. `realizations` and `seed` belong to the
    noise 'stochastic'. `friction` names a law of stickslip or of your own, whose identity is added.
    `stationary_rtol` is the remaining distance to the limit orbit in (x/X_m, v/(X_m omega)).
    `accelerate` extrapolates sequences that clearly contract. `observables` has no effect: all of
    them are computed.

    >>> Options(rtol=1e-8).method
    'adaptive'

    Raises OptionError for a value outside its valid range.
    """

    method: str = "adaptive"
    rtol: float = OPTIONS["rtol"].default
    dt: float = OPTIONS["dt"].default
    max_steps: int | None = OPTIONS["max_steps"].default
    max_error: float = OPTIONS["max_error"].default
    stationary_rtol: float = OPTIONS["stationary_rtol"].default
    max_periods: int = OPTIONS["max_periods"].default
    window: int = OPTIONS["window"].default
    accelerate: bool = True
    noise: str = TYPICAL_PATH
    realizations: int = OPTIONS["realizations"].default
    seed: int = OPTIONS["seed"].default
    friction: str = "power-law"
    strain: str = ADIABATIC
    observables: tuple[str, ...] = field(default=(), compare=False)

    def __post_init__(self) -> None:
        """Raise OptionError for invalid values and combinations."""
        complaints = list(self._complaints())
        try:  # the identity distinguishes two laws of the same name
            object.__setattr__(self, "friction", full_law_name(self.friction))
        except LawError as error:
            complaints.append(
                f"friction{' ' if isinstance(error, UnknownLawError) else ': '}{error}"
            )
        if complaints:
            raise OptionError("; ".join(complaints))

    def _complaints(self) -> Iterator[str]:
        choices = {"method": METHODS, "noise": NOISE_TREATMENTS, "strain": STRAINS}
        for name, known in choices.items():
            value = getattr(self, name)
            if value not in known:
                yield f"{name} must be one of {', '.join(known)}, not {value!r}"
        for name in self.observables:
            if name not in OBSERVABLES:
                yield f"observables must be among {', '.join(OBSERVABLES)}, not {name!r}"
        for name, feature in (("strain", "strains"), ("noise", "noises")):
            value = getattr(self, name)
            able = methods_for(feature, value)
            if self.method in METHODS and value in choices[name] and self.method not in able:
                yield f"{name} {value!r} needs the method {' or '.join(able)}"
        for name, option in OPTIONS.items():
            value = getattr(self, name)
            if not ((value is None and option.default is None) or option.range.holds(value)):
                yield f"{name} must be {option.range}, not {value!r}"

    @property
    def physics(self) -> Physics:
        """The equations to integrate."""
        return Physics(self.friction, self.strain, chance=self.noise == STOCHASTIC)

    def settings(self) -> Settings:
        """Return the options as kernels take them."""
        method = METHODS[self.method]
        return Settings(
            rtol=float(self.rtol),
            dt=float(self.dt),
            max_steps=int(method.max_steps if self.max_steps is None else self.max_steps),
            stationary_rtol=float(self.stationary_rtol),
            max_periods=int(self.max_periods),
            window=int(self.window),
            accelerate=bool(self.accelerate) and method.accelerates,
        )


DEFAULTS = Options()


def options_for_orbits(
    *,
    rtol: float = DEFAULTS.rtol,
    noise: str = DEFAULTS.noise,
    window: int | None = None,
    observables: str | Iterable[str] = (),
    **others: Any,
) -> Options:
    """Return the options for the keywords of `stationary_orbit`.

    Raises OptionError for a value out of range, TypeError for an unknown keyword.
    """
    known = {field.name for field in fields(Options)} - {"stationary_rtol"}
    if unknown := others.keys() - known:
        raise TypeError(f"there is no option {', '.join(sorted(unknown))}")
    return Options(
        rtol=rtol,
        stationary_rtol=rtol,
        noise=noise,
        window=default_window(noise) if window is None else window,
        observables=(observables,) if isinstance(observables, str) else tuple(observables),
        **others,
    )
