"""The parameters of the model, with checks of their values.

`variables.ParameterValues` declares them.
"""

from __future__ import annotations

import inspect
from collections.abc import Iterable
from contextlib import suppress
from typing import Any, Self, Unpack

from stickslip.tables import value_table
from stickslip.variables import (
    ENERGY_COEFFICIENTS,
    PARAMETERS,
    ParameterKeywords,
    full_names,
    unbounded,
)
from stickslip.variables import ParameterValues as ParameterValues


class ParameterError(ValueError):
    """Parameters are outside their valid ranges; the message names each one.

    >>> Parameters(temperature=-1)
    Traceback (most recent call last):
    stickslip.parameters.ParameterError: temperature must be at least 0, not -1.0
    """


class Parameters(ParameterValues):
    """The parameters of the model in SI units; the defaults are the paper's Fig. 3.

    Parameters are given by name or by the paper's symbol. Every value is converted to a float (so
    that kernels need one compiled specialisation) and checked against its range, in `_replace` too.

    >>> film = Parameters(temperature=250, k=1e5)
    >>> film.viscosity_coefficient
    100000.0
    >>> film._replace(γ=-0.5).rheological_index
    -0.5

    Raises
    ------
    ParameterError
        A value is not a number or lies outside its valid range.
    TypeError
        A name is unknown, or a parameter is given twice.
    """

    __slots__ = ()

    # For the help (Shift-Tab) and the completion of a notebook.
    __signature__ = inspect.Signature(
        [
            inspect.Parameter(
                name,
                inspect.Parameter.POSITIONAL_OR_KEYWORD,
                default=known.default,
                annotation=float,
            )
            for name, known in PARAMETERS.items()
        ]
    )

    def __new__(cls, *args: float, **kwargs: Unpack[ParameterKeywords]) -> Self:
        """Check and convert the values."""
        return super().__new__(cls, *_checked(args, dict(kwargs)))

    def _replace(self, **changes: Unpack[ParameterKeywords]) -> Self:
        return type(self)(*(self._asdict() | full_names(changes)).values())

    @classmethod
    def _make(cls, iterable: Iterable[Any]) -> Self:  # type: ignore[override]
        values = tuple(iterable)
        if len(values) != len(cls._fields):
            raise TypeError(f"expected {len(cls._fields)} values, not {len(values)}")
        return cls(*values)

    def _repr_html_(self) -> str:
        values = self._asdict()
        changed = [name for name, value in values.items() if value != PARAMETERS[name].default]
        return value_table(values, PARAMETERS, bold=changed)


Parameters.__doc__ = f"{Parameters.__doc__}\n    Parameters\n    ----------\n" + "".join(
    f"    {name} : float\n"
    f"        {known.meaning}, {known.symbol} [{known.unit or 1}], by default {known.default:g}\n"
    for name, known in PARAMETERS.items()
)


def given_or_default(parameters: Parameters | None) -> Parameters:
    """Return an argument `parameters`, or the default for None; raises TypeError for others."""
    if parameters is None:
        return Parameters()
    if not isinstance(parameters, Parameters):
        raise TypeError(
            f"parameters must be a Parameters object, such as Parameters(temperature=250), "
            f"not {parameters!r}"
        )
    return parameters


def _checked(args: tuple[Any, ...], kwargs: dict[str, Any]) -> list[float]:
    """Return the values of all parameters; raises TypeError, ParameterError."""
    names = ParameterValues._fields
    if len(args) > len(names):
        raise TypeError(f"there are {len(names)} parameters, not {len(args)}")
    given = dict(zip(names, args, strict=False))
    named = full_names(kwargs)
    if twice := [name for name in named if name in given]:
        raise TypeError(f"{', '.join(twice)} is given twice, by position and by name")
    given |= named
    values = {
        name: as_float(name, given.get(name, known.default)) for name, known in PARAMETERS.items()
    }
    complaints = [
        f"{name} {complaint}"
        for name, variable in PARAMETERS.items()
        if (complaint := variable.complaint(values[name]))
    ]
    if not complaints and (growth := unbounded(*(values[n] for n in ENERGY_COEFFICIENTS))):
        complaints.append(f"{growth}: otherwise the order parameter grows without bound")
    if complaints:
        raise ParameterError("; ".join(complaints))
    return list(values.values())


def as_float(name: str, value: Any) -> float:
    """Return a value of a parameter as a float; raises ParameterError for text and the like."""
    truth = isinstance(value, bool) or str(getattr(value, "dtype", "")) == "bool"
    if not truth and not isinstance(value, (str, bytes)):
        with suppress(TypeError, ValueError, OverflowError):
            return float(value)
    raise ParameterError(f"{name} must be a number, not {value!r}")
