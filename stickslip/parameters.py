"""The parameters of the model: one NamedTuple of floats that goes straight through compiled code.

Units, symbols and valid ranges stand in `variables.PARAMETERS`; the defaults are those of the
paper's Fig. 3.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple, Self

from stickslip.variables import PARAMETERS


class ParameterValues(NamedTuple):
    """The bare values, unchecked: what compiled code makes of a row of numbers."""

    temperature: float = 200.0
    viscosity_coefficient: float = 5e4
    spring_stiffness: float = 3000.0
    rheological_index: float = -2 / 3
    angular_frequency: float = 10.0
    drive_amplitude: float = 0.8e-6
    block_mass: float = 0.4
    initial_displacement: float = 0.0
    initial_velocity: float = 0.0
    initial_order_parameter: float = 0.0
    film_thickness: float = 1e-9
    strain_relaxation_time: float = 1e-8
    contact_area: float = 0.6e-9
    kinetic_coefficient: float = 100.0
    thermal_coefficient: float = 0.95
    critical_temperature: float = 290.0
    elastic_coefficient: float = 4e12
    cubic_coefficient: float = 230.0
    quartic_coefficient: float = 850.0
    noise_intensity: float = 1e-18


class ParameterError(ValueError):
    """A parameter has a value outside its valid range; the message names each one."""


class Parameters(ParameterValues):
    """The twenty parameters in SI units; the defaults are the paper's Fig. 3.

    Every value is turned into a float (one compiled specialisation) and checked against the
    ranges of `variables.PARAMETERS`, also by `_replace`.

    Raises
    ------
    ParameterError
        A value is not a number or lies outside its valid range.
    """

    __slots__ = ()

    def __new__(cls, *args: float, **kwargs: float) -> Self:  # noqa: D102 - see the class
        values = [
            _as_float(*item)
            for item in zip(cls._fields, ParameterValues(*args, **kwargs), strict=True)
        ]
        complaints = [
            f"{name} {complaint}"
            for (name, variable), value in zip(PARAMETERS.items(), values, strict=True)
            if (complaint := variable.complaint(value))
        ]
        if complaints:
            raise ParameterError("; ".join(complaints))
        return super().__new__(cls, *values)

    @classmethod
    def _make(cls, iterable: Iterable[Any]) -> Self:  # type: ignore[override]
        return cls(*ParameterValues._make(iterable))  # refuses a wrong number of values

    def _replace(self, **changes: float) -> Self:
        return type(self)(**{**self._asdict(), **changes})


def _as_float(name: str, value: Any) -> float:
    if isinstance(value, (str, bytes, bool)):
        raise ParameterError(f"{name} must be a number, not {value!r}")
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        raise ParameterError(f"{name} must be a number, not {value!r}") from None
