"""Compiled code that another user of the machine puts where ours is looked for."""

from __future__ import annotations

import os
import pickle
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

from faults.arena import Arena, Tally, ended, sweep_afresh
from stickslip.compiled.cache import cache_folder, source_hash

_STRANGER = 65534  # the uid and gid of nobody


def run(quick: bool, folder: Path) -> dict[str, Tally]:
    """Let another user fill the folder of compiled code with what would run as us."""
    tally = Tally()
    if os.geteuid() != 0 or shutil.which("setpriv") is None:
        print("  planted compiled code: skipped, only root with setpriv can be another user")
        return {"planted compiled code": tally}
    folder.chmod(0o755)  # a temporary folder, into which the stranger must come
    arena = Arena(folder)
    for case in ["own folder"] if quick else CASES:
        _plant(arena, tally, case)
    return {"planted compiled code": tally}


def _plant(arena: Arena, tally: Tally, case: str) -> None:
    """Sweep where another user has been before."""
    with arena.folder() as folder:
        ran, code, shared = (folder.parent / name for name in ("ran", "code", "shared"))
        code.mkdir()
        for path in cache_folder().glob("*.nbi"):
            (code / path.name).write_bytes(pickle.dumps(_Code(ran)))
        shared.mkdir()
        shared.chmod(0o1777)
        CASES[case](code, shared)
        end = ended(folder, sweep_afresh(folder, NUMBA_CACHE_DIR=str(shared)))
        if ran.exists():
            tally.count("wrong", f"{case}: the code ran")
        else:
            arena.judge(tally, case, folder, end)


class _Code:
    """Leaves a file, as soon as its pickle is read."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def __reduce__(self) -> Any:
        return Path.touch, (self._path,)


def _as_stranger(*words: str | Path) -> None:
    user = [f"--reuid={_STRANGER}", f"--regid={_STRANGER}", "--clear-groups"]
    subprocess.run(["setpriv", *user, *words], check=True)


def _names(shared: Path) -> list[Path]:
    """Return the folders in which code of these sources may be looked for."""
    name = f"stickslip-{source_hash()[:16]}"
    return [shared / name, shared / name.replace("-", f"-{os.geteuid()}-")]


def _own_folder(code: Path, shared: Path) -> None:
    for folder in _names(shared):
        _as_stranger("cp", "-r", code, folder)


def _link(code: Path, shared: Path) -> None:
    _as_stranger("cp", "-r", code, shared / "theirs")
    for folder in _names(shared):
        _as_stranger("ln", "-s", shared / "theirs", folder)


def _exchanged(code: Path, shared: Path) -> None:
    """Exchange a folder of ours, where nothing forbids to."""
    shared.chmod(0o777)
    for folder in _names(shared):
        folder.mkdir(mode=0o700)
        _as_stranger("mv", folder, f"{folder}.ours")
    _own_folder(code, shared)


def _open_folder(code: Path, shared: Path) -> None:
    """Write into folders that were made open for all."""
    for folder in _names(shared):
        folder.mkdir()
        folder.chmod(0o777)
        _as_stranger("cp", "-r", f"{code}/.", folder)


CASES: dict[str, Callable[[Path, Path], None]] = {
    "own folder": _own_folder,
    "link": _link,
    "exchanged folder": _exchanged,
    "open folder": _open_folder,
}
