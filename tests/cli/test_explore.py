"""`explore`: its address, its end, and the files that it refuses."""

from __future__ import annotations

import queue
import re
import shutil
import signal
import urllib.error
import urllib.request
from pathlib import Path
from types import SimpleNamespace

import pytest
from support import messages
from support.marks import one_then
from support.sweeps.commands import Command
from support.sweeps.processes import Running

from sweeps.cli import pages
from sweeps.files.netcdf import content_hash, open_result
from sweeps.page.subject import Subject

A_YAML = """\
sweep: {temperature: [200, 250]}
simulation: {periods: 1, samples_per_period: 50}
integrator: {rtol: 1e-4}
"""


@pytest.mark.slow
@pytest.mark.parametrize("number", one_then("faults", [signal.SIGINT, signal.SIGTERM]))
def test_it_prints_one_address_and_ends_on_a_signal(number: signal.Signals) -> None:
    pytest.importorskip("bokeh", reason="bokeh is not installed")
    running = Running("-m", "sweeps.cli", "explore", "--no-browser")
    running.says("\n")
    found = re.fullmatch(r"(http://127\.0\.0\.1:\d+/)\?token=[\w-]{40,}\n", running.out)
    assert found
    with urllib.request.urlopen(running.out.strip(), timeout=60) as page:
        assert page.status == 200
    with pytest.raises(urllib.error.HTTPError, match="403"):
        urllib.request.urlopen(found[1], timeout=60)
    running.signal(number)
    code, out, err = running.ended()
    assert code == 0
    assert out.count("\n") == 1
    assert err.strip() == "Press Ctrl-C to stop."


def test_a_browser_gets_a_file_that_opens_the_page_and_no_token(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    opened: queue.SimpleQueue[str] = queue.SimpleQueue()
    monkeypatch.setattr("webbrowser.open", opened.put)
    address = "http://127.0.0.1:1/?token=secret"
    redirect = pages.open_by_file(address)
    try:
        assert opened.get(timeout=10) == redirect.as_uri()
        assert address in redirect.read_text()
        assert "secret" not in str(redirect)
        assert redirect.parent.stat().st_mode & 0o077 == 0
    finally:
        shutil.rmtree(redirect.parent)


def test_without_bokeh_it_names_the_command(
    command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda _: None)
    code, out, err = command("explore")
    assert (code, out) == (2, "")
    assert err == "bokeh is not installed; try: pip install 'bokeh>=3.9'\n"


def test_unusable_files_are_refused(command: Command) -> None:
    pytest.importorskip("bokeh", reason="bokeh is not installed")
    assert command("explore", "b.nc") == (5, "", "b.nc does not exist\n")
    assert command("explore", "b.yaml").code == 2
    Path("b.nc").write_text("no file")
    code, _, err = command("explore", "b.nc")
    assert code == 5
    assert err.startswith(f"b.nc {messages.NOT_NETCDF}")


@pytest.mark.stress
def test_the_command_for_a_point_of_a_slice_names_the_slice(
    command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without it, the command would match several points."""
    pytest.importorskip("bokeh", reason="bokeh is not installed")
    from sweeps.page.document import served

    pages_shown: list[str] = []

    def server_of(subject: Subject, port: int) -> SimpleNamespace:
        pages_shown.append(served(subject).decode())
        return SimpleNamespace(address="", run_until_signal=lambda _: None)

    monkeypatch.setattr("sweeps.page.explorer.server_of", server_of)
    command.ok("sweep", "a.yaml", "--set", "K=[500, 1000]", "-o", "map.nc")
    command.ok("explore", "map.nc", "--at", "T=250", "--no-browser")
    assert '"replay":"stickslip replay map.nc --at T=250"' in pages_shown[0]
    assert content_hash(open_result(Path("map.nc"))) in pages_shown[0]  # not that of the slice
    command.ok("replay", "map.nc", "--at", "T=250", "--at", "spring_stiffness=500")


def test_a_trajectory_is_no_result_of_a_sweep(command: Command) -> None:
    pytest.importorskip("bokeh", reason="bokeh is not installed")
    command.ok("simulate", "a.yaml", "--set", "temperature=200", "-o", "t.nc")
    code, out, err = command("explore", "t.nc")
    assert (code, out) == (2, "")
    assert err.startswith(f"t.nc: this is {messages.NO_RESULT}")


@pytest.mark.parametrize(
    ("display", "opens"),
    [({}, False), ({"DISPLAY": ":0"}, True), ({"WAYLAND_DISPLAY": "wayland-0"}, True)],
)
def test_a_browser_opens_where_there_is_a_screen(
    monkeypatch: pytest.MonkeyPatch, display: dict[str, str], opens: bool
) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    for name, value in display.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr("sys.platform", "linux")
    assert pages.has_display() is opens
    monkeypatch.setattr("sys.platform", "darwin")
    assert pages.has_display()
