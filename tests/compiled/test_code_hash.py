"""The hash of functions changes with their behaviour, and with nothing else."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numba
import pytest

from stickslip.compiled.code_hash import code_hash
from stickslip.compiled.decorators import inline

SOURCE = """
import math

SIZE = 2.0

def helper(u):
    return math.sqrt(u) * SIZE

def law(p, u, factor=3.0):
    return helper(u) * factor + 1.0
"""


def hash_of(source: str, name: str = "law", around: Callable[[Any], Any] = lambda f: f) -> str:
    names: dict[str, Any] = {"__name__": "__main__"}
    exec(source, names)
    return code_hash([around(names[name])])


@pytest.mark.parametrize(
    ("text", "other"),
    [
        ("SIZE = 2.0", "SIZE = 2.5"),
        ("SIZE = 2.0", "SIZE = 2"),
        ("sqrt", "cbrt"),
        ("factor=3.0", "factor=4.0"),
        ("+ 1.0", "- 1.0"),
        ("+ 1.0", "+ 1.5"),
        ("helper(u) *", "helper(-u) *"),
    ],
)
def test_any_change_of_behaviour_changes_the_hash(text: str, other: str) -> None:
    assert text in SOURCE
    assert hash_of(SOURCE.replace(text, other)) != hash_of(SOURCE)


def test_the_place_and_the_compiler_of_code_do_not_change_the_hash() -> None:
    moved = "# elsewhere\n\nOTHER = [1]\n" + SOURCE
    assert hash_of(moved) == hash_of(SOURCE)
    assert hash_of(SOURCE, around=inline) == hash_of(SOURCE, around=numba.njit) == hash_of(SOURCE)


@pytest.mark.parametrize("flags", ["fastmath=True", "fastmath={'contract', 'arcp', 'nnan'}"])
def test_the_flags_of_a_called_function_count(flags: str) -> None:
    def compiled(flags: str) -> str:
        return SOURCE.replace("def helper", f"import numba\n\n@numba.njit({flags})\ndef helper")

    assert hash_of(compiled(flags)) == hash_of(compiled(flags)) != hash_of(compiled(""))


def test_closures_count() -> None:
    def law_of(size: float) -> Callable[[float], float]:
        return lambda u: size * math.sqrt(u)

    assert code_hash([law_of(1.0)]) == code_hash([law_of(1.0)]) != code_hash([law_of(2.0)])


def test_it_counts_which_of_two_functions_a_third_name_means() -> None:
    def law_of(wet: Callable[[float], float]) -> Callable[[float], float]:
        return lambda u: cold(u) + warm(u) + wet(u)

    def cold(u: float) -> float:
        return math.sqrt(u)

    def warm(u: float) -> float:
        return math.cbrt(u)

    assert code_hash([law_of(cold)]) == code_hash([law_of(cold)]) != code_hash([law_of(warm)])


@pytest.mark.parametrize("value", ["[1.0]", "{}", "__import__('json')", "object()"])
def test_a_reference_that_may_change_unnoticed_is_refused_by_name(value: str) -> None:
    with pytest.raises(TypeError, match=r"`SIZE`, to which helper refers, is of type"):
        hash_of(SOURCE.replace("SIZE = 2.0", f"SIZE = {value}"))
