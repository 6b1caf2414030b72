"""The cache of compiled code gives the right numbers, even if it is damaged or contended."""

from __future__ import annotations

import contextlib
import errno
import importlib.util
import os
import pickle
import shutil
import subprocess
import sys
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numba.core import config as numba_config
from support import messages
from support.package import ENDED, PACKAGE, copy_of_package, run_python, start_python

from stickslip.compiled import cache as compiled_cache
from stickslip.compiled import decorators

# The smallest kernel of the package, which takes half a second to compile, in a fresh interpreter.
# Its ln(phi) comes from model/noise.py.
SMALL_KERNEL = """
import numpy as np
from stickslip.kernels.trajectories import start_kernel
from stickslip.options import DEFAULTS
from stickslip.parameters import Parameters
state = np.empty(3)
start_kernel(DEFAULTS.physics)(np.array(Parameters()), state)
stats = start_kernel(DEFAULTS.physics).stats
print(state[2], sum(stats.cache_hits.values()), sum(stats.cache_misses.values()))
"""
LOG_PHI = -26.2318641


def run_small_kernel(cache: Path, package: Path = PACKAGE) -> tuple[float, int, int, str]:
    """Return ln(phi), hits and misses of the cache, and the warnings."""
    out, err = run_python(SMALL_KERNEL, cache, package)
    value, hits, misses = out.split()
    return float(value), int(hits), int(misses), err


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """An empty cache for the kernels of this process."""
    monkeypatch.setattr(numba_config, "CACHE_DIR", str(tmp_path / "cache"))
    compiled_cache.warn_once.cache_clear()
    yield tmp_path / "cache"
    compiled_cache.warn_once.cache_clear()


def new_kernel() -> Any:
    """Declare x -> 3 x + 1, as in a process that has not done so yet."""

    def tiny(x: float) -> float:
        return 3.0 * x + 1.0

    with pytest.MonkeyPatch.context() as fresh:
        fresh.setattr(decorators, "KERNEL_NAMES", set())
        return decorators.named_kernel("tests: tiny", tiny)


def use() -> tuple[float, int, list[str]]:
    """Return the result of a new kernel for 2, its hits of the cache, and the warnings."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        kernel = new_kernel()
        value = kernel(2.0)
    return value, sum(kernel.stats.cache_hits.values()), [str(w.message) for w in caught]


def only_file(cache: Path, suffix: str) -> Path:
    (path,) = cache.rglob(f"*.{suffix}")
    return path


def hash_of(package: Path) -> str:
    """Return the source hash that the cache.py of a package computes."""
    spec = importlib.util.spec_from_file_location(
        "compiled_copy", package / "compiled" / "cache.py"
    )
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.source_hash()


# --- the hash ------------------------------------------------------------------------------------


def test_the_hash_covers_the_names_and_contents_of_all_sources(tmp_path: Path) -> None:
    package, own = copy_of_package(tmp_path), compiled_cache.source_hash()
    assert hash_of(package) == own
    assert len(own) == 64
    for name in ("variables.py", "kernels/families.py", "model/laws/power_law.py"):
        text = (package / name).read_text()
        (package / name).write_text(text + "\n")
        assert hash_of(package) != own, name
        (package / name).write_text(text)
    (package / "model" / "film.py").rename(package / "model" / "film2.py")
    assert hash_of(package) != own


# --- folders into which others could have put code -----------------------------------------------


def give_away(folder: Path) -> None:
    if os.geteuid() != 0:
        pytest.skip("only root can give a folder away")
    os.chown(folder, 65534, 65534)


PLANTED: dict[str, tuple[Callable[[Path], None], str]] = {
    "of another user": (give_away, "belongs to another user"),
    "in a folder of another user": (lambda folder: give_away(folder.parent), "another user"),
    "others can write": (lambda folder: folder.chmod(0o777), "others can write into"),
    "its group can write": (lambda folder: folder.chmod(0o770), "others can write into"),
    "others can exchange it": (
        lambda folder: folder.parent.chmod(0o777),
        "others can replace files",
    ),
    "a link": (lambda folder: folder.rename(f"{folder}.mine"), "is not a folder"),
}


@pytest.mark.parametrize("case", PLANTED)
def test_code_that_another_user_could_have_planted_is_not_run(
    cache: Path, case: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert use() == (7.0, 0, [])
    assert use() == (7.0, 1, [])
    plant, reason = PLANTED[case]
    folder = compiled_cache.cache_folder()
    monkeypatch.setattr(compiled_cache, "cache_folder", lambda: folder)
    plant(folder)
    if case == "a link":
        folder.symlink_to(f"{folder}.mine")
    value, hits, (warning,) = use()
    assert (value, hits) == (7.0, 0)
    assert warning.startswith(messages.NOT_CACHED)
    assert reason in warning


def test_in_a_shared_folder_each_user_has_a_private_one(cache: Path) -> None:
    cache.mkdir()
    cache.chmod(0o1777)
    assert use() == (7.0, 0, [])
    assert use() == (7.0, 1, [])
    folder = compiled_cache.cache_folder()
    assert folder.name.startswith(f"stickslip-{os.geteuid()}-")
    assert folder.stat().st_mode & 0o777 == 0o700


# --- edits of the sources, and new processes -----------------------------------------------------


NOTING = """
import numba.core.compiler as compiler
compiled, compile_extra = [], compiler.compile_extra
def noted(typing, target, function, *others, **more):
    compiled.append(function.__qualname__)
    return compile_extra(typing, target, function, *others, **more)
