"""The declaration of a config: its keys, with their valid values and meanings.

It checks values one by one; `sweeps.config.checks` checks several together.
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
from sweeps.config.group import Group
from sweeps.config.numbers import ParameterName, ResultName, Text, finite
from sweeps.config.pull import Drive
from sweeps.config.refinement import AxisName, Refine
from sweeps.config.sample import Sample
from sweeps.config.written_config import PARAMETER_SECTIONS, quoted
from sweeps.config.yaml_writer import block_yaml
from sweeps.executor_table import EXECUTORS
from sweeps.figure_table import FIGURES
from sweeps.human import did_you_mean
from sweeps.paths import expanded

# Ten variables of 8 bytes: a trajectory of this many samples takes 8 GB.
_MAX_SAMPLES = 100_000_000


def _one_of(names: Iterable[str]) -> GetPydanticSchema:
    """Return the type of a text that is one of these names, which are known only at run time."""
    return GetPydanticSchema(lambda *_: literal_schema([*names]))


def _option(option: str, **other: Any) -> Any:
    """Return the field for an option of the integrators."""
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
    """Return the field for an option that applies only to a stochastic film."""
    what = OPTIONS[option]
    description = f"{STOCHASTIC} only: {what.meaning}; by default {what.default}"
    return _option(option, default=None, description=description, validate_default=True)


def _belongs_to(key: str, *owners: str) -> AfterValidator:
    """Return a validator for a key that belongs to some values, `owners`, of another key.

    If the other key has such a value, a missing option of the integrators gets its default.
    """

    def check(value: Any, info: ValidationInfo) -> Any:
        given = info.data.get(key, owners[0])  # absent if refused, which is reported there
        if value is None:
            option = OPTIONS.get(str(info.field_name))
            return option.default if option and given in owners else None
        if given not in owners:
            raise ValueError(f"belongs to `{key}: {' or '.join(owners)}`, but the {key} is {given}")
        return value

    return AfterValidator(check)


_OfEnsembles = Annotated[int | None, _belongs_to("treatment", STOCHASTIC)]


def _of_method(option: str) -> AfterValidator:
    """Return a validator for an option that belongs to some methods."""
    return _belongs_to("method", *(n for n, m in METHODS.items() if m.own_option == option))


_SCHEMES = ("tcp", "tls", "ws", "wss")


def _address(value: str) -> str:
    """Refuse a text that cannot be the address of a scheduler, so that nobody waits for it."""
    with contextlib.suppress(ValueError):  # for example a port that is no number
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
    """Return groups of observables in the order of the registry, since their order is free."""
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
    """A section of settings, whose keys all have defaults."""

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
        """Return the keys that the method uses: the tolerance or the step, never both."""
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
    seed: _OfEnsembles = _of_ensembles("seed")
    realizations: _OfEnsembles = _of_ensembles("realizations")


class Film(Section):
    """Model of the lubricant film."""

    friction: Annotated[
        Text, WithJsonSchema({"anyOf": [{"enum": [*FRICTION_LAWS]}, {"type": "string"}]})
    ] = Field(DEFAULTS.friction, description="law of the viscous stress, built in or your own")
    law: Text | None = Field(
        None,
        description="identity of a law of your own, stored in results: the name, the version and a "
        "hash of its package; by default the identity of the installed law",
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
    scheduler: Annotated[
        Annotated[Text, AfterValidator(_address)] | None, _belongs_to("backend", "dask")
    ] = Field(None, description="address of a dask scheduler; not allowed in a file")
    block_points: int | None = Field(
        None,
        ge=1,
        le=2**63 - 1,
        description="number of points per block; by default about a second of work",
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
            f"{', '.join(names)}: for {drawn}"
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
        description="free_energy, landscape: the strain; by default the strain of Fig. 2",
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
        "`periods` drive periods with the first values, as many with the second, and so on",
    )
    drive: Drive | None = Field(
        None, description="pull the upper block instead of moving it periodically (adaptive only)"
    )
    duration: float | None = Field(
        None, gt=0, description="duration of a `drive` in s; by default the last time in its table"
    )
    samples: int = Field(
        PULL_SAMPLES, ge=2, le=_MAX_SAMPLES, description="samples along a `drive`, evenly spaced"
    )

    @model_validator(mode="after")
    def _fits_the_drive(self) -> Self:
        if self.drive is None:
            if self.duration is not None:
                raise ValueError("`duration` belongs to a `drive`; add a `drive`, or use `periods`")
            if self.samples != PULL_SAMPLES:
                raise ValueError(
                    "`samples` belongs to a `drive`; add a `drive`, or use `samples_per_period`"
                )
            return self
        if self.schedule:
            raise ValueError("`schedule` belongs to the periodic drive; leave one of the two out")
        if self.start == "stationary":
            raise ValueError(
                "`start: stationary` belongs to the periodic drive, since only that has a "
                "stationary orbit; leave one of the two out"
            )
        if self.drive.velocity is not None and self.duration is None:
            raise ValueError("`drive: {velocity: ...}` needs a `duration` in s")
        return self

    @model_validator(mode="after")
    def _fits_the_memory(self) -> Self:
        sections = len(next(iter((self.schedule or {}).values()), (0,)))
        if self.periods * self.samples_per_period * sections > _MAX_SAMPLES:
            raise ValueError(
                f"`periods` times `samples_per_period`, summed over the schedule, must be at most "
                f"{_MAX_SAMPLES}"
            )
        return self

    def arguments(self) -> dict[str, Any]:
        """Return the arguments for `stickslip.simulate`."""
        if self.drive is None:
            return self.model_dump(exclude={"drive", "duration", "samples"})
        return {
            "drive": self.drive.pull,
            "duration": self.duration,
            "samples": self.samples,
            "start": self.start,
        }


class Config(Group):
    """What to compute, how, and where to write it.

    Parameters have their full names. `model` holds the fixed parameters in the config; `parameters`
    adds the paper's values for the others. `sweep` keeps the order of its axes. The points drawn by
    `sample` are in `cases`. `load` and `from_mapping` return only valid configs. Two configs are
    equal if they describe the same computation, execution and output file.
    """

    title: Line | None = Field(None, description="One line about the result.")
    model: dict[ParameterName, Annotated[float, BeforeValidator(_fixed)]] = Field(
        {}, description="Fixed parameters; the others have the paper's values."
    )
    sweep: dict[ParameterName, Axis] = Field(
        {}, description="Full product of these axes, in this order."
    )
    cases: dict[ParameterName, Axis] = Field(
        {},
        description="Linked values: case 0 has the first value of each parameter, case 1 the "
        "second, and so on.",
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
    ] = Field((), description="Has no effect: all result variables are computed.")
    execution: Execution = Execution()
    plot: Plot = Plot()
    simulation: Simulation = Simulation()
    output: Annotated[Line, AfterValidator(expanded)] = Field(
        "results/sweep.nc",
        description="Result file; by default NAME.yaml writes results/NAME.nc. `~` is the home "
        "folder, and `$NAME` an environment variable.",
    )
    _warnings: tuple[str, ...] = ()

    @property
    def warnings(self) -> tuple[str, ...]:
        """A line for each value that is allowed but probably a mistake."""
        return self._warnings

    def settled(self, warnings: Iterable[str], **keys: Any) -> Config:
        """Return the config with other values of some keys, and with warnings."""
        config = self.model_copy(update=keys)
        config._warnings = tuple(warnings)
        return config

    @property
    def names(self) -> set[str]:
        """The parameters that have values in the config."""
        return {*self.model, *self.sweep, *self.cases}

    def values(self, name: str) -> tuple[float, ...]:
        """Return all values that a parameter takes."""
        default: float = PARAMETERS[name].default
        return self.sweep.get(name) or self.cases.get(name) or (self.model.get(name, default),)

    def parameters(self) -> Parameters:
        """Return the fixed parameters, with the paper's values by default."""
        return Parameters(**self.model)

    def defining(self) -> dict[str, dict[str, Any]]:
        """Return the settings, by section, that determine the numbers besides the parameters."""
        return {name: getattr(self, name).used() for name in DEFINING}

    def resolved(self) -> dict[str, Any]:
        """Return the keys that define the result, not `execution` and `output`, ready for JSON."""
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
        """Return the keys that choose the computed points and their order."""
        follow = {} if self.follow is None else {"follow": self.follow}
        return follow | ({"refine": self.refine.model_dump(mode="json")} if self.refine else {})

    def resolved_yaml(self) -> str:
        """Return `resolved` as YAML, giving an equal config except for `execution` and `output`."""
        return block_yaml(self.resolved())

    def sha256(self) -> str:
        """Return the hash of the keys that define the numbers, not title, plot and simulation."""
        resolved = self.resolved()
        parts: dict[str, Any] = {key: resolved[key] for key in (*PARAMETER_SECTIONS, *DEFINING)}
        # Older results lack the newer parameters, so these count only if not at their defaults.
        parts["model"] = {
            name: value
            for name, value in parts["model"].items()
            if name not in _NEWER or value != PARAMETERS[name].default
        }
        parts |= self.order()
        # Pairs keep the order of the axes, which is the order of the dimensions.
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
        """Return a complaint about an unknown key, with its right place or a similar known key."""
        if canonical_name(key):
            return "unknown key; a parameter belongs under `model`, `sweep` or `cases`"
        hint = cls.home_of(key) or did_you_mean(key, [*KEYS, *BY_SYMBOL, *PARAMETERS])
        return "unknown key" + (hint or f"; the known keys are {', '.join(KEYS)}")


KEYS = tuple(Config.model_fields)
_NEWER = ("third_harmonic", "fifth_harmonic")

DEFINING = ("integrator", "stationary", "noise", "film")
"""The sections that determine the numbers of a point besides the parameters."""
