"""The files of a command that writes: checked first, made elsewhere, named at the end.

Every command except the sweep, which has a journal, follows one rule. It takes the lock of its
first file and checks all names that it will write. It makes all files in the folder of the lock and
notes their hashes there. Only then does it give the files their names, and never replaces a file
that it must not. If it is killed, the same command recognises the files by their hashes and
finishes.
"""

from __future__ import annotations

import contextlib
import filecmp
import hashlib
import itertools
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from stickslip.compiled.cache import source_hash
from sweeps.exits import ExpectedError, StorageError
from sweeps.files.atomic import (
    appear,
    begin,
    fingerprint,
    flush,
    followed,
    refuse_odd_output,
    remove,
    settle_mode,
    storage_errors,
)
from sweeps.files.attributes import command_line
from sweeps.files.netcdf import content_hash, open_result, write_checked
from sweeps.files.run_folder import RunFolder

if TYPE_CHECKING:
    import xarray as xr

WAYS_OUT = "--overwrite replaces it, -o writes elsewhere"
"""The end of a message about an existing output."""

SEAL = "request_sha256"
"""The attribute of a file by which the command that wrote it recognises it."""

_TRIAL = 1 << 14  # bytes; fewer may fit into the last block of a full disk

# Endings of files that hold no request: tables, and configs.
_TABLES = (".csv", ".parquet", ".yaml", ".yml")

Writer = Callable[[Path], object]


class RefusalError(ExpectedError):
    """Existing results do not fit the request; the message names the option that decides."""