compiler.compile_extra = noted
from stickslip import simulate, stationary_orbits
stationary_orbits({"T": [250.0]}, rtol=1e-4)
simulate(periods=1, samples_per_period=4)
print(compiled)
"""


@pytest.mark.slow
def test_a_new_process_compiles_nothing_again() -> None:
    """A part of a kernel that Python calls would be compiled in each process, for half a second."""
    runs = [
        subprocess.run([sys.executable, "-c", NOTING], capture_output=True, text=True, check=True)
        for _ in range(2)  # the first may find no cache
    ]
    assert runs[-1].stdout == "[]\n"


@pytest.mark.slow
def test_loading_code_does_not_import_the_compiler(tmp_path: Path) -> None:
    code = SMALL_KERNEL + (
        "import sys\n"
        "print('numba.np.arraymath' in sys.modules, 'scipy.linalg' in sys.modules)\n"
        "import numba\n"
        "print(numba.njit(lambda x: np.sum(x) + np.linalg.norm(x))(np.ones(4)))\n"
    )
    run_small_kernel(tmp_path)
    out, err = run_python(code, tmp_path)
    assert out.split()[1:] == ["1", "0", "False", "False", "6.0"]
    assert err == ""


@pytest.mark.stress
def test_another_installation_of_the_same_sources_finds_their_code(tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    first = run_small_kernel(cache)
    elsewhere = run_small_kernel(cache, copy_of_package(tmp_path))
    assert first[:3] == (pytest.approx(LOG_PHI, abs=1e-6), 0, 1)
    assert elsewhere == (first[0], 1, 0, "")


@pytest.mark.slow
def test_an_edit_of_the_physics_is_compiled_even_with_a_warm_cache(tmp_path: Path) -> None:
    package, cache = copy_of_package(tmp_path), tmp_path / "cache"
    before = run_small_kernel(cache, package)
    noise = package / "model" / "noise.py"
    old = noise.read_text()
    noise.write_text(old.replace("0.5 * math.exp(", "0.5 * math.e**2 * math.exp("))
    assert noise.read_text() != old
    after = run_small_kernel(cache, package)
    # The limiting term is linear, so phi is proportional to the root of the intensity.
    assert after[0] == pytest.approx(before[0] + 1.0, rel=1e-12)


@pytest.mark.slow
def test_without_a_cache_folder_code_is_compiled_and_not_stored(tmp_path: Path) -> None:
    package = copy_of_package(tmp_path)
    obstacle = tmp_path / "file"
    obstacle.write_text("not a folder")
    assert run_small_kernel(obstacle, package)[0] == pytest.approx(LOG_PHI, abs=1e-6)
    assert not list(tmp_path.rglob("*.nb[ci]"))  # other sources would find files of Numba's cache


# --- damage --------------------------------------------------------------------------------------

Damage = Callable[[bytes], bytes]


def truncated(share: float) -> Damage:
    return lambda data: data[: int(share * len(data))]


def noise(data: bytes) -> bytes:
    return np.random.default_rng(len(data)).bytes(len(data))


def without_a_page(data: bytes) -> bytes:
    """Return what a power cut may leave; without a checksum the code would crash this process."""
    middle = len(data) // 2
    return data[: middle - 64] + bytes(128) + data[middle + 64 :]


DAMAGE: dict[str, Damage] = {
    "empty": truncated(0.0),
    "a tenth is left": truncated(0.1),
    "half is left": truncated(0.5),
    "the last byte is missing": lambda data: data[:-1],
    "zeros": lambda data: bytes(len(data)),
    "random bytes": noise,
    "random bytes at its end": lambda data: data[: len(data) // 2] + noise(data[len(data) // 2 :]),
    "a page is lost": without_a_page,
    "text": lambda _: b"<html>quota exceeded</html>\n",
    "another pickle": lambda _: pickle.dumps({"nothing": "of ours"}),
}


@pytest.mark.parametrize("suffix", ["nbi", "nbc"])
@pytest.mark.parametrize("kind", DAMAGE)
def test_a_damaged_file_costs_a_compilation(cache: Path, suffix: str, kind: str) -> None:
    assert use() == (7.0, 0, [])
    path = only_file(cache, suffix)
    path.write_bytes(DAMAGE[kind](path.read_bytes()))
    value, hits, warned = use()
    assert (value, hits) == (7.0, 0)
    assert len(warned) <= 1
    assert all(line.startswith("the cache of compiled code is damaged") for line in warned)
    assert use() == (7.0, 1, [])  # it was stored again


@pytest.mark.parametrize("suffix", ["nbi", "nbc"])
def test_a_missing_file_costs_a_compilation(cache: Path, suffix: str) -> None:
    assert use() == (7.0, 0, [])
    only_file(cache, suffix).unlink()
    assert use() == (7.0, 0, [])
    assert use() == (7.0, 1, [])


def test_a_cache_of_another_numba_version_is_not_used(
    cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as earlier:
        earlier.setattr("numba.__version__", "0.1")
        use()
    assert use() == (7.0, 0, [])
    assert use() == (7.0, 1, [])


# --- folders -------------------------------------------------------------------------------------


def test_a_folder_that_vanishes_is_made_again(cache: Path) -> None:
    kernel = new_kernel()
    shutil.rmtree(cache)  # as someone who tidies up may do before the first call
    assert kernel(2.0) == 7.0
    assert use() == (7.0, 1, [])


def test_a_folder_that_becomes_read_only_does_no_harm(cache: Path) -> None:
    use()
    folder = only_file(cache, "nbi").parent
    folder.chmod(0o500)
    if os.access(folder, os.W_OK):
        pytest.skip("this user can write to a read-only folder")
    try:
        value, _, warned = use()
    finally:
        folder.chmod(0o700)
    assert value == 7.0
    assert len(warned) <= 1


@contextlib.contextmanager
def full_disk(monkeypatch: pytest.MonkeyPatch, call: str, code: int) -> Iterator[None]:
    """Make this call fail whenever it writes."""

    def refuse(path: str, *how: str) -> Any:
        if how == ("rb",):
            return Path(path).open("rb")
        raise OSError(code, os.strerror(code))

    with monkeypatch.context() as broken:
        broken.setattr(f"numba.core.caching.{call}", refuse, raising=False)
        yield


@pytest.mark.parametrize("code", [errno.ENOSPC, errno.EIO, errno.EROFS])
@pytest.mark.parametrize("call", ["open", "os.replace"])
def test_a_disk_that_cannot_be_written_costs_a_warning(
    cache: Path, monkeypatch: pytest.MonkeyPatch, call: str, code: int
) -> None:
    with full_disk(monkeypatch, call, code):
        value, hits, (warning,) = use()
    assert (value, hits) == (7.0, 0)
    assert os.strerror(code) in warning
    assert not list(cache.rglob("*.tmp.*"))
    assert use() == (7.0, 0, [])
    assert use() == (7.0, 1, [])


@pytest.mark.parametrize("call", ["open", "os.replace"])
def test_a_damaged_cache_on_a_full_disk_costs_warnings(
    cache: Path, monkeypatch: pytest.MonkeyPatch, call: str
) -> None:
    use()
    path = only_file(cache, "nbi")
    path.write_bytes(noise(path.read_bytes()))
    with full_disk(monkeypatch, call, errno.EROFS):
        value, hits, warned = use()
    assert (value, hits) == (7.0, 0)
    assert 1 <= len(warned) <= 2  # one for reading, one for writing


# --- several processes at once -------------------------------------------------------------------


def ended(process: subprocess.Popen[str]) -> tuple[int, float, int, str]:
    """Return the exit code, ln(phi), hits of the cache, and the warnings."""
    out, err = process.communicate(timeout=ENDED)
    value, hits, _ = out.split() if out else ("nan", "0", "0")
    return process.returncode, float(value), int(hits), err


@pytest.mark.stress
@pytest.mark.parametrize("damaged", [False, True])
def test_eight_processes_at_once_agree_and_leave_a_good_cache(cache: Path, damaged: bool) -> None:
    if damaged:
        run_small_kernel(cache)
        for path in (only_file(cache, "nbi"), only_file(cache, "nbc")):
            path.write_bytes(noise(path.read_bytes()))
    processes = [start_python(SMALL_KERNEL, cache) for _ in range(8)]
    results = [ended(process) for process in processes]
    values = {value for _, value, _, _ in results}
    assert len(values) == 1
    assert values.pop() == pytest.approx(LOG_PHI, abs=1e-6)
    for code, _, _, warned in results:
        assert code == 0
        assert warned.count("Warning") <= 1
        assert "Traceback" not in warned
        assert damaged or warned == ""
    assert run_small_kernel(cache)[1:] == (1, 0, "")
    assert not list(cache.rglob("*.tmp.*"))
