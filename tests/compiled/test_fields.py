"""Generated makers of tuples: no field is forgotten, and literals are exact."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pytest

from stickslip.compiled import fields
from stickslip.compiled.decorators import jit
from stickslip.parameters import ParameterValues


class Pair(NamedTuple):
    a: float
    b: float


def maker(**values: str | float) -> Any:
    return fields.make_tuple_maker(Pair, "x, y", values, {})


# --- forgotten and unknown fields ----------------------------------------------------------------


@pytest.mark.parametrize(
    ("values", "named"),
    [({"a": "x"}, "b"), ({"a": "x", "b": "y", "c": 1.0}, "c"), ({"a": "x", "d": "y"}, "b, d")],
    ids=["forgotten", "unknown", "both"],
)
def test_a_forgotten_or_unknown_field_is_an_error_when_the_maker_is_made(
    values: dict[str, Any], named: str
) -> None:
    with pytest.raises(TypeError, match=f"^Pair: .* {named}$"):
        maker(**values)


# --- expressions and literals --------------------------------------------------------------------


def multiplications(make: Any) -> int:
    """Count the multiplications in the machine code of x times the first field."""

    @jit
    def product(x: float, y: float) -> float:
        return x * make(x, y).a

    product(1.0, 2.0)
    (text,) = product.alone.inspect_llvm().values()
    return text.count("fmul")


def test_a_number_becomes_a_literal_that_the_compiler_uses() -> None:
    assert multiplications(maker(a="y", b="x")) > 0
    assert multiplications(maker(a=1.0, b="x")) == 0
    assert 0.5 in maker(a=0.5, b="x").py_func.__code__.co_consts


@pytest.mark.parametrize("value", [-2 / 3, 1 / 3, 1e-300, 1.7976931348623157e308, -0.0])
def test_a_literal_has_every_digit(value: float) -> None:
    made = maker(a=value, b="x")(1.0, 2.0).a
    assert np.float64(made).tobytes() == np.float64(value).tobytes()


def test_more_than_fifteen_choices_compile() -> None:
    # Numba allows no conditional among more than fifteen keyword arguments of one call.
    values = dict.fromkeys(ParameterValues._fields, "x if x > y else y")
    make = fields.make_tuple_maker(ParameterValues, "x, y", values, {})
    assert make(1.0, 2.0) == (2.0,) * len(ParameterValues._fields)


# --- names ---------------------------------------------------------------------------------------


def test_the_name_of_a_maker_depends_on_its_values_and_not_on_when_it_was_made() -> None:
    one, two, again = (maker(a=value, b="x").py_func.__qualname__ for value in (1.0, 2.0, 1.0))
    assert one == again != two
    assert one.startswith("make_Pair[")
