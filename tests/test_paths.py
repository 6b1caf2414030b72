"""Paths as people write them, in configs, on the command line and in Python."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.sweeps.commands import FOUR_POINTS, Command, entries

from sweeps.config.load import ConfigError, from_mapping
from sweeps.engine.run import run
from sweeps.paths import expanded, path_of

A_YAML = FOUR_POINTS
_HOME = {"HOME": "/home/me", "SCRATCH": "/scratch/me", "EMPTY": ""}

_REFUSED = [
    ("$NIX/out.nc", "$NIX, an environment variable that is not set here"),
    ("${NIX}.nc", "${NIX}, an environment variable that is not set here"),
    ("$EMPTY/out.nc", "$EMPTY, an environment variable that is not set here"),
    ("~nobody-at-all/out.nc", "~nobody-at-all, but there is no such user"),
    (r"C:\Users\me\out.nc", "is a Windows path"),
    ("C:/Users/me/out.nc", "is a Windows path"),
    (r"results\out.nc", "is a Windows path"),
    ("s3://bucket/out.nc", "is a URL"),
]


@pytest.fixture(autouse=True)
def environment(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    for name, value in _HOME.items():
        monkeypatch.setenv(name, value)


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("~/out.nc", "/home/me/out.nc"),
        ("$SCRATCH/out.nc", "/scratch/me/out.nc"),
        ("${SCRATCH}2/out.nc", "/scratch/me2/out.nc"),
        ("results/~out.nc", "results/~out.nc"),
        ("cost-in-$.nc", "cost-in-$.nc"),
        ("T=250-a.nc", "T=250-a.nc"),
        ("/a/b c.nc", "/a/b c.nc"),
    ],
)
def test_a_path_is_expanded_as_by_a_shell(written: str, meant: str) -> None:
    assert expanded(written) == meant
    assert path_of(written) == Path(meant)
    assert from_mapping({"output": written}).output == meant


@pytest.mark.parametrize(("written", "words"), _REFUSED)
def test_a_path_that_would_make_an_odd_folder_is_refused(
    shell: Command, written: str, words: str
) -> None:
    Path("own.yaml").write_text(f"output: '{written}'\nsweep: {{T: [200]}}\n")
    Path("pull.yaml").write_text(f"simulation: {{drive: {{table: '{written}'}}}}\n")
    before = entries()
    for arguments, place in (
        (("sweep", "own.yaml"), "own.yaml:1: output: "),
        (("check", "own.yaml"), "own.yaml:1: output: "),
        (("sweep", "a.yaml", "--set", f"output={written}"), "output: "),
        (("check", "pull.yaml"), "pull.yaml:1: simulation.drive.table: "),
        (("sweep", "a.yaml", "-o", written), ""),
        (("merge", "a.nc", written, "-o", "b.nc"), ""),
        (("new", written), ""),
    ):
        code, out, err = shell(*arguments)
        assert (code, out, err.count("\n")) == (2, "", 1), err
        assert place in err
        assert words in err
    assert entries() == before


def test_the_name_of_an_existing_file_is_not_expanded() -> None:
    for name in ("~", "$NIX.nc", r"a\b.nc"):
        Path(name).touch()
        assert path_of(name) == Path(name)


def test_python_takes_the_home_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    ds = run({"sweep": {"T": [200]}, "integrator": {"rtol": 1e-4}}, output="~/a.nc")
    assert ds.encoding["source"] == str(tmp_path / "home/a.nc")
    assert entries() == ["home"]
    with pytest.raises(ValueError, match="is a Windows path"):
        run({"sweep": {"T": [200]}}, output=r"C:\a.nc")
    with pytest.raises(ConfigError, match="there is no such user"):
        from_mapping({"output": "~nobody-at-all/a.nc"})
