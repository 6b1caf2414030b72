"""The one declaration of a config: its keys, what each may be, and what it means.

It judges values one by one; `sweeps.config.checks` judges several together.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import math
from collections.abc import Iterable
from itertools import groupby
from typing import Annotated, Any, Literal, Self
from urllib.parse import urlsplit

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    GetPydanticSchema,
    Strict,
    WithJsonSchema,
    model_validator,
)
from pydantic_core.core_schema import ValidationInfo, literal_schema

from stickslip.course import PULL_SAMPLES
from stickslip.options import (
    DEFAULTS,
    FRICTION_LAWS,
    METHODS,
    NOISE_TREATMENTS,
    OPTIONS,
    STOCHASTIC,
    STRAINS,
)
from stickslip.parameters import Parameters
from stickslip.variables import BY_SYMBOL, OBSERVABLES, PARAMETERS, canonical_name
from sweeps.config.axis_values import Axis
from sweeps.config.diagnostics import PARAMETER_SECTIONS, quoted
from sweeps.config.group import Group
from sweeps.config.numbers import ParameterName, ResultName, Text, finite
from sweeps.config.pull import Drive
from sweeps.config.refinement import AxisName, Refine
from sweeps.config.sample import Sample
from sweeps.config.yaml_writer import block_yaml
from sweeps.executor_table import EXECUTORS
from sweeps.figure_table import FIGURES
from sweeps.human import did_you_mean
from sweeps.paths import expanded

# Ten variables of 8 bytes: a trajectory of this many samples takes 8 GB.
_MAX_SAMPLES = 100_000_000


def _one_of(names: Iterable[str]) -> GetPydanticSchema:
    """Return the type of a text that is one of these names, which tables tell at run time."""
    return GetPydanticSchema(lambda *_: literal_schema([*names]))


def _option(option: str, **other: Any) -> Any:
    """Return the field of an option of the integrators."""
    what = OPTIONS[option]
    declared = {
        "default": what.default,
        "description": what.meaning,
        "gt": what.range.lower if what.range.lower_open else None,
        "ge": None if what.range.lower_open else what.range.lower,
        "le": None if math.isinf(what.range.upper) else what.range.upper,
    }
    return Field(**declared | other)


def _of_ensembles(option: str) -> Any:
    """Return the field of an option that applies only to a stochastic film."""
    what = OPTIONS[option]
    description = f"{STOCHASTIC} only: {what.meaning}; by default {what.default}"
    return _option(option, default=None, description=description, validate_default=True)


def _belongs_to(key: str, *owners: str, default: Any = None) -> AfterValidator:
    """Refuse a value that needs certain values of another key in its section.

    For those values, a missing key has the value `default`.
    """

    def check(value: Any, info: ValidationInfo) -> Any:
        given = info.data.get(key, owners[0])  # refused itself: of no consequence here
        if value is None:
            return default if given in owners else None
        if given not in owners:
            raise ValueError(f"belongs to `{key}: {' or '.join(owners)}`, but the {key} is {given}")
        return value

    return AfterValidator(check)


def _of_noise(option: str) -> AfterValidator:
    """Refuse an option that only a stochastic film has; give it its default."""
    return _belongs_to("treatment", STOCHASTIC, default=OPTIONS[option].default)


def _of_method(option: str) -> AfterValidator:
    """Refuse an option that the method does not have."""
    return _belongs_to("method", *(n for n, m in METHODS.items() if m.own_option == option))


_SCHEMES = ("tcp", "tls", "ws", "wss")


def _address(value: str | None) -> str | None:
    """Refuse what cannot be the address of a scheduler, which no second attempt would reach."""
    if value is None:
        return None
    with contextlib.suppress(ValueError):  # such as a port that is no number
        address = urlsplit(value)
        is_host = address.hostname and address.port and not address.path
        # A cluster within this process has no port.
        if address.scheme == "inproc" or (is_host and address.scheme in _SCHEMES):
            return value
    raise ValueError(f"must be an address such as tcp://host:8786, not {value!r}")


def _not_blank(value: str) -> str:
    if not value.strip():
        raise ValueError("must not be empty; leave it out instead")
    return value


def _observables(value: object) -> object:
    """Return the groups of a list in the order of the registry: another order is the same."""
    if not isinstance(value, (list, tuple)):
        raise ValueError(f"must be a list of {' and '.join(OBSERVABLES)}, not {quoted(value)}")
    known = [name for name in OBSERVABLES if name in value]
    return [*known, *(name for name in value if name not in OBSERVABLES)]


def _fixed(value: object) -> float:
    if isinstance(value, (list, dict)):
        raise ValueError("must be a single number; an axis belongs under `sweep`")
    return finite(value)


Line = Annotated[Text, AfterValidator(_not_blank)]


class Section(Group):
    """A section of settings; all keys have defaults."""

    def used(self) -> dict[str, Any]:
        """Return the keys that have an effect, with their values."""
        return self.model_dump(exclude_none=True)


class Integrator(Section):
    """Integration of the equations; `rtol` is for adaptive, `dt` for euler-cromer."""

    method: Annotated[str, _one_of(METHODS)] = Field(
        DEFAULTS.method,
        description="; ".join(f"{name}: {method.meaning}" for name, method in METHODS.items()),
    )
    rtol: Annotated[float, _of_method("rtol")] = _option("rtol")
    dt: Annotated[float, _of_method("dt")] = _option("dt")
    max_steps: int | None = _option("max_steps")
    max_error: float = _option("max_error")

    def used(self) -> dict[str, Any]:
        """Return what the method uses: the tolerance or the step, never both."""
        own = {method.own_option for method in METHODS.values()}
        unused = own - {METHODS[self.method].own_option}
        return self.model_dump(exclude=unused, exclude_none=True)


class Stationary(Section):
    """When an orbit counts as stationary."""

    rtol: float = _option("stationary_rtol")
    max_periods: int = _option("max_periods")
    window: int = _option("window")
    accelerate: Annotated[bool, Strict()] = Field(
        DEFAULTS.accelerate, description="extrapolate clearly contracting sequences (adaptive)"
    )


class Noise(Section):
    """Treatment of the weak noise of the order parameter."""

    treatment: Annotated[str, _one_of(NOISE_TREATMENTS)] = Field(
        DEFAULTS.noise,
        description="; ".join(f"{name}: {what}" for name, what in NOISE_TREATMENTS.items()),
    )
    seed: Annotated[int | None, _of_noise("seed")] = _of_ensembles("seed")
    realizations: Annotated[int | None, _of_noise("realizations")] = _of_ensembles("realizations")


class Film(Section):
    """Model of the lubricant film."""

    friction: Annotated[
        Text, WithJsonSchema({"anyOf": [{"enum": [*FRICTION_LAWS]}, {"type": "string"}]})
    ] = Field(DEFAULTS.friction, description="law of the viscous stress, ours or your own")
    law: Text | None = Field(
        None,
        description="identity of a law of your own, which results carry: the name, the version and "
        "a hash of its package; by default that of the installed one",
    )
    strain: Annotated[str, _one_of(STRAINS)] = Field(
        DEFAULTS.strain,
        description="the elastic strain; "
        + "; ".join(f"{name}: {meaning}" for name, meaning in STRAINS.items()),
    )


class Execution(Section):
    """Distribution of the work; it never affects the result."""

    workers: int | None = Field(
        None,
        ge=1,
        le=4096,
        description="number of threads or processes; by default one for each core that the "
        "process may use",
    )
    backend: Annotated[str, _one_of(EXECUTORS)] = Field(
        next(iter(EXECUTORS)),
        description="; ".join(f"{name}: {entry.meaning}" for name, entry in EXECUTORS.items()),
    )
    scheduler: Annotated[Text | None, _belongs_to("backend", "dask"), AfterValidator(_address)] = (
        Field(None, description="address of a dask scheduler; never in a file")
    )
    block_points: int | None = Field(
        None,
        ge=1,
        le=2**63 - 1,
        description="points per block; by default about a second of work",
    )

    @property
    def slots(self) -> int:
        """The number of threads or processes."""
        import joblib

        return self.workers or int(joblib.cpu_count())


class Plot(Section):
    """The picture of the result."""

    figure: Annotated[str, _one_of(FIGURES)] = Field(
        next(iter(FIGURES)),
        description="; ".join(
            f"{', '.join(names)}: of {drawn}"
            for drawn, names in groupby(FIGURES, key=lambda name: FIGURES[name].drawn)
        ),
    )
    variables: list[ResultName] | None = Field(
        None, description="amplitudes: the result variables to draw; by default both amplitudes"
    )
    elastic_strain: float | None = Field(
        None,
        ge=0,
        lt=1,
        description="free_energy, landscape: the strain; by default that of Fig. 2",
    )


class Simulation(Section):
    """The trajectory that `simulate` and the figures of trajectories compute."""

    periods: int = Field(6, ge=1, le=_MAX_SAMPLES, description="drive periods")
    start: Literal["initial", "stationary"] = Field(
        "initial", description="the initial values, or the stationary orbit"
    )
    samples_per_period: int = Field(
        2000, ge=2, le=_MAX_SAMPLES, description="samples per period, evenly spaced"
    )

    schedule: Annotated[
        dict[ParameterName, Axis] | None, AfterValidator(lambda schedule: schedule or None)
    ] = Field(
        None,
        description="parameters that change together along the run: "
        "`periods` at the first values, as many at the second, and so on",
    )
    drive: Drive | None = Field(
        None, description="pull the upper block instead of moving it periodically (adaptive)"
    )
    duration: float | None = Field(
        None, gt=0, description="seconds of a `drive`; by default to the last time of its table"
    )
    samples: int = Field(
        PULL_SAMPLES, ge=2, le=_MAX_SAMPLES, description="samples of a `drive`, evenly spaced"
    )

    @model_validator(mode="after")
    def _fits_the_drive(self) -> Self:
        if self.drive is None:
            if self.duration is not None:
                raise ValueError("`duration` belongs to a `drive`; give one, or give `periods`")
            return self
        if self.schedule:
            raise ValueError("`schedule` belongs to the periodic drive; leave it or `drive` out")
        if self.start == "stationary":
            raise ValueError(
                "`start: stationary` belongs to the periodic drive, no other one has a stationary "
                "orbit; leave it or `drive` out"
            )
        if self.drive.velocity is not None and self.duration is None:
            raise ValueError("`drive: {velocity: ...}` needs a `duration` in s")
        return self

    @model_validator(mode="after")
    def _fits_the_memory(self) -> Self:
        sections = len(next(iter((self.schedule or {}).values()), (0,)))
        if self.periods * self.samples_per_period * sections > _MAX_SAMPLES:
            raise ValueError(
                f"`periods` times `samples_per_period`, of all sections together, must be at most "
                f"{_MAX_SAMPLES}"
            )
        return self

    def arguments(self) -> dict[str, Any]:
        """Return what `stickslip.simulate` is asked for."""
        own = ("drive", "duration", "samples")
        if self.drive is None:
            return self.model_dump(exclude={*own})
        pull = {"drive": self.drive.pull, "duration": self.duration, "samples": self.samples}
        return pull | {"start": self.start}


class Config(Group):
    """What to compute, how, and where to write it.

    Parameters go by their full names. `model` holds the fixed ones that were given; `parameters`
    adds the paper's values for the rest. `sweep` keeps the order of its axes. The points that
    `sample` draws are stored in `cases`. `load` and `from_mapping` return only valid configs; two
    are equal if they ask for the same computation, executed in the same way and written to the same
    file.
    """

    title: Line | None = Field(None, description="One line about the result.")
    model: dict[ParameterName, Annotated[float, BeforeValidator(_fixed)]] = Field(
        {}, description="Fixed parameters; the others have the paper's values."
    )
    sweep: dict[ParameterName, Axis] = Field(
        {}, description="Full product of these axes, in this order."
    )
    cases: dict[ParameterName, Axis] = Field(
        {}, description="Linked values: the first of each, the second of each ..."
    )
    sample: Sample | None = None
    follow: AxisName | None = Field(
        None, description="Swept axis along which each point starts from the previous one."
    )
    refine: Refine | None = None
    integrator: Integrator = Integrator()
    stationary: Stationary = Stationary()
    noise: Noise = Noise()
    film: Film = Film()
    observables: Annotated[
        tuple[Annotated[str, _one_of(OBSERVABLES)], ...], BeforeValidator(_observables)
    ] = Field((), description="Without effect: all result variables are computed.")
    execution: Execution = Execution()
    plot: Plot = Plot()
    simulation: Simulation = Simulation()
    output: Annotated[Line, AfterValidator(expanded)] = Field(
        "results/sweep.nc",
        description="Result file; by default NAME.yaml writes results/NAME.nc. `~` is the home "
        "folder, and `$NAME` a variable of the environment.",
    )
    _warnings: tuple[str, ...] = ()

    @property
    def warnings(self) -> tuple[str, ...]:
        """Values that are allowed but probably not meant, a line each."""
        return self._warnings

    def settled(self, warnings: Iterable[str], **keys: Any) -> Config:
        """Return the same with other values of some keys, and with warnings."""
        config = self.model_copy(update=keys)
        config._warnings = tuple(warnings)
        return config

    @property
    def names(self) -> set[str]:
        """The parameters with a value of their own."""
        return {*self.model, *self.sweep, *self.cases}

    def values(self, name: str) -> tuple[float, ...]:
        """Return all values that a parameter takes."""
        default: float = PARAMETERS[name].default
        return self.sweep.get(name) or self.cases.get(name) or (self.model.get(name, default),)

    def parameters(self) -> Parameters:
        """Return the fixed parameters, with the paper's values for those that are not given."""
        return Parameters(**self.model)

    def defining(self) -> dict[str, dict[str, Any]]:
        """Return the settings, by section, that besides the parameters make the numbers."""
        return {name: getattr(self, name).used() for name in DEFINING}

    def resolved(self) -> dict[str, Any]:
        """Return all that defines the result, without `execution` and `output`, ready for JSON."""
        varied = {*self.sweep, *self.cases}
        fixed = self.parameters()._asdict()
        title = {} if self.title is None else {"title": self.title}
        return title | {
            "model": {name: value for name, value in fixed.items() if name not in varied},
            "sweep": {name: list(values) for name, values in self.sweep.items()},
            "cases": {name: list(values) for name, values in self.cases.items()},
            **self.order(),
            **self.defining(),
            "plot": self.plot.model_dump(exclude_none=True),
            "simulation": self.simulation.model_dump(mode="json", exclude_none=True),
        }

    def order(self) -> dict[str, Any]:
        """Return the keys that say which points are computed, and in which order."""
        follow = {} if self.follow is None else {"follow": self.follow}
        return follow | ({"refine": self.refine.model_dump(mode="json")} if self.refine else {})

    def resolved_yaml(self) -> str:
        """Return `resolved` as YAML; it is an equal config but for `execution` and `output`."""
        return block_yaml(self.resolved())

    def sha256(self) -> str:
        """Return the hash of what defines the numbers: title, plot and simulation do not enter."""
        resolved = self.resolved()
        parts: dict[str, Any] = {key: resolved[key] for key in (*PARAMETER_SECTIONS, *DEFINING)}
        # Newer parameters at their defaults, which older results lack, do not count.
        parts["model"] = {
            name: value
            for name, value in parts["model"].items()
            if name not in _NEWER or value != PARAMETERS[name].default
        }
        parts |= self.order()
        # As pairs, because the order of the axes is the order of the dimensions.
        parts["sweep"] = list(parts["sweep"].items())
        canonical = json.dumps(parts, sort_keys=True, separators=(",", ":"), allow_nan=False)
        return hashlib.sha256(canonical.encode()).hexdigest()

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Config):
            return NotImplemented
        return self._identity() == other._identity()

    def __hash__(self) -> int:
        return hash(self._identity())

    def _identity(self) -> tuple[str, str, Execution]:
        return self.resolved_yaml(), self.output, self.execution

    @classmethod
    def unknown_key(cls, key: str) -> str:
        """Return where an unknown key would be right, or which key may be meant."""
        if canonical_name(key):
            return "unknown key; a parameter stands under `model`, `sweep` or `cases`"
        hint = cls.home_of(key) or did_you_mean(key, [*KEYS, *BY_SYMBOL, *PARAMETERS])
        return "unknown key" + (hint or f"; known are {', '.join(KEYS)}")


KEYS = tuple(Config.model_fields)
_NEWER = ("third_harmonic", "fifth_harmonic")

DEFINING = ("integrator", "stationary", "noise", "film")
"""The sections that, besides the parameters, make the numbers of a point."""
