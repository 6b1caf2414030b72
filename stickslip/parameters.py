"""The parameters of the model: a NamedTuple of floats that compiled code takes as it is.

Names, units, defaults and valid ranges are declared in `variables.PARAMETERS`.
"""

from __future__ import annotations

import inspect
from collections import namedtuple
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, Self

from stickslip.tables import value_table
from stickslip.variables import ENERGY_COEFFICIENTS, PARAMETERS, full_names, unbounded

if TYPE_CHECKING:
    from stickslip.declared import ParameterValues as ParameterValues
    from stickslip.declared import TypedParameters
else:
    # No defaults: compiled code that forgets a parameter does not compile.
    ParameterValues = namedtuple("ParameterValues", PARAMETERS, module=__name__)
    TypedParameters = ParameterValues


class ParameterError(ValueError):
    """A parameter has a value outside its valid range; the message names each one.

    >>> Parameters(temperature=-1)
    Traceback (most recent call last):
    stickslip.parameters.ParameterError: temperature must be at least 0, not -1.0
    """


class Parameters(TypedParameters):
    """The parameters of the model in SI units; the defaults are the paper's Fig. 3.

    They are given by name or by the paper's symbol. Every value is converted to a float (one
    compiled specialisation) and checked against its valid range, also by `_replace`.

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
        No parameter has this name, or one is given twice.
    """

    __slots__ = ()

    if not TYPE_CHECKING:  # there, the names are those of `declared.pyi`

        def __new__(cls, *args: float, **kwargs: float) -> Self:
            """Check and convert the values."""
            return super().__new__(cls, *_checked(args, kwargs))

        def _replace(self, **changes: float) -> Self:
            return type(self)(**(self._asdict() | full_names(changes)))

    @classmethod
    def _make(cls, iterable: Iterable[Any]) -> Self:
        values = tuple(iterable)
        if len(values) != len(cls._fields):
            raise TypeError(f"expected {len(cls._fields)} values, not {len(values)}")
        return cls(*values)

    def _repr_html_(self) -> str:
        values = self._asdict()
        changed = [name for name, value in values.items() if value != PARAMETERS[name].default]
        return value_table(values, PARAMETERS, bold=changed)


def _describe() -> None:
    """Give `Parameters` the signature and the description that its registry declares."""
    one = inspect.Parameter.POSITIONAL_OR_KEYWORD
    signature = inspect.Signature(
        [
            inspect.Parameter(name, one, default=variable.default, annotation="float")
            for name, variable in PARAMETERS.items()
        ]
    )
    described = "".join(
        f"    {name} : float\n"
        f"        {variable.meaning}, {variable.symbol} [{variable.unit or 1}], "
        f"by default {variable.default:g}\n"
        for name, variable in PARAMETERS.items()
    )
    Parameters.__signature__ = signature  # type: ignore[attr-defined]
    section = f"Parameters\n    ----------\n{described}\n    Raises\n"
    Parameters.__doc__ = str(Parameters.__doc__).replace("Raises\n", section, 1)


_describe()


def given_or_default(parameters: Parameters | None) -> Parameters:
    """Return what an argument `parameters` means; raises TypeError where it is something else."""
    if parameters is None:
        return Parameters()
    if not isinstance(parameters, Parameters):
        raise TypeError(
            f"parameters must be Parameters, such as Parameters(temperature=250), "
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
        name: _as_float(name, given.get(name, known.default)) for name, known in PARAMETERS.items()
    }
    complaints = [
        f"{name} {complaint}"
        for name, variable in PARAMETERS.items()
        if (complaint := variable.complaint(values[name]))
    ]
    growth = None if complaints else unbounded(*(values[n] for n in ENERGY_COEFFICIENTS))
    if growth:
        complaints.append(f"{growth}: the order parameter would grow without bound")
    if complaints:
        raise ParameterError("; ".join(complaints))
    return list(values.values())


def _as_float(name: str, value: Any) -> float:
    if isinstance(value, (str, bytes, bool)):
        raise ParameterError(f"{name} must be a number, not {value!r}")
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        raise ParameterError(f"{name} must be a number, not {value!r}") from None
