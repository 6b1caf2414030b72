"""Every verb that writes: killed and repeated, run twice at once, and next to files of others."""

from __future__ import annotations

import os
import random
import shutil
import signal
import time
from collections.abc import Callable, Collection, Iterable
from pathlib import Path
from typing import Any, NamedTuple

import netCDF4
import numpy as np
import pytest
from support import messages
from support.marks import marked, one_then
from support.sweeps.processes import HANGS
from support.sweeps.sweeping import Mishap, Shell, child, entries, hash_of

from stickslip import stationary_orbits
from sweeps import run
from sweeps.files import attributes, outputs
from sweeps.files.netcdf import open_result
from sweeps.files.outputs import same_content
from sweeps.files.run_folder import RunFolder

LOOSE: dict[str, Any] = {"integrator": {"rtol": 1e-4}, "stationary": {"rtol": 1e-4}}
AXES = {"T": {"linspace": [230, 300], "num": 5}, "omega": {"linspace": [20, 60], "num": 4}}
A_YAML = """\
model: {T: 250, gamma: 0}
integrator: {rtol: 1e-4}
simulation: {periods: 1, samples_per_period: 50}
"""


BOX_YAML = """\
model: {gamma: 0}
sample: {sobol: 4, temperature: [280, 300], k: [2e4, 1e5]}
integrator: {rtol: 1e-4}
"""


class Verb(NamedTuple):
    """A command, its files, the main one first, and options that change what it writes.

    If `renews` is true, the command replaces its older files without --overwrite.
    """

    line: str
    files: tuple[str, ...]
    other: str = ""
    renews: bool = False

    @property
    def command(self) -> list[str]:
        return self.line.split()


VERBS = {
    "new": Verb("new f.yaml", ("f.yaml",), "--kind map"),
    "simulate": Verb("simulate a.yaml -o s.nc", ("s.nc",), "--set T=260"),
    "boundary": Verb("boundary map.nc --accuracy 1e-2 -o b.nc", ("b.nc",), "--kind orbit"),
    "boundary as a table": Verb(
        "boundary map.nc --accuracy 1e-2 -o b.csv", ("b.csv", "b.columns.csv"), "--kind orbit"
    ),
    "export": Verb("export map.nc -o t.csv", ("t.csv", "t.columns.csv")),
    "merge": Verb("merge 1.nc 2.nc -o m.nc", ("m.nc",)),
    "fit": Verb(
        "fit d.csv --free k=1e4:2e5 -o f.nc",
        ("f.nc", "f.yaml", "f.png", "f.pdf"),
        "--set K=2900",
    ),
    "sensitivity": Verb(
        "sensitivity box.yaml -o i.nc", ("i.nc", "i.png", "i.pdf"), "--confidence 0.9"
    ),
    "plot": Verb("plot map.nc", ("map.png", "map.pdf"), "--log x", renews=True),
    "report": Verb("report map.nc --orbits 1", ("map.html",), "--at T=230", renews=True),
    "replay": Verb(
        "replay map.nc --at T=247.5 --at omega=20",
        ("map-replay.nc", "map-replay.png", "map-replay.pdf"),
        "--periods 2",
        renews=True,
    ),
    "figure": Verb("figure 2 -o .", ("fig2.nc", "fig2.png", "fig2.pdf")),
}
QUICK = ("new",)
"""The verb whose kills are in the suite; `make faults` kills all others."""
READILY = ("new", "export", "simulate")
"""The verbs for tests of a second or so; pictures take longer."""
KNOWING = [name for name, verb in VERBS.items() if not verb.renews]
"""The verbs that recognise their files, and refuse all others."""


def readily(verbs: Iterable[str], quick: Collection[str] = READILY) -> list[Any]:
    """All verbs; those that are not `quick` are left to `make faults`."""
    return [*quick, *marked("faults", [name for name in verbs if name not in quick])]


