"""Compiled code: one signature a door, a cache that follows the sources and survives damage."""

import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import stickslip
from stickslip import kernels
from stickslip.compiled import cache, decorators
from stickslip.options import Options
from stickslip.parameters import Parameters

PACKAGE = Path(stickslip.__file__).parent

# The smallest door: it is compiled in half a second. Its ln(phi) comes from model/noise.py.
SMALL_DOOR = """
import numpy as np
from stickslip import kernels
from stickslip.parameters import Parameters
state = np.empty(3)
kernels.starting_log_state(np.array(Parameters()), state)
stats = kernels.starting_log_state.stats
print(state[2], sum(stats.cache_hits.values()), sum(stats.cache_misses.values()))
"""
LOG_PHI = -26.2318641


def copy_of_package(folder: Path) -> Path:
    ignore = shutil.ignore_patterns("__pycache__")
    return Path(shutil.copytree(PACKAGE, folder / "stickslip", ignore=ignore))


def run_small_door(cache: Path, package: Path = PACKAGE) -> tuple[float, int, int, str]:
    """ln(phi), hits and misses of the cache, and what was warned, in a fresh interpreter."""
    environment = os.environ | {"NUMBA_CACHE_DIR": str(cache), "PYTHONPATH": str(package.parent)}
    done = subprocess.run(
        [sys.executable, "-W", "default", "-c", SMALL_DOOR],
        env=environment,
        cwd=package.parent,  # an interpreter started with -c looks there first
        capture_output=True,
        text=True,
        check=True,
        timeout=300,
    )
    value, hits, misses = done.stdout.split()
    return float(value), int(hits), int(misses), done.stderr


def hash_of(package: Path) -> str:
    """The source hash that a package computes of itself, from its own cache.py."""
    spec = importlib.util.spec_from_file_location(
        "compiled_copy", package / "compiled" / "cache.py"
    )
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.source_hash()


# --- the hash ------------------------------------------------------------------------------------


def test_a_copy_of_the_sources_has_the_same_hash(tmp_path: Path) -> None:
    assert hash_of(copy_of_package(tmp_path)) == cache.source_hash()
    assert len(cache.source_hash()) == 64


@pytest.mark.parametrize("name", ["kernels/orbits.py", "model/friction.py", "numerics/tableaus.py"])
def test_the_hash_changes_with_any_source(tmp_path: Path, name: str) -> None:
    package = copy_of_package(tmp_path)
    source = package / name
    source.write_text(source.read_text() + "\n")
    assert hash_of(package) != cache.source_hash()


def test_the_hash_changes_with_the_name_of_a_source(tmp_path: Path) -> None:
    package = copy_of_package(tmp_path)
    (package / "model" / "film.py").rename(package / "model" / "film2.py")
    assert hash_of(package) != cache.source_hash()


def test_the_cache_folder_is_named_by_the_hash() -> None:
    assert cache.cache_folder().name == f"stickslip-{cache.source_hash()[:16]}"


# --- the cache -----------------------------------------------------------------------------------


@pytest.mark.slow
def test_the_second_process_finds_the_code_of_the_first(tmp_path: Path) -> None:
    first = run_small_door(tmp_path)
    second = run_small_door(tmp_path)
    assert first[:3] == (pytest.approx(LOG_PHI, abs=1e-6), 0, 1)
    assert second == (first[0], 1, 0, "")


