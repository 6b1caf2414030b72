"""The sections of a config that say how to compute, where to write and what to draw."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from ipaddress import ip_address
from typing import Annotated, Any, Literal, Self
from urllib.parse import urlsplit

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    GetPydanticSchema,
    Strict,
    ValidationError,
    model_validator,
)
from pydantic_core import ErrorDetails
from pydantic_core.core_schema import ValidationInfo, literal_schema

from stickslip.options import (
    DEFAULTS,
    FRICTION_LAWS,
    METHODS,
    NOISE_TREATMENTS,
    OPTIONS,
    STOCHASTIC,
    STRAINS,
)
from sweeps.config.diagnostics import UNREADABLE, Located, quoted
from sweeps.config.numbers import number, text, whole
from sweeps.executor_table import EXECUTORS
from sweeps.figure_table import FIGURES
from sweeps.human import did_you_mean

# Ten variables of 8 bytes: a trajectory of this many samples takes 8 GB.
_MAX_SAMPLES = 100_000_000

# Pydantic's words and ours.
_WORDS = {
    "Input should be": "must be",
    "greater than or equal to": "at least",
    "less than or equal to": "at most",
}


def _one_of(names: Iterable[str]) -> GetPydanticSchema:
    """A text that is one of these names, which tables tell at run time only."""
    return GetPydanticSchema(lambda *_: literal_schema([*names]))


def _range(option: str) -> Any:
    """The valid values of an option of the integrators."""
    limits = OPTIONS[option].range
    return Field(
        gt=limits.lower if limits.lower_open else None,
        ge=None if limits.lower_open else limits.lower,
        le=None if math.isinf(limits.upper) else limits.upper,
    )


def _option(option: str) -> Any:
    """The field of an option of the integrators."""
    return Field(OPTIONS[option].default, description=OPTIONS[option].meaning)


def _of_ensembles(option: str) -> Any:
    """The field of an option that counts for a stochastic film alone."""
    what = OPTIONS[option]
    return Field(None, description=f"{STOCHASTIC} alone: {what.meaning}; left out, {what.default}")


def _belongs_to(key: str, *owners: str) -> AfterValidator:
    """Refuse a value that only some values of another key of its section make sense of."""

    def check(value: Any, info: ValidationInfo) -> Any:
        given = info.data.get(key, owners[0])  # refused itself: of no consequence here
        if value is not None and given not in owners:
            raise ValueError(f"belongs to `{key}: {' or '.join(owners)}`, but the {key} is {given}")
        return value

    return AfterValidator(check)


def _of_method(option: str) -> AfterValidator:
    """Refuse an option that the method does not have."""
    return _belongs_to("method", *(n for n, m in METHODS.items() if m.own_option == option))


def _number_or_none(value: object) -> float | None:
    return None if value is None else number(value)


def _address(value: str | None) -> str | None:
    if value is not None and "://" not in value:
        raise ValueError(f"must be an address such as tcp://host:8786, not {value!r}")
    return value


def is_local(address: str) -> bool:
    """Whether the address of a scheduler is one of this machine alone."""
    host = urlsplit(address).hostname or ""
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


# The bounds come first: behind the validator they would be missing in the JSON Schema.
Text = Annotated[str, BeforeValidator(text)]
Tolerance = Annotated[float, _range("rtol"), BeforeValidator(number)]
Step = Annotated[float, _range("dt"), BeforeValidator(number)]
MaxError = Annotated[float, _range("max_error"), BeforeValidator(number)]
Count = Annotated[int, _range("max_periods"), BeforeValidator(whole)]
Window = Annotated[int, _range("window"), BeforeValidator(whole)]
Seed = Annotated[int, _range("seed"), BeforeValidator(whole)]
Realizations = Annotated[int, _range("realizations"), BeforeValidator(whole)]
Workers = Annotated[int, Field(ge=1, le=4096), BeforeValidator(whole)]
Switch = Annotated[bool, Strict()]
Periods = Annotated[int, Field(ge=1, le=_MAX_SAMPLES), BeforeValidator(whole)]
Samples = Annotated[int, Field(ge=2, le=_MAX_SAMPLES), BeforeValidator(whole)]


class Section(BaseModel):
    """A group of keys; all of them have defaults, unknown ones are refused."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    def used(self) -> dict[str, Any]:
        """The keys that have an effect, with their values."""
        return self.model_dump(exclude_none=True)


class Integrator(Section):
    """How the equations are integrated; `rtol` counts for adaptive, `dt` for euler-cromer."""

    method: Annotated[str, _one_of(METHODS)] = Field(
        DEFAULTS.method,
        description="; ".join(f"{name}: {method.meaning}" for name, method in METHODS.items()),
    )
    rtol: Annotated[Tolerance, _of_method("rtol")] = _option("rtol")
    dt: Annotated[Step, _of_method("dt")] = _option("dt")
    max_steps: Count | None = _option("max_steps")
    max_error: MaxError = _option("max_error")

    def used(self) -> dict[str, Any]:
        """What the method uses: the tolerance or the step, never both."""
        own = {method.own_option for method in METHODS.values()}
        unused = own - {METHODS[self.method].own_option}
        return self.model_dump(exclude=unused, exclude_none=True)


class Stationary(Section):
    """When an orbit counts as stationary."""

    rtol: Tolerance = _option("stationary_rtol")
    max_periods: Count = _option("max_periods")
    window: Window = _option("window")
    accelerate: Switch = Field(
        DEFAULTS.accelerate, description="extrapolate plainly contracting sequences (adaptive)"
    )