@pytest.fixture(scope="module")
def inputs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a map, its two parts, and a table of measurements."""
    folder = tmp_path_factory.mktemp("inputs")
    whole = LOOSE | {"sweep": AXES}
    run(whole, output=folder / "map.nc")
    T = [170.0, 240.0, 280.0]
    force = stationary_orbits({"T": T, "k": 7e4}).friction_force_amplitude.values
    rows = zip(T, (force * np.array([1.01, 0.99, 1.0])).tolist(), strict=True)
    (folder / "box.yaml").write_text(BOX_YAML)
    (folder / "d.csv").write_text("T,F_max\n" + "".join(f"{t},{f!r}\n" for t, f in rows))
    return folder


@pytest.fixture
def shell(shell: Shell, inputs: Path) -> Shell:
    for path in inputs.iterdir():
        shutil.copy2(path, path.name)
    return shell


@pytest.fixture(autouse=True)
def bokeh_is_there(request: pytest.FixtureRequest) -> None:
    if "report" in request.node.name:
        pytest.importorskip("bokeh", reason="bokeh is not installed")
    if "fit" in request.node.name:
        pytest.importorskip("uncertainties", reason="uncertainties is not installed")


def with_parts(shell: Shell, name: str) -> Verb:
    """The verb; for a merge, its parts are computed first."""
    if name == "merge":
        Path("m.yaml").write_text(
            "sweep: {T: [230, 250, 270], omega: [20, 40]}\nintegrator: {rtol: 1e-4}\n"
        )
        for number in (1, 2):
            part = ("--part", f"{number}/2", "-o", f"{number}.nc")
            shell.ok("sweep", "m.yaml", *part)
    return VERBS[name]


def contents(verb: Verb) -> dict[str, Any]:
    """The contents of a verb's files, without times in NetCDF files; None for a missing file."""
    return {name: content(Path(name)) for name in verb.files}


def content(path: Path) -> Any:
    if not path.exists():
        return None
    return hash_of(path) if path.suffix == ".nc" else path.read_bytes()


def require_same(found: dict[str, Any], expected: dict[str, Any], what: str = "") -> None:
    """Fail at the first file with other contents, showing the first place that differs."""
    for name, wanted in expected.items():
        own = found[name]
        if own != wanted and isinstance(own, bytes):
            pairs = enumerate(zip(own, wanted, strict=False))
            first = next((at for at, (one, other) in pairs if one != other), len(wanted))
            near = slice(max(first - 100, 0), first + 100)
            own, wanted = own[near], wanted[near]
        assert own == wanted, (what, name)


def undisturbed(shell: Shell, verb: Verb) -> dict[str, Any]:
    """The contents of the files after an undisturbed command; the files are then removed."""
    shell.ok(*verb.command)
    expected = contents(verb)
    assert None not in expected.values()
    for name in verb.files:
        Path(name).unlink()
    return expected


# --- complete outputs, and files of others ---


@pytest.mark.slow
@pytest.mark.parametrize("name", readily(VERBS))
def test_a_repeated_command_ends_well_and_harms_nothing(shell: Shell, name: str) -> None:
    verb = with_parts(shell, name)
    shell.ok(*verb.command)
    before, names = contents(verb), entries()
    assert not [name for name in names if name.endswith((".run", ".tmp", ".new"))]
    again = shell.ok(*verb.command)
    assert (contents(verb), entries()) == (before, names)
    assert [line for line in again.out.splitlines() if line in verb.files] == [*verb.files]
    said = f"{verb.files[0]} {messages.COMPLETE}\n"
    if name in KNOWING and name != "figure":
        assert again.err.endswith(said)
    if verb.other:
        other = shell(*verb.command, *verb.other.split())
        assert other.code == (0 if verb.renews else 2), other.err
        assert (contents(verb) != before) == verb.renews
        assert entries() == names


@pytest.mark.slow
@pytest.mark.parametrize("name", readily(VERBS))
def test_a_file_of_somebody_else_is_replaced_only_with_overwrite(shell: Shell, name: str) -> None:
    verb = with_parts(shell, name)
    before = entries()
    for file in verb.files:
        Path(file).write_bytes(b"mine")
        done = shell(*verb.command)
        way_out = "choose another name" if name == "new" else "--overwrite replaces it"
        assert done.code == 2, done.err
        assert f"{file} already exists; {way_out}" in done.err
        assert Path(file).read_bytes() == b"mine"
        Path(file).unlink()
        assert entries() == before
    if name != "new":
        Path(verb.files[-1]).write_bytes(b"mine")
        done = shell.ok(*verb.command, "--overwrite")
        assert b"mine" not in contents(verb).values()