class Outputs:
    """The files that a command writes, in the order in which it prints them.

    Parameters
    ----------
    paths
        The files. The first is the main one: it is locked, and gets its name last.
    request
        The JSON data that determine the contents. Without them the files are quick to make again,
        and a killed command keeps nothing.
    overwrite
        Replace existing files.
    inputs
        Files that must not be written.
    replaces
        Returns whether an existing file is an older one of the same kind, made by this program;
        such a file is always replaced.
    like
        New files get at most the permissions of this file.
    compares
        Make the files even if they exist, to see whether they would be the same. By default only
        for tables and texts: a NetCDF file holds the request that it was written for, which saves
        minutes of needless work.
    ways_out
        What the user can do about an existing file.
    """

    def __init__(
        self,
        paths: Sequence[Path],
        request: Mapping[str, Any] | None = None,
        *,
        overwrite: bool = False,
        inputs: Sequence[Path | None] = (),
        replaces: Callable[[Path], bool] = lambda _: False,
        like: Path | None = None,
        compares: bool | None = None,
        ways_out: str = WAYS_OUT,
    ) -> None:
        self.paths, self.main, self.folder = list(paths), paths[0], RunFolder(paths[0])
        self._request = None if request is None else _key(request, self.paths)
        self._overwrite, self._inputs, self._like = overwrite, inputs, like
        self._older, self._ways_out = replaces, ways_out
        is_table = self.main.suffix.lower() in _TABLES and request is not None
        self._compares = is_table if compares is None else compares
        self._before: dict[Path, list[int] | None] = {}
        self._replaced: set[Path] = set()
        self._recalled: xr.Dataset | None = None
        self.complete = False
        """Whether all files already existed with the right contents."""
        self.finished = False
        """Whether an earlier run had made all files, and they have their names now."""

    @contextlib.contextmanager
    def held(self) -> Iterator[Self]:
        """Check the outputs, and hold them until the files have their names.

        Raises RefusalError, InUseError and StorageError before anything is computed.
        """
        self._refuse_folder()
        for path in self.paths:
            refuse_odd_output(path)
            inputs = [file for file in self._inputs if file and file.exists()]
            if path.exists() and any(path.samefile(file) for file in inputs):
                raise RefusalError(f"{path} is also an input; choose another -o")
        with self.folder.held():
            self._refuse_unfinished()
            self._before = {path: fingerprint(path) for path in self.paths}
            there = [path for path in self.paths if path.exists()]
            self._replaced = {path for path in there if self._overwrite or self._older(path)}
            self.finished = self._request is not None and self._finish()
            if not self.finished:
                # An existing file may already have the right contents.
                taken = [path for path in there if path not in self._replaced]
                if taken and not self._compares and self.recalled() is None:
                    raise self._taken(taken[0])
                self._discard()
                self._try_writing()
            yield self

    def release(self) -> None:
        """Remove unneeded files before the process ends within `held`."""
        self.folder.remove()

    def recalled(self) -> xr.Dataset | None:
        """Return the contents of the main file if the same command wrote it, else None.

        With `overwrite` only a file that an earlier run had finished counts.
        """
        if self._overwrite and not self.finished:
            return None
        # A NetCDF file may have any ending.
        if self._recalled is None and self._request is not None and self.main.is_file():
            with contextlib.suppress(StorageError):
                ds = open_result(self.main)
                if ds.attrs.get(SEAL) == _seal(self._request, ds):
                    self._recalled = ds
        return self._recalled

    def dataset(self, ds: xr.Dataset, groups: Mapping[str, xr.Dataset] | None = None) -> Writer:
        """Return the function that writes a Dataset, sealed so that `recalled` recognises it.

        `groups` hold parts of it in other forms, for other programs.
        """
        if self._request is not None:
            ds = ds.assign_attrs({SEAL: _seal(self._request, ds)})
        return lambda path: write_checked(ds, path, groups or {})

    def write(self, contents: Mapping[Path, bytes | Writer]) -> None:
        """Make all files from their `contents`, and give them their names.

        An existing file with the same content stays as it is. Raises StorageError, and RefusalError
        if another file exists that must not be replaced.
        """
        if self.finished:
            return
        for path, content in contents.items():
            with storage_errors(f"cannot write {path}", followed(path).parent):
                place = self.place(path)
                begin(place)
                if isinstance(content, bytes):
                    place.write_bytes(content)
                else:
                    content(place)
        self.show()

    def place(self, path: Path) -> Path:
        """Return the place to make a file: in the folder of the lock, or beside a link's target."""
        target = followed(path)
        if target.parent == self.folder.path.parent:
            self.folder.made.mkdir(mode=0o700, exist_ok=True)
            return self.folder.made / target.name
        return target.with_name(f".{target.name}.new")

    def show(self) -> None:
        """Give the files made in their `place` their names."""
        fixed = [path for path in self.paths if path not in self._replaced and path.exists()]
        same = [path for path in fixed if same_content(self.place(path), path)]
        for path in fixed:
            if path not in same and self._before[path] is not None:
                raise self._taken(path)
        missing = [path for path in self.paths if path not in same]
        if missing and self._request is not None:
            self._note()
        self._name(missing)
        self._discard()
        self.complete = not missing

    # --- existing files ---

    def _refuse_folder(self) -> None:
        try:
            str(self.main.absolute()).encode()
        except UnicodeEncodeError:
            if self.main.suffix == ".nc":
                raise RefusalError(
                    f"{self.main} lies in a folder whose name is not UTF-8, which NetCDF requires; "
                    "-o writes elsewhere"
                ) from None

    def _refuse_unfinished(self) -> None:
        """Raise RefusalError if an earlier command to this output can still be finished."""
        if self.folder.journal.exists():
            raise RefusalError(
                f"a sweep to {self.main} was interrupted and can be resumed, or its journal was "
                "kept; finish it without --keep-journal, or choose another -o"
            )
        left = self._left()
        if left and left["request"] != self._request and not self._overwrite:
            raise RefusalError(
                f"an earlier command was stopped before {self.main} was in place: "
                f"{left['command']}; run it again to finish it, or choose another -o; "
                "--overwrite drops what it had computed"
            )

    def _taken(self, path: Path) -> RefusalError:
        return RefusalError(f"{path} already exists; {self._ways_out}")

    # --- files left by an earlier run ---

    def _finish(self) -> bool:
        """Give files finished by an earlier run their names; return whether there were any."""
        left = self._left()
        if not left or left["request"] != self._request:
            return False
        known = {path: left["files"].get(path.name) for path in self.paths}
        named = [path for path in self.paths if sha256_of(path) == known[path] is not None]
        self._replaced.update(named)  # these are ours, whatever is written now
        missing = [path for path in self.paths if path not in named]
        if any(sha256_of(self.place(path)) != known[path] for path in missing):
            return False
        for path in missing:
            if path.exists() and path not in self._replaced:
                raise self._taken(path)
        self._name(missing)
        self._discard()
        self.complete = not missing
        return True

    def _left(self) -> dict[str, Any]:
        """Return the note of an earlier run; empty if it is missing or damaged."""
        try:
            left = json.loads(self.folder.manifest.read_text(encoding="utf-8"))
            return left if isinstance(left["files"], dict) and left["command"] is not None else {}
        except (OSError, ValueError, LookupError, TypeError, RecursionError):
            return {}

    def _note(self) -> None:
        """Note the hashes of the files that are about to get their names."""
        files = {path.name: sha256_of(self.place(path)) for path in self.paths}
        note = {"request": self._request, "command": command_line(), "files": files}
        with storage_errors(f"cannot write into {self.folder.path}", self.folder.path):
            for path in self.paths:
                flush(self.place(path))
            begun = self.folder.manifest.with_suffix(".new")
            begun.write_text(json.dumps(note), encoding="utf-8")
            flush(begun)
            begun.replace(self.folder.manifest)
            flush(self.folder.path)

    def _discard(self) -> None:
        remove(self.folder.manifest)
        for path in self.paths:
            remove(self.place(path))

    # --- names ---

    def _try_writing(self) -> None:
        """Raise StorageError if nothing can be written, before rather than after a computation."""
        trial = self.place(self.main)
        with storage_errors(f"cannot write {self.main}", self.folder.path):
            try:
                trial.write_bytes(bytes(_TRIAL))
                flush(trial)
            finally:
                remove(trial)

    def _name(self, paths: Sequence[Path]) -> None:
        """Give files their names, the main one last: if it exists, all do."""
        for path in reversed(paths):
            place, target = self.place(path), followed(path)
            with storage_errors(f"cannot write {path}", target.parent):
                if fingerprint(path) != self._before[path]:
                    raise self._appeared(path)
                settle_mode(place, target, self._like)
                if path in self._replaced:
                    place.replace(target)
                    continue
                try:
                    appear(place, target)
                except FileExistsError:
                    raise self._appeared(path) from None
        if self._request is not None:
            with storage_errors(f"cannot write {self.main}", self.folder.path.parent):
                for folder in {followed(path).parent for path in paths}:
                    flush(folder)

    def _appeared(self, path: Path) -> StorageError:
        kept = f"; the computed files are kept in {self.folder.path}" if self._request else ""
        return StorageError(
            f"{path} was created or changed by something else during this command, and is left "
            f"alone{kept}. Move {path.name} away and run the same command again, or choose "
            "another -o"
        )


