"""A disk whose power may fail: the file operations of a command, replayed up to any moment.

Each write to a file since its last flush may be lost or not, independently of the others. Of the
name changes since the last flush of a folder, all from some point on may be lost: file systems
keep one log of all names, in order.
"""

from __future__ import annotations

import itertools
import os
import random
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import pytest

_ALL, _DRAWN = 10, 1000
_PASSING = ("lock", "heartbeat.json")  # nobody reads them after a power cut

Names = dict[str, int]
Contents = dict[int, bytearray]


class Operation(NamedTuple):
    """An operation on the contents of a numbered file, or on a name in a folder."""

    what: str
    file: int = 0
    place: int = 0
    data: bytes = b""
    name: str = ""
    other: str = ""


class Disk:
    """The files of a folder before a command, and all operations of the command on them."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder.resolve()
        self.names: Names = {}
        self.contents: Contents = {}
        self._times: dict[int, int] = {}
        self._now: Names = {}
        self._handles: dict[int, str] = {}
        self.operations: list[Operation] = []
        for path in sorted(folder.rglob("*")):
            if path.is_file():
                number = len(self.contents)
                self.names[str(path.resolve())] = number
                self.contents[number] = bytearray(path.read_bytes())
                self._times[number] = path.stat().st_mtime_ns
        self._now, self._files = dict(self.names), len(self.contents)

    @contextmanager
    def watching(self) -> Iterator[None]:
        """Record the operations of this process inside the context."""
        with pytest.MonkeyPatch.context() as patch:
            self._watch(patch, os, "open", self._opened)
            self._watch(patch, os, "pwrite", lambda _, h, data, at: self._wrote(h, at, data))
            self._watch(patch, os, "ftruncate", lambda _, h, length: self._cut(h, length))
            self._watch(patch, os, "fsync", lambda _, h: self._flushed(h))
            self._watch(patch, os, "replace", lambda _, a, b: self._named("rename", a, b))
            self._watch(patch, os, "link", lambda _, a, b: self._named("link", a, b))
            self._watch(patch, os, "unlink", lambda _, a, **__: self._named("unlink", a))
            self._watch(patch, Path, "write_bytes", lambda _, p, data: self._filled(p, data))
            self._watch(
                patch, Path, "write_text", lambda _, p, text, **__: self._filled(p, text.encode())
            )
            yield

    def after(self, count: int, left_out: frozenset[int]) -> dict[str, tuple[bytes, int]]:
        """Return the files and their times after `count` operations without those `left_out`."""
        names, contents = dict(self.names), {n: bytearray(c) for n, c in self.contents.items()}
        for number, done in enumerate(self.operations[:count]):
            if number not in left_out:
                _do(done, names, contents)
        return {
            name: (bytes(contents.get(number, b"")), self._times.get(number, 1))
            for name, number in names.items()
            if Path(name).name not in _PASSING
        }

    def unsettled(self, count: int) -> list[int]:
        """Return which of the first `count` operations a failure after them may undo."""
        found: list[int] = []
        for number, done in enumerate(self.operations[:count]):
            if done.what == "flush file":
                found = [n for n in found if self.operations[n].file != done.file or self._names(n)]
            elif done.what == "flush folder":
                found = [n for n in found if not self._names(n)]
            else:
                found.append(number)
        return found

    def failures(self, count: int) -> Iterator[frozenset[int]]:
        """Yield the sets of operations that a power cut after `count` operations may undo."""
        unsettled = self.unsettled(count)
        chosen: Any = itertools.chain.from_iterable(
            itertools.combinations(unsettled, length)
            for length in range(len(unsettled) + 1 if len(unsettled) <= _ALL else 3)
        )
        if len(unsettled) > _ALL:
            draw = random.Random(count)
            drawn = ([n for n in unsettled if draw.random() < 0.5] for _ in range(_DRAWN))
            chosen = itertools.chain(chosen, drawn)
        names = [n for n in unsettled if self._names(n)]
        for some in map(frozenset, chosen):
            gone = [n for n in names if n in some]
            if gone == names[len(names) - len(gone) :]:
                yield some

    # --- recording ---

    def _watch(
        self, patch: pytest.MonkeyPatch, owner: Any, name: str, note: Callable[..., None]
    ) -> None:
        function = getattr(owner, name)

        def watched(*args: Any, **kwargs: Any) -> Any:
            result = function(*args, **kwargs)
            note(result, *args, **kwargs)
            return result

        patch.setattr(owner, name, watched)

    def _opened(self, handle: int, path: Any, flags: int, *_: Any, **__: Any) -> None:
        name = self._name(path)
        self._handles[handle] = name
        if name and flags & os.O_CREAT and name not in self._now:
            self._now[name] = self._files
            self._files += 1
            self._note(Operation("create", self._now[name], name=name))
        elif name and flags & os.O_TRUNC:
            self._note(Operation("cut", self._now[name]))

    def _wrote(self, handle: int, place: int, data: Any) -> None:
        if name := self._handles.get(handle, ""):
            self._note(Operation("write", self._now[name], place, bytes(data)))

    def _cut(self, handle: int, length: int) -> None:
        if name := self._handles.get(handle, ""):
            self._note(Operation("cut", self._now[name], length))

    def _flushed(self, handle: int) -> None:
        name = self._handles.get(handle, "")
        if name in self._now:
            self._note(Operation("flush file", self._now[name]))
        elif name:
            self._note(Operation("flush folder", name=name))

    def _filled(self, path: Path, data: bytes) -> None:
        name = self._name(path)
        if name and name not in self._now:
            self._now[name] = self._files
            self._files += 1
            self._note(Operation("create", self._now[name], name=name))
        if name:
            self._note(Operation("cut", self._now[name]))
            self._note(Operation("write", self._now[name], 0, data))

    def _named(self, what: str, path: Any, other: Any = "") -> None:
        name, other = self._name(path), self._name(other) if other else ""
        if name not in self._now:
            return
        number = self._now[name] if what == "link" else self._now.pop(name)
        if other:
            self._now[other] = number
        for handle, known in self._handles.items():
            if known == name and what == "rename":
                self._handles[handle] = other
        self._note(Operation(what, number, name=name, other=other))

    def _note(self, operation: Operation) -> None:
        self.operations.append(operation)

    def _name(self, path: Any) -> str:
        """Return the name of a file in the folder, empty for any other."""
        if isinstance(path, int):
            return ""
        whole = Path(os.path.abspath(os.fsdecode(path)))  # noqa: PTH100 - a link keeps its name
        inside = whole.is_relative_to(self._folder)
        passing = any(whole.name.startswith(name) for name in _PASSING)
        return str(whole) if inside and not passing else ""

    def _names(self, number: int) -> bool:
        return bool(self.operations[number].name)


def _do(done: Operation, names: Names, contents: Contents) -> None:
    """Carry out an operation; without the name of its file it has no effect."""
    content = contents.setdefault(done.file, bytearray())
    if done.what == "create":
        names[done.name] = done.file
    elif done.what == "write":
        content.extend(bytes(max(done.place + len(done.data) - len(content), 0)))
        content[done.place : done.place + len(done.data)] = done.data
    elif done.what == "cut":
        content.extend(bytes(max(done.place - len(content), 0)))
        del content[done.place :]
    elif done.what in ("rename", "link") and done.name in names:
        names[done.other] = names[done.name] if done.what == "link" else names.pop(done.name)
    elif done.what == "unlink":
        names.pop(done.name, None)
