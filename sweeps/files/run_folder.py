"""The folder beside an unfinished output: lock, journal, heartbeat, unfinished files."""

from __future__ import annotations

import contextlib
import errno
import json
import os
import shutil
import socket
import stat
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from filelock import FileLock, Timeout

from sweeps.exits import Exit, ExpectedError, StorageError
from sweeps.files.atomic import flush, followed, remove, replacing, storage_errors
from sweeps.files.attributes import command_line, now
from sweeps.files.journal import manifest_path
from sweeps.human import reason

_BEATS_EVERY = 1.0  # seconds
# Seconds to wait for the lock: enough for a run that is just ending to release it.
_PATIENCE = 0.3


class InUseError(ExpectedError, RuntimeError):
    """Another run is writing this output."""

    code = Exit.STOPPED


class RunFolder:
    """`<output>.run/`: the files that a command needs until its output is complete."""

    def __init__(self, output: Path) -> None:
        self.output = output = followed(output)
        self.path = output.with_name(output.name + ".run")
        self.journal = self.path / "journal"
        self.merged = self.path / "merged"
        self.heartbeat = self.path / "heartbeat.json"
        self.result = self.path / "result.nc"
        self.manifest = self.path / "manifest.json"
        self.made = self.path / "made"
        self._lock = self.path / "lock"
        self._next_beat = self.path / "heartbeat.json.new"
        self._who = {
            "output": str(output),
            "pid": os.getpid(),
            "host": socket.gethostname(),
            "command": command_line(),
            "started": now(),
        }

    def absence(self) -> str:
        """Return the message for a result that does not exist, or does not exist yet."""
        gone = f"{self.output} does not exist"
        if not self.journal.exists():
            return gone
        return (
            f"{gone} yet: its sweep is not finished; run the command of the sweep with --partial "
            "to write the points finished so far, or without it to compute the others"
        )

    @contextlib.contextmanager
    def held(self) -> Iterator[None]:
        """Hold the output for this process until it ends, however it ends.

        Raises InUseError, which names the holder, and StorageError.
        """
        lock = FileLock(self._lock, timeout=_PATIENCE, poll_interval=0.05)
        self._refuse_folder_of_others()
        with storage_errors(f"cannot write into {self.path}", self.path.parent):
            if not self.path.exists():
                self.path.mkdir(parents=True, exist_ok=True)
                flush(self.path.parent)
        try:
            lock.acquire()
        except Timeout:
            raise InUseError(self._in_use()) from None
        except FileNotFoundError:  # the other run removed the folder between these two lines
            raise InUseError(f"{self.output} is being finished by another run right now") from None
        except (OSError, RuntimeError) as error:
            raise StorageError(f"cannot write into {self.path}: {reason(error)}") from error
        try:
            self._beat({"state": "starting"})  # replaces that of a killed run
            yield
        finally:
            if not (self.journal.exists() or self.manifest.exists()):
                self.remove()
            lock.release()  # last: from here on the folder may belong to another run

    def require_free(self) -> None:
        """Raise what `held` would, InUseError or StorageError, without writing anything."""
        self._refuse_folder_of_others()
        if not os.access(self.nearest, os.W_OK | os.X_OK):
            raise StorageError(f"cannot write into {self.path}: {os.strerror(errno.EACCES)}")
        if self.is_held():
            raise InUseError(self._in_use())

    @property
    def nearest(self) -> Path:
        """The folder itself or, where it is not there yet, the one it will be made in."""
        return next(f for f in (self.path, *self.path.absolute().parents) if f.exists())

    def is_held(self) -> bool:
        """Return whether a run holds the output now."""
        if not self._lock.exists():
            return False
        lock = FileLock(self._lock, timeout=0)
        try:
            lock.acquire()
        except Timeout:
            return True
        except (OSError, RuntimeError):  # another user's lock: rely on the heartbeat
            return bool(self.last_beat())
        lock.release()
        return False

    def last_beat(self) -> dict[str, Any]:
        """Return the last heartbeat of a run; empty if it cannot be read."""
        try:
            if not self.heartbeat.is_file():  # reading a pipe would wait
                return {}
            beat = json.loads(self.heartbeat.read_text())
        except (OSError, ValueError, RecursionError):
            return {}
        return beat if isinstance(beat, dict) else {}

    def discard_leftovers(self) -> None:
        """Remove unfinished files of a killed run, but not its journal."""
        manifests = [manifest_path(path) for path in (self.journal, self.merged)]
        half_made = [path.with_name(f"{path.name}.new") for path in manifests]
        for path in (self.result, self.merged, manifests[1], *half_made, self._next_beat):
            remove(path)

    def remove(self, *, keep_journal: bool = False) -> None:
        """Remove files that are no longer needed, and the folder if it holds no others."""
        self.discard_leftovers()
        if not self.manifest.exists():
            shutil.rmtree(self.made, ignore_errors=True)
        with contextlib.suppress(OSError):
            self.heartbeat.unlink(missing_ok=True)
            if not keep_journal:
                self.journal.unlink(missing_ok=True)
                manifest_path(self.journal).unlink(missing_ok=True)
                self._lock.unlink(missing_ok=True)
                self.path.rmdir()

    @contextlib.contextmanager
    def beating(self, beat: Callable[[], dict[str, Any]]) -> Iterator[None]:
        """Write the state of the run every second, for `stickslip status`."""
        over = threading.Event()

        def keep_beating() -> None:
            while not over.wait(_BEATS_EVERY):
                self._beat(beat())

        self._beat(beat())
        heart = threading.Thread(target=keep_beating, daemon=True)
        heart.start()
        try:
            yield
        finally:
            over.set()
            heart.join()
            self._beat(beat())

    def _beat(self, state: dict[str, Any]) -> None:
        text = json.dumps(state | self._who | {"updated": now()}) + "\n"
        with (
            contextlib.suppress(OSError),  # the sweep goes on without a heartbeat
            replacing(self.heartbeat, self._next_beat, fsync=False, follow=False) as new,
        ):
            new.write_text(text)

    def _refuse_folder_of_others(self) -> None:
        """Raise StorageError if another user could change the contents of the folder."""
        try:
            status = self.path.lstat()
        except OSError:  # it does not exist, or a later message says why
            return
        if not stat.S_ISDIR(status.st_mode):
            raise StorageError(
                f"cannot write into {self.path}: it is not a folder; move it away, or use another "
                "-o"
            )
        if os.geteuid() not in (0, status.st_uid):
            raise StorageError(
                f"cannot write into {self.path}: it belongs to another user, who could change the "
                "results; -o writes elsewhere"
            )

    def _in_use(self) -> str:
        holder = "a process that has not identified itself yet"
        if beat := self.last_beat():
            pid, host, since = (beat.get(key) for key in ("pid", "host", "started"))
            holder = f"process {pid} on {host}, since {since}: {beat.get('command')}"
        return f"{self.output} is being written by another run ({holder})"
