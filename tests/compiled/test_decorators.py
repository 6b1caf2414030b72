"""The decorators and their flags; a kernel has one signature and one name."""

from __future__ import annotations

import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from support.package import run_python

from stickslip.compiled import decorators
from stickslip.kernels.parameter_rows import parameters_of
from stickslip.kernels.trajectories import start_kernel
from stickslip.model import drive
from stickslip.options import DEFAULTS, Options, Settings
from stickslip.parameters import Parameters

# --- flags ---------------------------------------------------------------------------------------


def test_no_function_is_compiled_with_flags_that_let_nan_pass() -> None:
    for compiler in (decorators.jit, decorators.inline):
        function = compiler(lambda error: error <= 1.0)
        assert not function(float("nan"))
        assert set(function.targetoptions["fastmath"]) <= {"contract", "arcp"}
    options = start_kernel(DEFAULTS.physics).targetoptions
    assert set(options["fastmath"]) <= {"contract", "arcp"}
    assert options["error_model"] == "numpy"
    assert options["nogil"]


def test_a_division_by_zero_is_infinite_and_raises_nothing() -> None:
    for compiler in (decorators.jit, decorators.inline):
        assert compiler(lambda x: 1.0 / x)(0.0) == np.inf


# --- signatures ----------------------------------------------------------------------------------


@decorators.kernel
def smallest(point: np.ndarray, settings: Settings) -> float:
    return drive.period(parameters_of(point)) * settings.rtol * settings.max_steps


def test_a_kernel_has_one_signature_for_all_parameters_and_settings() -> None:
    start = np.zeros(3)
    for parameters in (Parameters(), Parameters(rheological_index=0, temperature=310)):
        point = np.array(parameters)
        start_kernel(DEFAULTS.physics)(point, start)
        for options in (
            Options(rtol=1e-3),
            Options(rtol=np.float32(1e-3), max_steps=1e6, stationary_rtol=np.float32(1e-3)),
            Options(rtol=1e-2, max_steps=np.int64(10**6), accelerate=False),
        ):
            smallest(point, options.settings())
    assert len(smallest.signatures) == 1
    assert len(start_kernel(DEFAULTS.physics).signatures) == 1


# --- names ---------------------------------------------------------------------------------------


def make_constant(value: float):
    def constant() -> float:
        return value

    return constant


def test_a_kernel_is_named_by_its_module_and_function_or_by_its_factory() -> None:
    assert smallest.py_func.__qualname__ == f"{__name__}.smallest"
    named = decorators.named_kernel("tests: constant[1]", make_constant(1.0))
    assert named.py_func.__qualname__ == "tests: constant[1]"


def test_a_name_is_refused_the_second_time() -> None:
    decorators.named_kernel("tests: constant[2]", make_constant(2.0))
    with pytest.raises(ValueError, match=r"already a kernel called tests: constant\[2\]"):
        decorators.named_kernel("tests: constant[2]", make_constant(3.0))


def test_threads_that_call_a_factory_at_once_get_one_kernel() -> None:
    made: list[float] = []

    @decorators.kernel_factory
    def constant_kernel(value: float):
        time.sleep(0.05)  # so that the others call meanwhile
        made.append(value)
        return decorators.named_kernel(f"tests: called[{value}]", make_constant(value))

    with ThreadPoolExecutor(8) as threads:
        kernels = list(threads.map(constant_kernel, [5.0] * 8 + [6.0] * 8))
    assert sorted(made) == [5.0, 6.0]
    assert {id(kernel) for kernel in kernels} == {id(kernels[0]), id(kernels[-1])}
    assert (kernels[0](), kernels[-1]()) == (5.0, 6.0)


# All functions of a factory have one name. Numba distinguishes them by a counter that starts again
# in each process, so two cached kernels could hold different code under the same symbol.
TWINS = """
import sys
from stickslip.compiled.decorators import jit, named_kernel

def make_sum(step):
    @jit
    def total(n):
        if n > 1:
            return step(n) + total(n - 1)  # recursion: it cannot vanish into its caller
        return step(n)
    return total

@jit
def one(n): return 1.0

@jit
def two(n): return 2.0

def make_kernel(name, step):
    total = make_sum(step)
    def work(n):
        return total(n)
    return named_kernel(name, work)

steps = {"single": one, "double": two}
made = {name: make_kernel(f"sum[{name}]", steps[name]) for name in sys.argv[1:]}
print(*[made[name](5) for name in sys.argv[1:]], *[sum(made[name].stats.cache_hits.values())
                                                   for name in sys.argv[1:]])
"""


@pytest.mark.stress
def test_kernels_of_one_factory_stay_distinct_whichever_process_compiled_them(
    tmp_path: Path,
) -> None:
    script = tmp_path / "twins.py"  # in a file, since Numba caches no code of `python -c`
    script.write_text(TWINS, encoding="utf-8")

    def answers(*kernels: str) -> list[float]:
        run = f"import runpy, sys; sys.argv[1:] = {kernels!r}; runpy.run_path({str(script)!r})"
        out, _ = run_python(run, tmp_path / "cache")
        return [float(word) for word in out.split()]

    assert answers("single") == [5.0, 0]
    assert answers("double") == [10.0, 0]
    assert answers("single", "double") == [5.0, 10.0, 1, 1]
    assert answers("double", "single") == [10.0, 5.0, 1, 1]
