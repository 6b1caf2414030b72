"""The machine code of the loops over lanes consists of vector instructions.

A loop that the compiler could not vectorise gives the same numbers, but is six times slower.
"""

from __future__ import annotations

import platform
import re
from typing import Any

import llvmlite.binding as llvm
import pytest
from numba import types
from support.points import GAMMAS

from stickslip.kernels.adaptive import recording
from stickslip.kernels.adaptive.kicks import make_kick
from stickslip.kernels.adaptive.passes import make_problems
from stickslip.kernels.adaptive.recording import ROOM
from stickslip.kernels.adaptive.variations import make_variations
from stickslip.kernels.families import Family
from stickslip.kernels.problem import problem_functions
from stickslip.model.models import model_of
from stickslip.numerics.adaptive_lanes import make_attempt
from stickslip.numerics.linear import algebra
from stickslip.numerics.tableaus import RODAS4P2
from stickslip.options import DEFAULTS

pytestmark = pytest.mark.skipif(
    platform.machine().lower() not in ("x86_64", "amd64")
    or not llvm.get_host_cpu_features().get("avx2"),
    reason="this test understands only the assembly of machines with AVX2",
)

_PACKED = re.compile(r"\tv(?:mul|add|sub|div|sqrt|fn?m(?:add|sub)\d+)pd\b")
_SCALAR = re.compile(r"\tv?(?:mul|add|sub|div|sqrt|fn?m(?:add|sub)\d+)sd\b")
_END_OF_FUNCTION = re.compile(r"^\.Lfunc_end\d+:", re.MULTILINE)


def assembly(function: Any) -> str:
    """Return the assembly of a function of an array of lanes."""
    function.alone.compile((types.float64[::1],))
    (text,) = function.alone.inspect_asm().values()
    return text


def body(text: str) -> str:
    """Return the function with the most arithmetic; the others are wrappers for the interpreter.

    The compiler knows the number of lanes, so it may unroll the loop completely.
    """
    parts = _END_OF_FUNCTION.split(text)
    return max(parts, key=lambda part: len(_PACKED.findall(part) + _SCALAR.findall(part)))


def assert_vectors(text: str, least: int) -> None:
    found = body(text)
    packed, scalar = _PACKED.findall(found), _SCALAR.findall(found)
    assert not scalar, f"{len(scalar)} scalar instructions beside {len(packed)} packed ones"
    assert len(packed) >= least
    assert "\tcall" not in found


FUNCTIONS = problem_functions(DEFAULTS.physics)


def problems_of(gamma: float | None) -> Any:
    """Return the function that reads the problem of a lane for one family of fluids."""
    return make_problems(Family(DEFAULTS.physics, gamma))


@pytest.mark.stress
@pytest.mark.parametrize("gamma", [*GAMMAS, None])
def test_an_attempt_in_lanes_is_packed(gamma: float | None) -> None:
    rhs, jacobian, weight = FUNCTIONS.rhs, FUNCTIONS.jacobian, FUNCTIONS.error_weight
    problems = problems_of(gamma)
    attempt = make_attempt(
        rhs, jacobian, weight, problems, RODAS4P2, algebra(FUNCTIONS.width), ROOM
    )
    assert_vectors(assembly(attempt), 500)


@pytest.mark.stress
@pytest.mark.parametrize("gamma", [*GAMMAS, None])
def test_a_measurement_in_lanes_is_packed(gamma: float | None) -> None:
    see = recording.make_see(problems_of(gamma), FUNCTIONS, two_solids=False)
    assert_vectors(assembly(see), 200)


@pytest.mark.stress
@pytest.mark.parametrize("gamma", [*GAMMAS, None])
def test_the_variational_equations_in_lanes_are_packed(gamma: float | None) -> None:
    components = model_of(DEFAULTS.physics).components
    carry = make_variations(problems_of(gamma), FUNCTIONS, components).carry
    assert_vectors(assembly(carry), 500)


@pytest.mark.stress
def test_the_noise_by_chance_in_lanes_is_packed() -> None:
    assert_vectors(assembly(make_kick(problems_of(0.0), FUNCTIONS.width)), 200)


def test_scalar_code_and_calls_are_detected() -> None:
    packed = "\tvmulpd\tx\n\tvfmadd231pd\ty\n"
    wrapper = ".Lfunc_end0:\n\tvmulsd\tz\n\tcallq\t*%rax\n.Lfunc_end1:\n"
    assert_vectors(packed + wrapper, 2)
    with pytest.raises(AssertionError, match="1 scalar instructions beside 2 packed"):
        assert_vectors(packed + "\tvaddsd\ty\n" + wrapper, 1)
    with pytest.raises(AssertionError):
        assert_vectors(packed + "\tcallq\tcos\n" + wrapper, 1)
    with pytest.raises(AssertionError):
        assert_vectors(packed + wrapper, 3)