@pytest.mark.slow
@pytest.mark.parametrize("name", readily(VERBS))
@pytest.mark.parametrize(
    ("late", "option"),
    one_then(
        "faults", [(True, []), (False, []), (True, ["--overwrite"]), (False, ["--overwrite"])]
    ),
)
def test_a_file_that_appears_meanwhile_is_left_alone(
    shell: Shell, monkeypatch: pytest.MonkeyPatch, name: str, late: bool, option: list[str]
) -> None:
    if name == "new" and option:
        pytest.skip("new has no --overwrite")
    verb, file = with_parts(shell, name), Path(VERBS[name].files[-1])
    with monkeypatch.context() as patch:
        if late:  # between the last look and the name
            appears_before(patch, outputs, "appear", file)
        else:
            appears_before(patch, outputs.Outputs, "_try_writing", file)
        done = shell(*verb.command, *option)
    assert done.code == 5, done.err
    assert f"{file} {messages.CHANGED_BY_OTHERS} this command, and is left alone" in done.err
    assert file.read_bytes() == b"mine"
    file.unlink()
    if name in KNOWING:
        monkeypatch.setattr(outputs, "begin", None)  # kept files are not made again
        done = shell.ok(*verb.command, *option)
        assert None not in contents(verb).values()
        assert f"{verb.files[0]}.run" not in entries()


def appears_before(patch: pytest.MonkeyPatch, owner: Any, function: str, file: Path) -> None:
    """Make somebody else's file appear just before a function is called."""
    real = getattr(owner, function)

    def disturbed(*arguments: Any) -> Any:
        file.write_bytes(b"mine")
        return real(*arguments)

    patch.setattr(owner, function, disturbed)


@pytest.mark.parametrize("name", VERBS)
def test_an_output_in_use_is_refused(shell: Shell, name: str) -> None:
    verb = with_parts(shell, name)
    main = "fig2.nc" if name == "figure" else verb.files[0]
    with RunFolder(Path(main)).held():
        done = shell(*verb.command)
    assert done.code == 4, done.err
    assert f"{main} {messages.IN_USE} (process " in done.err
    assert not Path(main).exists()


def test_files_left_by_another_command_are_not_dropped_silently(
    shell: Shell, monkeypatch: pytest.MonkeyPatch
) -> None:
    verb = VERBS["simulate"]
    with monkeypatch.context() as patch:
        appears_before(patch, outputs, "appear", Path("s.nc"))
        assert shell(*verb.command).code == 5
    Path("s.nc").unlink()
    other = [*verb.command, *verb.other.split()]
    done = shell(*other)
    assert done.code == 2
    assert "was stopped before s.nc was in place: stickslip simulate a.yaml -o s.nc; " in done.err
    shell.ok(*other, "--overwrite")
    assert entries() == sorted(["a.yaml", "box.yaml", "d.csv", "map.nc", "s.nc"])


