"""`stickslip check`, `schema` and `info` describe and compute nothing."""

from __future__ import annotations

import json
from importlib import metadata
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from support import messages
from support.pictures import sweep
from support.sweeps.commands import Command, entries, process

from sweeps.files.netcdf import content_hash, open_result

CONFIGS = Path(__file__).parents[2] / "configs"


def test_check_prints_what_a_sweep_would_compute(command: Command) -> None:
    code, out, err = command("check", "a.yaml")
    assert (code, err) == (0, "")
    assert out.splitlines() == [
        "a.yaml: valid",
        "points: 4 (temperature 2 x rheological_index 2)",
        "parameters: T 200 to 250 K, gamma -0.666667 to 0, the others as in the paper",
        "integrator: method adaptive, rtol 0.0001, max_error 0.01",
        "output: results/a.nc",
    ]
    Path("c.yaml").write_text("sweep: {T: [1, 2]}\ncases: {k: [1e4, 2e4, 3e4], X_m: [1, 2, 3]}\n")
    assert "points: 6 (temperature 2 x case 3)" in command("check", "c.yaml").out
    Path("d.yaml").write_text("{}\n")
    assert "points: 1\n" in command("check", "d.yaml").out
    assert entries() == ["a.yaml", "c.yaml", "d.yaml"]


def test_schema_is_the_shipped_one(command: Command) -> None:
    code, out, err = command("schema")
    assert (code, err) == (0, "")
    assert out == (CONFIGS / "stickslip.schema.json").read_text()
    jsonschema.Draft202012Validator.check_schema(json.loads(out))


def test_info_describes_the_installation(command: Command) -> None:
    code, out, err = command("info")
    assert (code, err) == (0, "")
    assert f"stickslip {metadata.version('stickslip')}" in out
    assert "compiled code is cached in: " in out


@pytest.mark.slow
def test_info_says_why_code_is_not_cached(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    done = process("info", environment={"NUMBA_CACHE_DIR": str(tmp_path / "file")})
    assert done.code == 0
    assert messages.NOT_CACHED in done.out
    assert "is not writable; set NUMBA_CACHE_DIR" in done.out
    assert "cached in" not in done.out


def test_info_names_statuses_that_a_file_does_not_name(command: Command) -> None:
    sweep(temperature=[200.0, 250.0]).to_netcdf("a.nc")
    assert "\n  ok: 2\n" in command.ok("info", "a.nc").out


def test_info_names_a_single_status_that_a_user_has_left(command: Command) -> None:
    ds = sweep(temperature=[200.0, 250.0])
    ds.status.attrs |= {"flag_values": np.array([0], np.int8), "flag_meanings": "ok"}
    ds.to_netcdf("a.nc")
    assert "\n  ok: 2\n" in command.ok("info", "a.nc").out


def test_info_describes_a_file(command: Command) -> None:
    command("sweep", "a.yaml", "--set", "integrator.max_steps=100")
    code, out, err = command("info", "results/a.nc")
    assert (code, err) == (0, "")
    ds = open_result(Path("results/a.nc"))
    assert "title: Four points\n" in out
    assert "dimensions: temperature 2, rheological_index 2\n" in out
    assert "  step_limit: 4\n" in out
    assert "  ok: " not in out
    assert f"history: {ds.attrs['history']}\n" in out
    assert f"config_sha256: {ds.attrs['config_sha256']}\n" in out
    assert out.endswith(f"content_sha256: {content_hash(ds)}\n")


def test_info_describes_a_trajectory_and_a_single_point(command: Command) -> None:
    command("simulate", "--periods", "1", "-o", "t.nc")
    out = command("info", "t.nc").out
    assert "dimensions: elapsed_time 2001\n" in out
    assert "friction_force" in out
    Path("p.yaml").write_text("integrator: {rtol: 1e-3}\nstationary: {rtol: 1e-3}\n")
    command("sweep", "p.yaml")
    out = command("info", "results/p.nc").out
    assert "dimensions: none\n" in out
    assert "  ok: 1\n" in out
