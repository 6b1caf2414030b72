"""The parameters of the model: a NamedTuple of floats that compiled code takes as it is.

Names, units, defaults and valid ranges are declared in `variables.PARAMETERS`.
"""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Iterable
from difflib import get_close_matches
from typing import TYPE_CHECKING, Any, ClassVar, Self

from stickslip.tables import value_table
from stickslip.variables import ENERGY_COEFFICIENTS, PARAMETERS, unbounded

if TYPE_CHECKING:

    class ParameterValues(tuple[float, ...]):
        """The bare values, unchecked, as compiled code makes them from a row of numbers."""

        _fields: ClassVar[tuple[str, ...]]

        def __new__(cls, *args: Any, **kwargs: Any) -> Self: ...  # noqa: D102 - a stub
        def __getattr__(self, name: str) -> float: ...
        def _asdict(self) -> dict[str, float]: ...

else:
    # No defaults: compiled code that forgets a parameter does not compile.
    ParameterValues = namedtuple("ParameterValues", PARAMETERS, module=__name__)


class ParameterError(ValueError):
    """A parameter has a value outside its valid range; the message names each one."""


class Parameters(ParameterValues):
    """The parameters of the model in SI units; the defaults are the paper's Fig. 3.

    Every value is converted to a float (one compiled specialisation) and checked against the
    ranges of `variables.PARAMETERS`, also by `_replace`.

    Raises
    ------
    ParameterError
        A value is not a number or lies outside its valid range.
    TypeError
        No parameter has this name.
    """

    __slots__ = ()

    def __new__(cls, *args: float, **kwargs: float) -> Self:  # noqa: D102 - see the class
        refuse_unknown(kwargs)
        defaults = {name: PARAMETERS[name].default for name in cls._fields[len(args) :]}
        arguments = ParameterValues(*args, **(defaults | kwargs))
        values = [_as_float(*item) for item in zip(cls._fields, arguments, strict=True)]
        complaints = [
            f"{name} {complaint}"
            for (name, variable), value in zip(PARAMETERS.items(), values, strict=True)
            if (complaint := variable.complaint(value))
        ]
        by_name = dict(zip(cls._fields, values, strict=True))
        if not complaints and (growth := unbounded(*(by_name[n] for n in ENERGY_COEFFICIENTS))):
            complaints.append(f"{growth}: the order parameter would grow without bound")
        if complaints:
            raise ParameterError("; ".join(complaints))
        return super().__new__(cls, *values)

    @classmethod
    def _make(cls, iterable: Iterable[Any]) -> Self:
        values = tuple(iterable)
        if len(values) != len(cls._fields):
            raise TypeError(f"expected {len(cls._fields)} values, not {len(values)}")
        return cls(*values)

    def _replace(self, **changes: float) -> Self:
        return type(self)(**{**self._asdict(), **changes})

    def _repr_html_(self) -> str:
        values = self._asdict()
        changed = [name for name, value in values.items() if value != PARAMETERS[name].default]
        return value_table(values, PARAMETERS, bold=changed)


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


def refuse_unknown(names: Iterable[str]) -> None:
    """Raise TypeError where a name is not that of a parameter, with the one that may be meant."""
    for name in names:
        if name not in PARAMETERS:
            by_symbol = [full for full, known in PARAMETERS.items() if known.symbol == name]
            near = by_symbol or get_close_matches(name, PARAMETERS, n=1)
            hint = f"; did you mean {near[0]!r}?" if near else ""
            raise TypeError(f"Parameters has no parameter {name!r}{hint}")


def _as_float(name: str, value: Any) -> float:
    if isinstance(value, (str, bytes, bool)):
        raise ParameterError(f"{name} must be a number, not {value!r}")
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        raise ParameterError(f"{name} must be a number, not {value!r}") from None