@pytest.mark.parametrize("name", ["simulate", "merge"])
def test_a_netcdf_file_is_recognised_whatever_its_ending(
    shell: Shell, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    command = [*with_parts(shell, name).command[:-1], "file.dat"]
    for second in range(2):
        monkeypatch.setattr(attributes, "now", lambda n=second: f"2026-01-01T00:00:0{n}Z")
        done = shell.ok(*command)
    assert done.err.endswith(f"file.dat {messages.COMPLETE}\n")
    assert open_result(Path("file.dat")).history.startswith("2026-01-01T00:00:00Z ")


def test_an_edited_file_is_not_called_complete(shell: Shell) -> None:
    verb = VERBS["simulate"]
    shell.ok(*verb.command)
    with netCDF4.Dataset("s.nc", "a") as file:
        file["friction_force"][3] += 1e-12
    edited = Path("s.nc").read_bytes()
    done = shell(*verb.command)
    assert (done.code, Path("s.nc").read_bytes()) == (2, edited)


def test_a_replay_does_not_replace_the_result_of_a_sweep(shell: Shell) -> None:
    shutil.copy("map.nc", "days.nc")
    done = shell("replay", "map.nc", "--at", "T=230", "--at", "omega=20", "-o", "days.nc")
    assert done.code == 2
    assert "days.nc already exists" in done.err
    assert hash_of("days.nc") == hash_of("map.nc")


def test_a_sweep_that_can_be_resumed_keeps_its_output(shell: Shell) -> None:
    folder = RunFolder(Path("s.nc"))
    folder.path.mkdir()
    folder.journal.write_bytes(b"points")
    done = shell(*VERBS["simulate"].command, "--overwrite")
    assert done.code == 2
    assert f"a sweep to s.nc {messages.RESUMABLE}" in done.err
    assert folder.journal.read_bytes() == b"points"


# --- names ---


@pytest.mark.parametrize("name", ["simulate", *marked("faults", ["new", "export", "plot"])])
def test_a_link_to_a_file_that_is_not_there_yet_is_written_through(
    shell: Shell, name: str, tmp_path_factory: pytest.TempPathFactory
) -> None:
    verb, elsewhere = VERBS[name], tmp_path_factory.mktemp("elsewhere")
    for file in verb.files:
        Path(file).symlink_to(elsewhere / file)
    shell.ok(*verb.command)
    for file in verb.files:
        assert Path(file).is_symlink()
    assert entries(elsewhere) == sorted(verb.files)
    Path(verb.files[0]).unlink()
    Path(verb.files[0]).symlink_to("missing/file")
    done = shell(*verb.command)
    assert done.code == 5
    assert f"cannot write {verb.files[0]}: it is a link to " in done.err


def test_a_sweep_writes_through_a_link_to_a_file_that_is_not_there_yet(shell: Shell) -> None:
    Path("x.nc").symlink_to("y.nc")
    shell.ok("sweep", "a.yaml", "-o", "x.nc")
    assert Path("x.nc").is_symlink()
    assert hash_of("y.nc") == hash_of("x.nc")


ODD = os.fsdecode(b"odd\xff")


@pytest.mark.parametrize(
    "line",
    [
        "sweep a.yaml -o {}.nc",
        "sweep {}.yaml",
        "check {}.yaml",
        "simulate -o {}.nc",
        "new {}.yaml",
        "info {}.nc",
        "fit {}.csv --free k",
        "plot map.nc -o {}.png",
        "export map.nc -o {}.csv",
        "sweep a.yaml --set output={}.nc",
    ],
)
def test_a_name_that_is_not_utf_8_is_refused(shell: Shell, line: str) -> None:
    before = entries()
    done = shell(*(word.format(ODD) for word in line.split()))
    assert (done.code, done.out) == (2, "")
    assert "odd\\udcff" in done.err
    assert "must be UTF-8" in done.err
    assert entries() == before


@pytest.mark.faults
def test_a_folder_whose_name_is_not_utf_8_may_hold_all_but_netcdf(shell: Shell) -> None:
    names = entries()
    Path(ODD).mkdir()
    for name in names:
        shutil.copy(name, ODD)
    os.chdir(ODD)
    for name in ("new", "export", "plot"):
        done = shell.ok(*VERBS[name].command)
    done = shell(*VERBS["simulate"].command)
    assert done.code == 2
    assert "s.nc lies in a folder whose name is not UTF-8" in done.err
    shell.ok("sweep", "a.yaml", "-o", "x.nc")


# --- kills ---


def places(verb: Verb) -> dict[str, Mishap]:
    """Where a command is killed."""
    of, count = "sweeps.files.outputs", len(verb.files)
    note = {
        "before the note": Mishap(f"{of}:Outputs", "_note"),
        "before the note has its name": Mishap("pathlib:Path", "replace", of="manifest"),
        "after the note": Mishap(f"{of}:Outputs", "_note", when="after"),
    }
    names = {
        f"before name {number}": Mishap(of, "appear", number) for number in range(1, count + 1)
    }
    return {
        "before a file is made": Mishap(of, "begin"),
        "before the last file is made": Mishap(of, "begin", count),
        **({} if verb.renews else note),
        **names,
        "after all names": Mishap(of, "appear", count, when="after"),
        "before the note is taken away": Mishap(f"{of}:Outputs", "_discard", 2),
        "at the end": Mishap("sweeps.files.run_folder:RunFolder", "remove", when="after"),
    }


def killed_and_given_again(
    shell: Shell, verb: Verb, expected: dict[str, Any], kill: Callable[[], str]
) -> None:
    """Kill the command, look at what is there, and run it again."""
    what = kill()
    left = contents(verb)
    there = {name: expected[name] for name, held in left.items() if held is not None}
    require_same(left, there, what)
    done = shell(*verb.command)
    assert done.code == 0, (what, done.err)
    require_same(contents(verb), expected, what)
    for name in verb.files:
        Path(name).unlink()


@pytest.mark.slow
@pytest.mark.parametrize("name", readily(VERBS, QUICK))
def test_the_same_command_repairs_a_kill_at_any_place(shell: Shell, name: str) -> None:
    verb = with_parts(shell, name)
    expected = undisturbed(shell, verb)
    before = entries()
    for place, mishap in list(places(verb).items()):

        def kill(place: str = place, mishap: Mishap = mishap) -> str:
            process = child(verb.command, mishap, log="../messages")
            process.join(HANGS)
            if process.exitcode != -signal.SIGKILL:  # this verb has no such file
                assert process.exitcode == 0, (place, Path("../messages").read_text())
                assert name == "merge"
                assert "file is made" in place
            return place

        killed_and_given_again(shell, verb, expected, kill)
        assert entries() == before, place


RANDOM_KILLS = {"fit": 20, "boundary": 10, "simulate": 10, "new": 30, "merge": 10, "export": 10}
"""The number of kills; `benchmarks/bench_faults.py` has more."""


@pytest.mark.faults
@pytest.mark.parametrize("name", RANDOM_KILLS)
def test_the_same_command_repairs_kills_at_random_times(shell: Shell, name: str) -> None:
    verb, draw = with_parts(shell, name), random.Random(5)
    begun = time.monotonic()
    child(verb.command, log="../messages").join(HANGS)
    longest = 1.1 * (time.monotonic() - begun)
    expected = undisturbed(shell, verb)
    for _ in range(RANDOM_KILLS[name]):

        def kill() -> str:
            late = draw.uniform(0.0, longest)
            process = child(verb.command, log="../messages")
            time.sleep(late)
            process.kill()
            process.join(HANGS)
            return f"killed after {late:.3f} s"

        killed_and_given_again(shell, verb, expected, kill)


@pytest.mark.faults
@pytest.mark.parametrize("name", VERBS)
def test_of_two_at_once_one_works_and_nothing_is_lost(shell: Shell, name: str) -> None:
    verb, draw = with_parts(shell, name), random.Random(9)
    expected = undisturbed(shell, verb)
    for number in range(5):
        both = []
        for each in range(2):
            both.append(child(verb.command, log=f"../{number}.{each}"))
            time.sleep(draw.uniform(0.0, 0.2))
        for process in both:
            process.join(HANGS)
        said = [Path(f"../{number}.{each}").read_text() for each in range(2)]
        codes = sorted(process.exitcode for process in both)
        assert codes in ([0, 0], [0, 4]), said
        require_same(contents(verb), expected)
        for file in verb.files:
            Path(file).unlink()


# --- the same content ---


def test_files_are_the_same_apart_from_their_time(tmp_path: Path) -> None:
    ds = run(LOOSE | {"sweep": {"T": [200, 250]}})
    paths = [tmp_path / name for name in ("a.nc", "b.nc", "c.nc", "d.nc")]
    ds.to_netcdf(paths[0])
    ds.assign_attrs(history="another time").to_netcdf(paths[1])
    ds.assign_attrs(title="another title").to_netcdf(paths[2])
    paths[3].write_bytes(b"no NetCDF")
    assert [same_content(paths[0], path) for path in paths] == [True, True, False, False]
    assert not same_content(paths[3], paths[0])


def test_tables_are_the_same_apart_from_the_time_of_their_borders(
    shell: Shell, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("pyarrow", reason="pyarrow is not installed")
    command = ["boundary", "map.nc", "--accuracy", "1e-2", "-o", "b.parquet"]
    shell.ok(*command)
    before = Path("b.parquet").read_bytes()
    monkeypatch.setattr("sweeps.files.attributes.now", lambda: "another time")
    done = shell(*command)
    assert (done.code, Path("b.parquet").read_bytes()) == (0, before)
    assert f"b.parquet {messages.COMPLETE}" in done.err
    assert shell(*command, "--kind", "orbit").code == 2
