"""Makers of tuples written from a declaration: nothing is forgotten, literals are literal."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pytest

from stickslip.compiled import fields
from stickslip.compiled.decorators import inline, jit
from stickslip.parameters import Parameters, ParameterValues


class Pair(NamedTuple):
    a: float
    b: float


def maker(**values: str | float) -> Any:
    return fields.make_tuple_maker(Pair, "x, y", values, {})


# --- what is forgotten or unknown ----------------------------------------------------------------


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


def test_each_field_gets_its_own_expression_whatever_the_order_of_the_table() -> None:
    assert maker(a="x + y", b="x - y")(3.0, 1.0) == Pair(4.0, 2.0)
    assert maker(b="x - y", a="x + y")(3.0, 1.0) == Pair(4.0, 2.0)


def test_expressions_may_use_what_they_are_given() -> None:
    @inline
    def twice(x: float) -> float:
        return 2.0 * x

    values = {"a": "twice(x)", "b": "half * x"}
    make = fields.make_tuple_maker(Pair, "x", values, {"twice": twice, "half": 0.5})
    assert make(3.0) == Pair(6.0, 1.5)


def multiplications(make: Any) -> int:
    """Multiplications in the machine's language of x times the first field."""

    @jit
    def product(x: float, y: float) -> float:
        return x * make(x, y).a

    product(1.0, 2.0)
    (text,) = product.alone.inspect_llvm().values()
    return text.count("fmul")


def test_a_number_is_written_as_a_literal_that_the_compiler_makes_use_of() -> None:
    assert multiplications(maker(a="y", b="x")) > 0
    assert multiplications(maker(a=1.0, b="x")) == 0
    assert 0.5 in maker(a=0.5, b="x").py_func.__code__.co_consts


@pytest.mark.parametrize("value", [-2 / 3, 1 / 3, 1e-300, 1.7976931348623157e308, -0.0])
def test_a_literal_has_every_digit(value: float) -> None:
    made = maker(a=value, b="x")(1.0, 2.0).a
    assert np.float64(made).tobytes() == np.float64(value).tobytes()


def test_more_than_fifteen_choices_compile() -> None:
    # Numba takes no choice among more than fifteen keyword arguments of one call.
    values = dict.fromkeys(ParameterValues._fields, "x if x > y else y")
    make = fields.make_tuple_maker(ParameterValues, "x, y", values, {})
    assert make(1.0, 2.0) == (2.0,) * len(ParameterValues._fields)


# --- names ---------------------------------------------------------------------------------------


def test_the_name_of_a_maker_tells_what_it_writes_and_not_when_it_was_made() -> None:
    one, two, again = (maker(a=value, b="x").py_func.__qualname__ for value in (1.0, 2.0, 1.0))
    assert one == again != two
    assert one.startswith("make_Pair[")


# --- the other makers ----------------------------------------------------------------------------


def test_a_row_is_read_in_the_order_of_the_fields() -> None:
    p = Parameters(temperature=310.0, drive_amplitude=-1e-6)
    values = fields.make_row_reader(ParameterValues)(np.array(p))
    assert type(values) is ParameterValues
    assert values == tuple(p)
    longer = np.concatenate([p, [7.0]])  # a row may hold more behind
    assert fields.make_row_reader(ParameterValues)(longer) == tuple(p)


def test_a_lane_is_read_from_its_slots() -> None:
    @inline
    def get(lanes: np.ndarray, slot: int, lane: int) -> float:
        return lanes[slot, lane]

    table = np.arange(24.0).reshape(6, 4)
    assert fields.make_lane_reader(Pair, 3, get)(table, 2) == Pair(table[3, 2], table[4, 2])


def test_a_map_returns_its_components_also_a_single_one() -> None:
    assert fields.make_map("pair", "x", ["x", "x * x"], {})(3.0) == (3.0, 9.0)
    assert fields.make_map("single", "x", ["x + one"], {"one": 1.0})(3.0) == (4.0,)


def test_a_function_has_its_lines_and_its_name() -> None:
    function = fields.make_function("sum of squares", "x, y", ["s = x * x", "return s + y * y"], {})
    assert function(3.0, 4.0) == 25.0
    assert function.py_func.__qualname__ == "sum of squares"
