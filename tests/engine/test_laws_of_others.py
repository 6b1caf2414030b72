"""Friction laws of users: swept, replayed, refused if changed or if others could change them."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support import messages
from support.law_package import CONFIG, LAW, install
from support.sweeps.commands import process
from support.sweeps.workers import ROOT

from stickslip import laws
from stickslip.compiled.cache import source_hash
from stickslip.compiled.decorators import KERNEL_NAMES
from stickslip.dispatch.ask import ask
from stickslip.dispatch.blocks import Given
from stickslip.dispatch.errors import ExecutorError, WorkerMismatchError
from stickslip.dispatch.task import Task, compute_block
from stickslip.laws import LawError, origin_of
from stickslip.model.laws import FrictionLaw, friction_law, register_law
from stickslip.options import DEFAULTS, OptionError, Options
from stickslip.parameters import Parameters
from sweeps.config.load import ConfigError, from_mapping
from sweeps.engine.executors.dask import ClusterExecutor
from sweeps.engine.executors.processes import ProcessExecutor
from sweeps.engine.run import run
from sweeps.engine.settings import read_config
from sweeps.files.netcdf import content_hash, open_result
from sweeps.identity import settings_of

AT = ("replay", "a.nc", "--at", "T=240", "-o", "replayed.nc", "--overwrite")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    here = tmp_path / "here"
    here.mkdir()
    (here / "a.yaml").write_text(CONFIG)
    monkeypatch.chdir(here)
    monkeypatch.setattr(laws, "REGISTERED", {})
    laws._installed.cache_clear()
    return here


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of installed packages, with the law."""
    site = tmp_path / "site"
    install(site)
    site.chmod(0o755)
    monkeypatch.syspath_prepend(site)
    for name in [name for name in sys.modules if name.partition(".")[0] in ("pliant", "stiff")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(site), str(ROOT)]))
    return site


# --- in a package ---------------------------------------------------------------------------------


@pytest.mark.stress
def test_a_law_of_a_package_is_swept_replayed_and_refused_when_it_changes(site: Path) -> None:
    assert process("sweep", "a.yaml", "-o", "a.nc", "--no-progress").code == 0
    processes = ("--backend", "loky", "--workers", "2")
    assert process("sweep", "a.yaml", "-o", "b.nc", "--no-progress", *processes).code == 0
    first = open_result(Path("a.nc"))
    assert content_hash(first) == content_hash(open_result(Path("b.nc")))
    assert (first.status == 0).all()
    replayed = process(*AT)
    assert (replayed.code, messages.SAME_BITS in replayed.out) == (0, True)

    was = origin_of("limited").identity
    assert f'law: "{was}"' in first.attrs["config"]
    install(site, factor=1.5)
    laws._installed.cache_clear()
    now = origin_of("limited").identity
    resumed = process("sweep", "a.yaml", "-o", "a.nc")
    assert resumed.code == 2
    assert f"film.law: {was} -> {now}" in resumed.err
    replayed = process(*AT)
    assert replayed.code == 2
    assert f"the law limited@{was} is {now} here, which {messages.MAY_DIFFER}" in replayed.err
    assert process("info", "a.nc").code == 0  # shown all the same
    # Both versions are computed with kernels of their own, from one cache.
    assert process("sweep", "a.yaml", "-o", "c.nc", "--no-progress").code == 0
    changed = open_result(Path("c.nc")).friction_force_amplitude / first.friction_force_amplitude
    assert float(changed.sel(temperature=320.0)) == pytest.approx(1.5, rel=0.05)


