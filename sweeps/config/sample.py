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

from stickslip.boxes import Range
from sweeps.config.axes import Count, Pair
from sweeps.config.group import Group
from sweeps.config.numbers import full_name


class Logarithmic(Group):
    """A range that is drawn evenly in the logarithm."""

    example: ClassVar[str] = "{log: [low, high]}"

    log: Pair


_PAIR = TypeAdapter(Pair)


def _range(written: object) -> Range:
    """Return a range as it was written; raises ValueError."""
    logarithmic = isinstance(written, dict)
    ends = written.get("log") if isinstance(written, dict) else written
    if not isinstance(ends, list) or len(ends) != 2:
        raise ValueError("must be [low, high], or {log: [low, high]}")
    if logarithmic:
        ends = Logarithmic.model_validate(written).log
    low, high = _PAIR.validate_python(ends)
    if not low < high:
        raise ValueError(f"must rise from low to high, not from {low:g} to {high:g}")
    if logarithmic and low <= 0:
        raise ValueError(f"no logarithm leads from {low:g} to {high:g}: both must be above 0")
    return Range(low, high, logarithmic)


class Sample(Group):
    """Points drawn from a box, as linked values; NAME: [low, high] or {log: [low, high]}."""

    model_config = ConfigDict(extra="allow")

    example: ClassVar[str] = (
        "{sobol: 1024, seed: 1, temperature: [150, 320], spring_stiffness: {log: [500, 1e4]}}"
    )

    # The parameters, by their full names.
    __pydantic_extra__: dict[
        Annotated[str, AfterValidator(lambda key: full_name(key, *Sample.model_fields))],
        Annotated[Range, PlainValidator(_range, json_schema_input_type=Pair | Logarithmic)],
    ]

    sobol: Count | None = Field(
        None, description="points of a scrambled Sobol sequence, best a power of 2"
    )
    latin_hypercube: Count | None = Field(None, description="points of a Latin hypercube")
    seed: int = Field(0, ge=0, description="seed of the random numbers")

    @model_validator(mode="after")
    def _is_complete(self) -> Self:
        if (self.sobol is None) == (self.latin_hypercube is None) or not self.ranges:
            needed = "sobol or latin_hypercube, and parameters"
            raise ValueError(f"needs {needed}; write {self.example}")
        return self

    @property
    def ranges(self) -> dict[str, Range]:
        """The range of each parameter."""
        return self.__pydantic_extra__

    def cases(self) -> dict[str, tuple[float, ...]]:
        """Return the drawn values of each parameter."""
        from scipy.stats import qmc

        width, rng = len(self.ranges), np.random.default_rng(self.seed)
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
        ranges = [f"{name} {drawn}" for name, drawn in self.ranges.items()]
        return ", ".join([way, f"seed {self.seed}", *ranges])
