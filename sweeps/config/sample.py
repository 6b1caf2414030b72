"""`sample`: points drawn from a box of parameters, as linked values of `cases`."""

from __future__ import annotations

from typing import Annotated, ClassVar, Self

import numpy as np
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
from sweeps.config.axes import Count, Pair
from sweeps.config.group import Group
from sweeps.config.numbers import full_name


class Logarithmic(Group):
    """A range that is drawn evenly in the logarithm."""

    example: ClassVar[str] = "{log: [low, high]}"

    log: Pair | None = Field(None, description="a range, drawn evenly in the logarithm")


class Named(Logarithmic):
    """A distribution by its name."""

    uniform: Pair | None = Field(None, description="a range")
    normal: Pair | None = Field(None, description="mean and standard deviation")
    lognormal: Pair | None = Field(
        None, description="median, and standard deviation of the logarithm"
    )


_PAIR = TypeAdapter(Pair)


def _distribution(written: object) -> Distribution:
    """Return a distribution as it was written; raises ValueError."""
    kind, numbers = as_written(written)
    if not isinstance(numbers, list) or len(numbers) != 2:
        raise ValueError(f"must be {FORMS}")
    if isinstance(written, dict):
        numbers = getattr(Named.model_validate(written), kind)
    return distribution(kind, *_PAIR.validate_python(numbers))


class Sample(Group):
    """Points drawn from a box, as linked values; NAME: [low, high], or a named distribution."""

    model_config = ConfigDict(extra="allow")

    example: ClassVar[str] = (
        "{sobol: 1024, seed: 1, temperature: [150, 320], spring_stiffness: {log: [500, 1e4]}}"
    )

    # The parameters, by their full names.
    __pydantic_extra__: dict[
        Annotated[str, AfterValidator(lambda key: full_name(key, *Sample.model_fields))],
        Annotated[
            Distribution,
            PlainValidator(_distribution, json_schema_input_type=Pair | Logarithmic | Named),
        ],
    ]

    sobol: Count | None = Field(
        None, description="points of a scrambled Sobol sequence, best a power of 2"
    )
    latin_hypercube: Count | None = Field(None, description="points of a Latin hypercube")
    seed: int = Field(0, ge=0, description="seed of the random numbers")

    @model_validator(mode="after")
    def _is_complete(self) -> Self:
        if (self.sobol is None) == (self.latin_hypercube is None) or not self.written:
            needed = "sobol or latin_hypercube, and parameters"
            raise ValueError(f"needs {needed}; write {self.example}")
        return self

    @property
    def written(self) -> dict[str, Distribution]:
        """The distribution of each parameter, as it was written."""
        return self.__pydantic_extra__

    @property
    def ranges(self) -> dict[str, Distribution]:
        """The distribution of each parameter, within the values that it may have."""
        return {name: of_parameter(drawn, name) for name, drawn in self.written.items()}

    def cases(self) -> dict[str, tuple[float, ...]]:
        """Return the drawn values of each parameter."""
        from scipy.stats import qmc

        width, rng = len(self.written), np.random.default_rng(self.seed)
        if self.sobol:
            # A longer sequence begins with the shorter one: a sweep that grows keeps its points.
            power = (self.sobol - 1).bit_length()
            unit = qmc.Sobol(width, rng=rng).random_base2(power)[: self.sobol]
        else:
            unit = qmc.LatinHypercube(width, rng=rng).random(self.latin_hypercube)
        return {
            name: tuple(r.values(unit[:, i]).tolist())
            for i, (name, r) in enumerate(self.ranges.items())
        }

    def __str__(self) -> str:
        """Return how the points were drawn, for the file."""
        way = f"sobol {self.sobol}" if self.sobol else f"latin_hypercube {self.latin_hypercube}"
        ranges = [f"{name} {drawn}" for name, drawn in self.written.items()]
        return ", ".join([way, f"seed {self.seed}", *ranges])