def test_a_config_names_a_law_or_gets_a_list_of_laws(site: Path) -> None:
    config = read_config("a.yaml")
    assert config.film.law == origin_of("limited").identity
    assert config.film.law.startswith("pliant-1.0+")
    assert settings_of(config)["film.law"] == config.film.law
    assert from_mapping(config.resolved()).sha256() == config.sha256()
    with pytest.raises(ConfigError) as caught:
        read_config("a.yaml", ["film.friction=unlimited"])
    assert (
        "film.friction: must be one of power-law, not 'unlimited'; other known laws: limited; to "
        in (str(caught.value))
    )
    assert "'stickslip.laws', or call stickslip.register_law" in str(caught.value)
    with pytest.raises(ConfigError, match=r"film.law: power-law is a built-in law; leave"):
        read_config("a.yaml", ["film.friction=power-law", "film.law=pliant-1.0"])
    Path("b.yaml").write_text(CONFIG.replace("limited}", "limited, law: pliant-0.9+0}"))
    with pytest.raises(ConfigError, match=r"b.yaml:3: film.friction: the law limited@pliant-0.9"):
        read_config("b.yaml")


def test_each_version_of_a_package_has_its_identity(site: Path) -> None:
    def identity(**changes: Any) -> str:
        for path in sorted(site.rglob("*"), reverse=True):
            path.unlink() if path.is_file() else path.rmdir()
        module = install(site, **changes)
        compiled = module.parent / "__pycache__"
        compiled.mkdir()
        (compiled / "laws.pyc").write_bytes(os.urandom(8))
        laws._installed.cache_clear()
        return origin_of("limited").identity

    found = [identity(), identity(factor=2.0), identity(version="1.0.1"), identity(name="stiff")]
    assert len({*found}) == 4
    assert identity() == found[0]
    points = site / "pliant-1.0.dist-info" / "entry_points.txt"
    points.write_text(points.read_text().replace(":LIMITED", ":OTHER"))
    laws._installed.cache_clear()
    assert origin_of("limited").identity not in found


def exposed(path: str, mode: int) -> Callable[[Path], object]:
    return lambda site: (site / path).chmod(mode)


def add_record(site: Path, text: str) -> None:
    record = site / "pliant-1.0.dist-info" / "RECORD"
    record.write_text(text)


