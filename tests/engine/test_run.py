"""`sweeps.run` with an output: resumed, grown, refused, stopped, as on the command line."""

from __future__ import annotations

import io
import signal
import sys
from pathlib import Path
from typing import Any

import pytest
from support import messages
from support.sweeps.processes import default_signals

from stickslip.dispatch.task import Block
from sweeps import run
from sweeps.config.load import ConfigError, from_mapping
from sweeps.engine.existing import RefusalError
from sweeps.engine.run import StoppedError
from sweeps.engine.sweep import Recorder
from sweeps.files.netcdf import content_hash, open_result

CONFIG: dict[str, Any] = {
    "integrator": {"rtol": 1e-4},
    "stationary": {"rtol": 1e-4},
    "sweep": {"T": [200, 220, 240, 260]},
}
SMALLER = CONFIG | {"sweep": {"T": [200, 220]}}
ONE_BY_ONE = CONFIG | {"execution": {"block_points": 1, "workers": 1}}


def test_the_file_holds_the_returned_result(tmp_path: Path) -> None:
    path = tmp_path / "a.nc"
    ds = run(CONFIG, output=path)
    assert content_hash(ds) == content_hash(open_result(path)) == content_hash(run(CONFIG))


def test_a_file_grows(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "a.nc"
    run(SMALLER, output=path)
    assert capsys.readouterr() == ("", "")
    grown = run(CONFIG, output=str(path), progress=True)
    assert "2 in" in capsys.readouterr().err
    assert content_hash(grown) == content_hash(run(CONFIG))


def test_a_notebook_gets_no_message_as_an_error(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "a.nc"
    run(CONFIG, output=path)
    monkeypatch.setattr("sweeps.engine.run.is_in_notebook", lambda: True)
    run(CONFIG, output=path, progress=True)
    assert capsys.readouterr() == (f"{path} {messages.COMPLETE_POINTS}\n", "")


def test_existing_results_that_do_not_fit_are_refused_until_overwrite(tmp_path: Path) -> None:
    path = tmp_path / "a.nc"
    run(CONFIG, output=path)
    with pytest.raises(RefusalError, match="no longer has"):
        run(SMALLER, output=path)
    assert run(SMALLER, output=path, overwrite=True).sizes["temperature"] == 2


@pytest.fixture
def interrupted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Raise a signal after the first block."""
    take_in = Recorder.take_in

    def then_signal(self: Recorder, block: Block) -> None:
        take_in(self, block)
        signal.raise_signal(number)

    number = signal.SIGINT
    monkeypatch.setattr(Recorder, "take_in", then_signal)


@pytest.mark.usefixtures("interrupted")
def test_ctrl_c_is_an_exception_and_the_same_call_resumes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.nc"
    # Under nohup the signal is ignored, and stays so.
    with default_signals(), pytest.raises(KeyboardInterrupt, match="the same call continues"):
        run(ONE_BY_ONE, output=path)
    monkeypatch.undo()
    assert content_hash(run(ONE_BY_ONE, output=path)) == content_hash(run(CONFIG))


def test_a_sweep_that_fails_altogether_stops_with_a_reason(tmp_path: Path) -> None:
    hopeless = ONE_BY_ONE | {"integrator": {"max_steps": 1}}
    with pytest.raises(StoppedError, match=rf"{messages.ALL_FAILED} \(1 point\)"):
        run(hopeless, output=tmp_path / "a.nc")


def test_a_config_may_be_computed_elsewhere_than_it_says() -> None:
    elsewhere = run(from_mapping(CONFIG), workers=2, backend="loky")
    assert content_hash(elsewhere) == content_hash(run(CONFIG))


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ({"workers": 0}, ConfigError, "run.*execution.workers: must be at least 1"),
        ({"backend": "gpu"}, ConfigError, "execution.backend: must be"),
        ({"scheduler": ""}, ConfigError, "must be an address such as tcp://"),
        ({"scheduler": "tcp://h:1", "backend": "loky"}, ConfigError, "belongs to `backend: dask`"),
        ({"overwrit": True}, TypeError, "unexpected keyword argument 'overwrit'"),
        ({"overwrite": True}, TypeError, "without output= no results exist"),
        ({"output": "a.nc", "on_block": print}, TypeError, "works only without output="),
    ],
)
def test_arguments_that_make_no_sense_are_refused(
    arguments: dict[str, Any], error: type[Exception], message: str
) -> None:
    with pytest.raises(error, match=message):
        run(CONFIG, **arguments)


def test_a_config_with_problems_is_refused() -> None:
    with pytest.raises(ConfigError, match=messages.UNSTABLE):
        run({"integrator": {"method": "euler-cromer", "dt": 1e-3}})


def test_progress_in_memory_is_shown_on_request(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sweeps.engine.progress.SECONDS_BETWEEN_LINES", 0.0)
    run(ONE_BY_ONE, progress=True)
    assert "/4 points, 0 failed" in capsys.readouterr().err


def test_a_terminal_that_is_gone_changes_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Gone(io.StringIO):
        def write(self, _: str) -> int:
            raise OSError(5, "Input/output error")

    expected = content_hash(run(CONFIG))
    monkeypatch.setattr(sys, "stderr", Gone())
    for output in (None, tmp_path / "a.nc"):
        assert content_hash(run(CONFIG, output=output, progress=True)) == expected
