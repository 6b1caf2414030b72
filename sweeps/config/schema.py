"""The sections of a config that say how to compute, where to write and what to draw."""

from __future__ import annotations

import re
from typing import Annotated, Any, Literal

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    Strict,
    ValidationError,
    field_validator,
)
from pydantic_core import ErrorDetails
from pydantic_core.core_schema import ValidationInfo

from sweeps.config.diagnostics import UNREADABLE, Located, quoted
from sweeps.config.numbers import number, text, whole
from sweeps.human import did_you_mean

# Kernels count in 64-bit integers.
_MAX_COUNT = 2**63 - 1
# Ten variables of 8 bytes: a trajectory of this many samples takes 8 GB.
_MAX_SAMPLES = 100_000_000

_BOUNDS = {
    "greater_than": "greater than",
    "greater_than_equal": "at least",
    "less_than": "less than",
    "less_than_equal": "at most",
}

# The bounds come first: behind the validator they would be missing in the JSON Schema.
Text = Annotated[str, BeforeValidator(text)]
# Below 1e-13 rounding decides, above 1e-2 the answer means nothing.
Tolerance = Annotated[float, Field(gt=1e-13, le=1e-2), BeforeValidator(number)]
Step = Annotated[float, Field(gt=0), BeforeValidator(number)]
Count = Annotated[int, Field(ge=1, le=_MAX_COUNT), BeforeValidator(whole)]
Seed = Annotated[int, Field(ge=0, lt=2**64), BeforeValidator(whole)]
Workers = Annotated[int, Field(ge=1, le=4096), BeforeValidator(whole)]
Switch = Annotated[bool, Strict()]
Periods = Annotated[int, Field(ge=1, le=_MAX_SAMPLES), BeforeValidator(whole)]
Samples = Annotated[int, Field(ge=2, le=_MAX_SAMPLES), BeforeValidator(whole)]


class Section(BaseModel):
    """A group of settings; all of them have defaults, unknown ones are refused."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class Integrator(Section):
    """How the equations are integrated; `rtol` counts for adaptive, `dt` for euler-cromer."""

    method: Literal["adaptive", "euler-cromer"] = "adaptive"
    rtol: Tolerance = Field(1e-6, description="relative tolerance of a step (adaptive)")
    dt: Step = Field(1e-10, description="time step in s (euler-cromer)")
    max_steps: Count | None = Field(
        None, description="budget of steps for one point; left out, the method's own"
    )

    @field_validator("rtol", "dt")
    @classmethod
    def _belongs_to_the_method(cls, value: float, info: ValidationInfo) -> float:
        owner = {"rtol": "adaptive", "dt": "euler-cromer"}[info.field_name or ""]
        method = info.data.get("method", owner)
        if method != owner:
            raise ValueError(f"belongs to `method: {owner}`, but the method is {method}")
        return value

    def settings(self) -> dict[str, Any]:
        """What the method uses: the tolerance or the step, never both."""
        unused = "dt" if self.method == "adaptive" else "rtol"
        return self.model_dump(exclude={unused}, exclude_none=True)


class Stationary(Section):
    """When an orbit counts as stationary."""

    rtol: Tolerance = Field(1e-6, description="remaining distance to the limit orbit")
    max_periods: Count = Field(5000, description="drive periods after which a point is given up")
    accelerate: Switch = Field(
        True, description="extrapolate plainly contracting sequences (adaptive)"
    )


class Noise(Section):
    """How the weak noise of the order parameter is treated."""

    treatment: Literal["typical-path", "none", "stochastic"] = "typical-path"
    seed: Seed | None = Field(None, description="stochastic")
    realizations: Count | None = Field(None, description="stochastic")

    @field_validator("treatment")
    @classmethod
    def _is_available(cls, value: str) -> str:
        if value == "stochastic":
            raise ValueError("stochastic is not available yet; use typical-path or none")
        return value

    @field_validator("seed", "realizations")
    @classmethod
    def _belongs_to_stochastic(cls, value: int | None, info: ValidationInfo) -> int | None:
        treatment = info.data.get("treatment", "stochastic")
        if value is not None and treatment != "stochastic":
            raise ValueError(
                f"belongs to `treatment: stochastic`, but the treatment is {treatment}"
            )
        return value


class Execution(Section):
    """How the work is spread; never part of the identity of a result."""

    workers: Workers = 2
    backend: Literal["threads", "loky", "dask"] = "threads"
    scheduler: Text | None = Field(None, description="address of a dask scheduler, tcp://...")
    block_points: Count | None = Field(
        None, description="points handed out at once; left out, about a second's work"
    )

    @field_validator("scheduler")
    @classmethod
    def _belongs_to_dask(cls, value: str | None, info: ValidationInfo) -> str | None:
        backend = info.data.get("backend", "dask")
        if value is not None and backend != "dask":
            raise ValueError(f"belongs to `backend: dask`, but the backend is {backend}")
        if value is not None and "://" not in value:
            raise ValueError(f"must be an address such as tcp://host:8786, not {value!r}")
        return value


class Plot(Section):
    """Which picture shows the result."""

    figure: Literal["amplitudes", "time_courses", "relative_motion", "phase_portraits"] = (
        "amplitudes"
    )


class Simulation(Section):
    """The trajectory that `simulate` and the figures of trajectories compute."""

    periods: Periods = Field(6, description="drive periods")
    start: Literal["initial", "stationary"] = Field(
        "initial", description="the initial values, or the settled orbit"
    )
    samples_per_period: Samples = 2000

    @field_validator("samples_per_period")
    @classmethod
    def _fits_the_memory(cls, value: int, info: ValidationInfo) -> int:
        if value * info.data.get("periods", 1) > _MAX_SAMPLES:
            raise ValueError(f"times `periods` must be at most {_MAX_SAMPLES}, not {value}")
        return value


SECTIONS: dict[str, type[Section]] = {
    "integrator": Integrator,
    "stationary": Stationary,
    "noise": Noise,
    "execution": Execution,
    "plot": Plot,
    "simulation": Simulation,
}


def read_section(root: Located, name: str) -> Section | None:
    """The section with what the config leaves out at its defaults; None where it is refused."""
    kind = SECTIONS[name]
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
    value, known = details["input"], kind.model_fields
    match details["type"]:
        case "extra_forbidden":
            hint = did_you_mean(str(details["loc"][-1]), known)
            return "unknown key" + (hint or f"; known are {', '.join(known)}")
        case "value_error":
            return str(details["ctx"]["error"])
        case "greater_than" | "greater_than_equal" | "less_than" | "less_than_equal" as bound:
            ((_, limit),) = details["ctx"].items()
            return f"must be {_BOUNDS[bound]} {limit:g}, not {quoted(value)}"
        case "literal_error":
            expected = details["ctx"]["expected"]
            names = re.findall("'(.*?)'", expected)
            hint = did_you_mean(value, names) if isinstance(value, str) else ""
            return f"must be {expected}, not {quoted(value)}{hint}"
    return f"{details['msg'].replace('Input should be', 'must be')}, not {quoted(value)}"