REFUSED: dict[str, tuple[Callable[[Path], object], str]] = {
    "in the current folder": (os.chdir, "lies in the current folder"),
    "a module that a group can write": (exposed("pliant/laws.py", 0o664), "chmod go-w .*laws.py"),
    "a folder that all can write": (exposed("pliant", 0o757), "chmod go-w .*/pliant"),
    "a folder of packages that all can write": (exposed("", 0o1777), "chmod go-w .*/site"),
    "a folder above that all can write": (exposed("..", 0o777), "could be changed by others"),
    "entry points that a group can write": (
        exposed("pliant-1.0.dist-info/entry_points.txt", 0o664),
        "entry_points.txt",
    ),
    "editable": (
        lambda site: add_record(site, "pliant-1.0.dist-info/METADATA,,\n"),
        "does not have the module pliant.laws .*--editable",
    ),
    "hidden": (
        lambda _: (Path("pliant.py").touch(), sys.path.insert(0, "")),
        "hidden by another module pliant",
    ),
    "damaged": (
        lambda site: (site / "pliant/laws.py").unlink(),
        "is damaged.*(install it again|reinstall it without --editable)$",
    ),
    "twice": (lambda site: install(site, name="stiff"), "a law of pliant and stiff; uninstall"),
    "none": (
        lambda site: (site / "pliant/laws.py").write_text("LIMITED = 3"),
        "friction law 'limited' of pliant-1.0.*: it is 3, not a FrictionLaw called 'limited'",
    ),
    "raising": (
        lambda site: (site / "pliant/laws.py").write_text("import no_such_module"),
        "ModuleNotFoundError: No module named 'no_such_module'",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_an_unsafe_or_broken_law_is_refused(
    case: str, site: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "path", [*sys.path])
    happens, message = REFUSED[case]
    happens(site)
    with pytest.raises(LawError, match=message):
        friction_law(origin_of("limited").full_name)
    assert "pliant.laws" not in sys.modules or case == "none"


def test_a_law_of_a_folder_of_another_user_is_refused(
    site: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    other = 1 + max(os.geteuid(), Path(laws.__file__).stat().st_uid, site.stat().st_uid)
    if os.geteuid() != 0:
        pytest.skip("only root can give a file to another user")
    os.chown(site / "pliant", other, -1)
    with pytest.raises(LawError, match=r"/site/pliant belongs to another user"):
        origin_of("limited")


def test_a_worker_with_another_law_computes_nothing(site: Path) -> None:
    options = Options(friction="limited")
    object.__setattr__(options, "friction", "limited@pliant-0.9+0123")
    task = Task(np.array([0]), np.array([Parameters()]), options, source_hash())
    with pytest.raises(WorkerMismatchError, match=r"the friction law of this sweep: the law limit"):
        compute_block(task)


# --- in this process only -------------------------------------------------------------------------


def law_in_python(factor: float = 1.0, **changes: Any) -> FrictionLaw:
    names: dict[str, Any] = {"FACTOR": factor, "__name__": "__main__"}
    exec(LAW, names)
    law: FrictionLaw = replace(names["LIMITED"], **changes)
    return law


@pytest.mark.stress
def test_a_law_of_this_process_runs_only_in_threads() -> None:
    register_law(law_in_python())
    config = {"model": {"k": 1e6, "gamma": 1e3, "T": 320}, "film": {"friction": "limited"}}
    once, again = (run(config, workers=workers) for workers in (1, 2))
    assert int(once.status) == 0
    assert content_hash(once) == content_hash(again)
    full_name = Options(friction="limited").friction
    assert full_name.startswith("limited@python+")
    assert any(full_name in name for name in KERNEL_NAMES)
    with pytest.raises(ExecutorError, match=r"'limited' was registered in this process, and loky"):
        run(config | {"execution": {"backend": "loky", "workers": 2}})

    register_law(law_in_python(1.5))
    other = run(config, workers=1)
    assert float(other.friction_force_amplitude / once.friction_force_amplitude) == (
        pytest.approx(1.5, rel=0.05)
    )
    # Each is computed again with its own law, whichever has the name now.
    assert once.stickslip.at().differences() == other.stickslip.at().differences() == {}
    laws.REGISTERED.clear()
    register_law(law_in_python(1.5))
    with pytest.raises(ConfigError, match=messages.MAY_DIFFER):
        once.stickslip.at().orbit()
    laws.REGISTERED.clear()
    with pytest.raises(ConfigError, match="is missing; register the same law first"):
        once.stickslip.at().orbit()


@pytest.mark.parametrize("kind", [ProcessExecutor, ClusterExecutor])
def test_other_processes_refuse_a_law_of_this_one(kind: Any) -> None:
    workers = kind(2) if kind is ProcessExecutor else kind("tcp://127.0.0.1:1")
    options = replace(DEFAULTS)
    object.__setattr__(options, "friction", "limited@python+0123")
    blocks = ask(lambda _: np.array([Parameters()]), Given([np.array([0])]), options, workers)
    with pytest.raises(ExecutorError, match=r"use threads .*backend: threads"):
        next(blocks)


def test_a_broken_law_is_not_registered() -> None:
    for law, message in {
        law_in_python(name="power-law"): "is a law of stickslip itself",
        law_in_python(name="a/b"): "cannot name a law",
        law_in_python(scaled={}): "same in the units of kernels .*, at u = -1.6e-05 m/s, k = 1e",
        law_in_python(stress=unknown): "cannot be compiled: .*no_such_parameter",
        law_in_python(stress=table): "`GRID`, to which table refers, is of type ndarray",
    }.items():
        with pytest.raises(LawError, match=message):
            register_law(law)
    with pytest.raises(OptionError, match="friction must be one of power-law, not 'limited'"):
        Options(friction="limited")


def test_a_name_of_an_installed_law_is_not_registered(site: Path) -> None:
    with pytest.raises(LawError, match="'limited' is a law of pliant; choose another name"):
        register_law(law_in_python())


GRID = np.linspace(0.0, 1.0, 3)


def table(p: Parameters, u: float, phi: float) -> float:
    return float(GRID[0] + p.temperature * u * phi)


def unknown(p: Any, u: float, phi: float) -> float:
    return float(p.no_such_parameter * u * phi)