class Noise(Section):
    """How the weak noise of the order parameter is treated."""

    treatment: Annotated[str, _one_of(NOISE_TREATMENTS)] = Field(
        DEFAULTS.noise,
        description="; ".join(f"{name}: {what}" for name, what in NOISE_TREATMENTS.items()),
    )
    seed: Annotated[Seed | None, _belongs_to("treatment", STOCHASTIC)] = _of_ensembles("seed")
    realizations: Annotated[Realizations | None, _belongs_to("treatment", STOCHASTIC)] = (
        _of_ensembles("realizations")
    )

    def settled(self) -> Noise:
        """The same with every key that has an effect."""
        if self.treatment != STOCHASTIC:
            return self.model_copy(update={"seed": None, "realizations": None})
        given = {key: getattr(self, key) for key in ("seed", "realizations")}
        default = {key: getattr(DEFAULTS, key) for key, value in given.items() if value is None}
        return self.model_copy(update=default)


class Film(Section):
    """How the lubricant film is modelled."""

    friction: Annotated[str, _one_of(FRICTION_LAWS)] = Field(
        DEFAULTS.friction, description="law of the viscous stress"
    )
    strain: Annotated[str, _one_of(STRAINS)] = Field(
        DEFAULTS.strain,
        description="the elastic strain; "
        + "; ".join(f"{name}: {meaning}" for name, meaning in STRAINS.items()),
    )


class Execution(Section):
    """How the work is spread; never part of the identity of a result."""

    workers: Workers = Field(2, description="threads, or processes, that compute at once")
    backend: Annotated[str, _one_of(EXECUTORS)] = Field(
        next(iter(EXECUTORS)),
        description="; ".join(f"{name}: {entry.meaning}" for name, entry in EXECUTORS.items()),
    )
    scheduler: Annotated[Text | None, _belongs_to("backend", "dask"), AfterValidator(_address)] = (
        Field(None, description="address of a dask scheduler")
    )
    block_points: Count | None = Field(
        None, description="points handed out at once; left out, about a second's work"
    )


class Plot(Section):
    """Which picture shows the result."""

    figure: Annotated[str, _one_of(FIGURES)] = Field(
        next(iter(FIGURES)),
        description="; ".join(f"{name}: of {figure.drawn}" for name, figure in FIGURES.items()),
    )
    elastic_strain: Annotated[float | None, Field(ge=0, lt=1), BeforeValidator(_number_or_none)] = (
        Field(None, description="free_energy, landscape: the strain; left out, that of Fig. 2")
    )


class Simulation(Section):
    """The trajectory that `simulate` and the figures of trajectories compute."""

    periods: Periods = Field(6, description="drive periods")
    start: Literal["initial", "stationary"] = Field(
        "initial", description="the initial values, or the settled orbit"
    )
    samples_per_period: Samples = Field(
        2000, description="instants of a period that are kept, evenly spaced"
    )

    schedule: dict[str, tuple[float, ...]] | None = Field(
        None,
        description="parameters that change along the run, with equally many values of each: "
        "`periods` at the first, as many at the second, and so on",
    )

    @model_validator(mode="after")
    def _fits_the_memory(self) -> Self:
        sections = len(next(iter((self.schedule or {}).values()), (0,)))
        if self.periods * self.samples_per_period * sections > _MAX_SAMPLES:
            raise ValueError(
                f"`periods` times `samples_per_period`, of all sections together, must be at most "
                f"{_MAX_SAMPLES}"
            )
        return self


class Sections(BaseModel):
    """The sections of a config."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    integrator: Integrator = Integrator()
    stationary: Stationary = Stationary()
    noise: Noise = Noise()
    film: Film = Film()
    execution: Execution = Execution()
    plot: Plot = Plot()
    simulation: Simulation = Simulation()


SECTIONS: dict[str, Any] = {name: f.annotation for name, f in Sections.model_fields.items()}
DEFINING = ("integrator", "stationary", "noise", "film")
"""The sections that, besides the parameters, make the numbers of a point."""


def read_section(root: Located, name: str) -> Section | None:
    """Return the section of a config; None where it is refused."""
    kind: type[Section] = SECTIONS[name]
    node = root.value.get(name)
    if node is None or node.value is None:
        return kind()
    if node.value is UNREADABLE:
        return None
    if not isinstance(node.value, dict):
        keys = ", ".join(kind.model_fields)
        node.refuse(f"must hold lines `key: value` with the keys {keys}, not {quoted(node.value)}")
        return None
    try:
        return kind.model_validate(node.plain())
    except ValidationError as error:
        for details in error.errors(include_url=False):
            if details["input"] is not UNREADABLE:
                node.refuse(_message(details, kind), *details["loc"])
    return None


def _message(details: ErrorDetails, kind: type[Section]) -> str:
    """Pydantic's finding in the words of this project."""
    if details["type"] == "value_error":
        return str(details["ctx"]["error"])
    if details["type"] == "extra_forbidden":
        known = kind.model_fields
        hint = did_you_mean(str(details["loc"][-1]), known)
        return "unknown key" + (hint or f"; known are {', '.join(known)}")
    message, value = details["msg"], details["input"]
    for theirs, ours in _WORDS.items():
        message = message.replace(theirs, ours)
    for limit in details.get("ctx", {}).values():
        if isinstance(limit, float):
            message = re.sub(r"[\d.]+$", f"{limit:g}", message)
    names = re.findall("'(.*?)'", message) if isinstance(value, str) else ()
    return f"{message}, not {quoted(value)}{did_you_mean(value, names) if names else ''}"
