"""`sample`: points drawn from a box of parameters, which become linked values of `cases`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, ClassVar, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import (
    AfterValidator,
    ConfigDict,
    Field,
    PlainValidator,
    TypeAdapter,
    model_validator,
)

from stickslip.distributions import (
    FORMS,
    Distribution,
    as_written,
    distribution,
    of_parameter,
)
from sweeps.config.axis_values import Count, Pair
from sweeps.config.group import Group
from sweeps.config.numbers import Text, full_name
from sweeps.config.written_config import UNREADABLE, Document, quoted
from sweeps.fitted import Fitted, fitted_parameters
from sweeps.paths import expanded


class Logarithmic(Group):
    """A range sampled evenly in the logarithm."""

    example: ClassVar[str] = "{log: [low, high]}"

    log: Pair | None = Field(None, description="a range, sampled evenly in the logarithm")


class Named(Logarithmic):
    """A distribution given by name."""

    uniform: Pair | None = Field(None, description="a range")
    normal: Pair | None = Field(None, description="mean and standard deviation")
    lognormal: Pair | None = Field(
        None, description="median, and standard deviation of the logarithm"
    )


_PAIR = TypeAdapter(Pair)


def _distribution(written: object) -> Distribution:
    """Return a distribution from its form in the config; raises ValueError."""
    kind, numbers = as_written(written)
    if not isinstance(numbers, list) or len(numbers) != 2:
        raise ValueError(f"must be {FORMS}")
    if isinstance(written, dict):
        numbers = getattr(Named.model_validate(written), kind)
    return distribution(kind, *_PAIR.validate_python(numbers))


def _fitted(read: object) -> Fitted | None:
    """Return the parameters of a fit read by `read_fit`; raises ValueError for anything else."""
    if read is None or isinstance(read, Fitted):
        return read
    raise ValueError(f"must be the name of a file that `stickslip fit` wrote, not {quoted(read)}")


class Sample(Group):
    """Points drawn from a box, as linked values. NAME: [low, high], or a named distribution."""

    model_config = ConfigDict(extra="allow")

    example: ClassVar[str] = (
        "{sobol: 1024, seed: 1, temperature: [150, 320], spring_stiffness: {log: [500, 1e4]}}"
    )

    # The parameters, by full name.
    __pydantic_extra__: dict[
        Annotated[str, AfterValidator(lambda key: full_name(key, *Sample.written_keys()))],
        Annotated[
            Distribution,
            PlainValidator(_distribution, json_schema_input_type=Pair | Logarithmic | Named),
        ],
    ]

    sobol: Count | None = Field(
        None,
        description="number of points of a scrambled Sobol sequence, preferably a power of 2",
    )
    latin_hypercube: Count | None = Field(None, description="number of points of a Latin hypercube")
    seed: int = Field(0, ge=0, description="seed of the random numbers")
    fitted: Annotated[
        Fitted | None, PlainValidator(_fitted, json_schema_input_type=Text | None)
    ] = Field(
        None,
        alias="from",
        description="a file of `stickslip fit`: its free parameters are drawn jointly from a "
        "normal distribution with the covariance of the fit; a relative path starts in the folder "
        "of the config, and `~` and `$NAME` are allowed as in `output`",
    )

    @model_validator(mode="after")
    def _is_complete(self) -> Self:
        has_one_way = (self.sobol is None) != (self.latin_hypercube is None)
        if not has_one_way or not (self.written or self.fitted):
            needs = "needs exactly one of sobol and latin_hypercube, and parameters"
            raise ValueError(f"{needs}; write {self.example}")
        return self

    @property
    def written(self) -> dict[str, Distribution]:
        """The distribution of each parameter as written."""
        return self.__pydantic_extra__

    @property
    def ranges(self) -> dict[str, Distribution]:
        """The distribution of each parameter, restricted to its valid values."""
        return {name: of_parameter(drawn, name) for name, drawn in self.written.items()}

    def cases(self) -> dict[str, tuple[float, ...]]:
        """Return the drawn values of each parameter.

        Sets with invalid values of the parameters of a fit are left out, which truncates the
        distribution.
        """
        unit = self._unit()
        drawn = {name: r.values(unit[:, i]) for i, (name, r) in enumerate(self.ranges.items())}
        if self.fitted:
            joint = self.fitted.joint
            sets = joint.values(unit[:, len(drawn) :])
            drawn |= dict(zip(joint.names, sets.T, strict=True))
            possible = joint.are_possible(sets)
            drawn = {name: values[possible] for name, values in drawn.items()}
        return {name: tuple(values.tolist()) for name, values in drawn.items()}

    def _unit(self) -> NDArray[np.float64]:
        """Return the sampled points (n, parameters) in [0, 1)."""
        from scipy.stats import qmc

        width = len(self.written) + (len(self.fitted.joint.names) if self.fitted else 0)
        rng = np.random.default_rng(self.seed)
        if self.sobol:
            # A longer sequence begins with the shorter one, so a growing sweep keeps its points.
            power = (self.sobol - 1).bit_length()
            return np.asarray(qmc.Sobol(width, rng=rng).random_base2(power)[: self.sobol])
        return np.asarray(qmc.LatinHypercube(width, rng=rng).random(self.latin_hypercube))

    def __str__(self) -> str:
        """Return a description of the draw for the result file."""
        way = f"sobol {self.sobol}" if self.sobol else f"latin_hypercube {self.latin_hypercube}"
        ranges = [f"{name} {drawn}" for name, drawn in self.written.items()]
        description = ", ".join([way, f"seed {self.seed}", *ranges])
        if self.fitted is None:
            return description
        kept = len(next(iter(self.cases().values())))
        left_out = (self.sobol or self.latin_hypercube or 0) - kept
        invalid = f"; sets left out as invalid: {left_out}" if left_out else ""
        return f"{description}, {self.fitted}{invalid}"


def read_fit(document: Document, folder: Path) -> None:
    """Replace the name of the file of a fit by the parameters in it; refuse a wrong file."""
    sample = document.section("sample")
    name = sample.get("from")
    if not isinstance(name, str):
        return
    try:
        sample["from"] = fitted_parameters(folder / expanded(name), name)
    except ValueError as error:
        document.refuse(str(error), "sample", "from")
        sample["from"] = UNREADABLE