def same_content(one: Path, other: Path) -> bool:
    """Return whether two files have the same contents, apart from their history."""
    if filecmp.cmp(one, other, shallow=False):
        return True
    try:
        same = _same_tables if one.suffix.lower() == ".parquet" else _same_datasets
        return same(one, other)
    except (StorageError, OSError, ValueError):  # damaged, or of another format
        return False


def _same_datasets(one: Path, other: Path) -> bool:
    with open_result(one, whole=False) as ds, open_result(other, whole=False) as there:
        return content_hash(ds) == content_hash(there)


def _same_tables(one: Path, other: Path) -> bool:
    from pyarrow.parquet import ParquetFile

    with ParquetFile(one) as table, ParquetFile(other) as there:
        about = [dict(each.schema_arrow.metadata or {}) for each in (table, there)]
        for attributes in about:
            attributes.pop(b"history", None)
        if about[0] != about[1] or not table.schema_arrow.equals(there.schema_arrow):
            return False
        batches = itertools.zip_longest(table.iter_batches(), there.iter_batches())
        return all(own is not None and own.equals(its) for own, its in batches)


def _key(request: Mapping[str, Any], paths: Sequence[Path]) -> str:
    """Return the SHA-256 of everything that determines the contents of files, as hex."""
    whole = {
        "request": dict(request),
        "names": [path.name for path in paths],
        "version": metadata.version("stickslip"),
        "code": source_hash(),
    }
    return hashlib.sha256(json.dumps(whole, sort_keys=True).encode()).hexdigest()


def _seal(key: str, ds: xr.Dataset) -> str:
    """Return the SHA-256 of a request's key and the contents of a file, as hex."""
    bare = ds.copy()
    bare.attrs = {name: value for name, value in ds.attrs.items() if name != SEAL}
    return hashlib.sha256(f"{key}{content_hash(bare)}".encode()).hexdigest()


def sha256_of(path: Path) -> str | None:
    """Return the SHA-256 of a file as hex; None if there is no file."""
    if not path.is_file():
        return None
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
