"""Makes stickslip/declared.pyi: `python docs/declared.py`.

The names of parameters and results, which the registry declares, as type checkers and editors see
them.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from stickslip.variables import GREEK, PARAMETERS, RESULTS, Variable

STUB = Path(__file__).parents[1] / "stickslip" / "declared.pyi"

_OWN_TYPES = {"status": "Status", "regime": "Regime"}
_TYPES = {"f8": "float", "i4": "int", "i1": "int"}


def stub() -> str:
    """Return the text of the stub."""
    return "\n".join([*_head(), *_parameters(), "", *_orbit(), ""])


def _head() -> Iterator[str]:
    yield '"""Types of the names in `variables`. Made by `make generated`; do not edit."""'
    yield ""
    yield "from typing import Any, ClassVar, Self"
    yield ""
    yield "from stickslip.regime import Regime"
    yield "from stickslip.status import Status"
    yield ""


def _parameters() -> Iterator[str]:
    names = list(PARAMETERS)
    symbols = [spelling for name in names for spelling in _spellings(PARAMETERS[name].symbol)]
    defaults = [f"{name}: float = {PARAMETERS[name].default!r}" for name in names]
    others = [f"{symbol}: float = ..." for symbol in symbols]
    changes = [f"{name}: float = ..." for name in (*names, *symbols)]
    yield "class ParameterValues(tuple[float, ...]):"
    yield "    _fields: ClassVar[tuple[str, ...]]"
    yield "    def __new__(cls, *args: Any, **kwargs: Any) -> Self: ..."
    yield "    def _asdict(self) -> dict[str, float]: ..."
    for variable in PARAMETERS.values():
        yield from _property(variable, "float")
    yield ""
    yield "class TypedParameters(ParameterValues):"
    yield from _method("__new__", ["cls", *defaults, "*", *others])
    yield from _method("_replace", ["self", "*", *changes])


def _orbit() -> Iterator[str]:
    yield "class TypedOrbit(tuple[Any, ...]):"
    yield "    _fields: ClassVar[tuple[str, ...]]"
    yield "    def __new__(cls, *args: Any, **kwargs: Any) -> Self: ..."
    yield "    def _asdict(self) -> dict[str, Any]: ..."
    yield "    def _replace(self, **kwargs: Any) -> Self: ..."
    for variable in RESULTS.values():
        yield from _property(variable, _OWN_TYPES.get(variable.name, _TYPES[variable.dtype]))
    yield "    @property"
    yield "    def state(self) -> tuple[float, ...]: ..."


def _spellings(symbol: str) -> Iterator[str]:
    yield symbol
    letter, _, index = symbol.partition("_")
    if letter in GREEK:
        yield GREEK[letter] + (f"_{index}" if index else "")


def _method(name: str, arguments: list[str]) -> Iterator[str]:
    yield f"    def {name}("
    yield from (f"        {argument}," for argument in arguments)
    yield "    ) -> Self: ..."


def _property(variable: Variable, kind: str) -> Iterator[str]:
    yield "    @property"
    yield f"    def {variable.name}(self) -> {kind}:"
    yield f'        """{variable.meaning}, {variable.symbol} [{variable.unit or 1}]"""'


if __name__ == "__main__":
    STUB.write_text(stub(), encoding="utf-8")