@pytest.mark.slow
def test_an_edit_of_the_physics_is_compiled_even_with_a_warm_cache(tmp_path: Path) -> None:
    package = copy_of_package(tmp_path)
    cache = tmp_path / "cache"
    before = run_small_door(cache, package)
    noise = package / "model" / "noise.py"
    old = noise.read_text()
    noise.write_text(old.replace("0.5 * math.exp(", "0.5 * math.e**2 * math.exp("))
    assert noise.read_text() != old
    after = run_small_door(cache, package)
    # The limiting term is linear: phi goes with the root of the intensity.
    assert after[0] == pytest.approx(before[0] + 1.0, rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("suffix", ["nbi", "nbc"])
@pytest.mark.parametrize("kept", [0.0, 0.5])
def test_a_truncated_cache_is_made_anew_with_a_warning(
    tmp_path: Path, suffix: str, kept: float
) -> None:
    value = run_small_door(tmp_path)[0]
    damaged = list(tmp_path.rglob(f"*.{suffix}"))
    assert damaged
    for path in damaged:
        data = path.read_bytes()
        path.write_bytes(data[: int(kept * len(data))])
    again = run_small_door(tmp_path)
    assert again[0] == value
    assert "RuntimeWarning: the cache of compiled code is damaged" in again[3]
    assert "Traceback" not in again[3]
    assert run_small_door(tmp_path) == (value, 1, 0, "")


@pytest.mark.slow
def test_a_cache_of_random_bytes_is_made_anew(tmp_path: Path) -> None:
    value = run_small_door(tmp_path)[0]
    rng = np.random.default_rng(0)
    for path in [*tmp_path.rglob("*.nbi"), *tmp_path.rglob("*.nbc")]:
        path.write_bytes(rng.bytes(len(path.read_bytes())))
    assert run_small_door(tmp_path)[0] == value
    assert run_small_door(tmp_path)[1:] == (1, 0, "")


@pytest.mark.slow
def test_a_cache_folder_that_cannot_be_made_does_not_stop_the_work(tmp_path: Path) -> None:
    package = copy_of_package(tmp_path)
    obstacle = tmp_path / "file"
    obstacle.write_text("not a folder")
    assert run_small_door(obstacle, package)[0] == pytest.approx(LOG_PHI, abs=1e-6)


@pytest.mark.slow
def test_a_cache_folder_that_is_read_only_does_not_stop_the_work(tmp_path: Path) -> None:
    folder = tmp_path / "cache"
    folder.mkdir()
    folder.chmod(0o500)
    if os.access(folder, os.W_OK):
        pytest.skip("this user can write to a read-only folder")
    package = copy_of_package(tmp_path)
    assert run_small_door(folder, package)[0] == pytest.approx(LOG_PHI, abs=1e-6)


@pytest.mark.slow
def test_without_a_cache_folder_an_edit_of_the_physics_is_compiled(tmp_path: Path) -> None:
    package = copy_of_package(tmp_path)
    obstacle = tmp_path / "file"
    obstacle.write_text("not a folder")
    before = run_small_door(obstacle, package)
    noise = package / "model" / "noise.py"
    noise.write_text(noise.read_text().replace("0.5 * math.exp(", "0.5 * math.e**2 * math.exp("))
    after = run_small_door(obstacle, package)
    assert after[0] == pytest.approx(before[0] + 1.0, rel=1e-12)


# --- signatures ----------------------------------------------------------------------------------


def test_settings_are_of_one_type_whatever_numbers_made_them() -> None:
    types = {
        tuple(type(value) for value in Options(**changes).settings())
        for changes in (
            {},
            {"rtol": np.float32(1e-3), "dt": 1, "stationary_rtol": np.float32(1e-3)},
            {"max_steps": 1e6, "max_periods": np.int64(7)},
            {"method": "euler-cromer", "accelerate": 1},
        )
    }
    assert types == {(float, float, int, float, int, bool)}


def test_a_door_has_one_signature_for_all_parameters_and_settings() -> None:
    start, samples = np.zeros(3), np.empty((3, 3))
    for parameters in (Parameters(), Parameters(rheological_index=0, temperature=310)):
        point = np.array(parameters)
        kernels.starting_log_state(point, start)
        for options in (
            Options(rtol=1e-3),
            Options(rtol=np.float32(1e-3), max_steps=1e6, stationary_rtol=np.float32(1e-3)),
            Options(rtol=1e-2, max_steps=np.int64(10**6), accelerate=False),
        ):
            kernels.adaptive_trajectory(point, options.settings(), start, 2, samples)
    assert len(kernels.starting_log_state.signatures) == 1
    assert len(kernels.adaptive_trajectory.signatures) == 1


def test_a_door_is_compiled_without_the_flags_that_let_nan_pass() -> None:
    for compiler in (decorators.jit, decorators.inline):
        function = compiler(lambda error: error <= 1.0)
        assert not function(float("nan"))
        assert set(function.targetoptions["fastmath"]) <= {"contract", "nsz", "arcp", "afn"}
    options = kernels.starting_log_state.targetoptions
    assert set(options["fastmath"]) <= {"contract", "nsz", "arcp", "afn"}
    assert options["error_model"] == "numpy"
    assert options["nogil"]
