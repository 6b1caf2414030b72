"""A trial reading of files that may be damaged, in a process that may be killed.

On a damaged NetCDF file the HDF5 library can loop forever, deaf to signals, or crash the process.
A separate process therefore reads each file to its end before we do.
"""

from __future__ import annotations

import atexit
import contextlib
import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

from sweeps.exits import StorageError

# Enough for the slowest disk that anybody would wait for.
SECONDS = 20.0
_BYTES_A_SECOND = 5e6

# The program of the reader: it reads one file after another, a megabyte at a time. The alarm ends
# it even inside the library, and even if our process is gone.
READER = """\
import os, signal, sys, netCDF4

def read(variable):
    variable.set_auto_maskandscale(False)
    if not variable.ndim:
        return variable[...]
    length = variable.shape[0]
    rows = max(1, length * (1 << 17) // max(1, variable.size))
    for start in range(0, length, rows):
        variable[start : start + rows]

for line in sys.stdin:
    limit, path = line.split()
    signal.setitimer(signal.ITIMER_REAL, float(limit))
    try:
        with netCDF4.Dataset(os.fsdecode(bytes.fromhex(path))) as file:
            for name in file.ncattrs():
                file.getncattr(name)
            for variable in file.variables.values():
                read(variable)
    except Exception:
        pass  # whoever reads the file next gets the error
    signal.setitimer(signal.ITIMER_REAL, 0.0)
    print(flush=True)
"""

_lock = threading.Lock()
_reader: subprocess.Popen[str] | None = None


def require_readable(path: Path) -> None:
    """Raise StorageError if reading a NetCDF file hangs or crashes, or if it is not a regular file.

    A missing file passes, and so does a file that cannot be read because of an error: whoever opens
    it next gets the error.
    """
    if not path.exists():
        return
    if not path.is_file():  # opening a pipe would wait for its other end
        raise StorageError(f"{path} is not a readable NetCDF file: it is not an ordinary file")
    limit = SECONDS + path.stat().st_size / _BYTES_A_SECOND
    with _lock:
        try:
            ended = _read(path.absolute(), limit)
        except BaseException:  # such as Ctrl-C: the late answer would count for the next file
            stop()
            raise
    if ended == signal.SIGALRM:
        raise StorageError(f"{path} is damaged: it cannot be read completely within {limit:.0f} s")
    if ended:
        raise StorageError(f"{path} is damaged: reading it was ended by signal {ended}")


def stop() -> None:
    """End the reader; the next file starts another."""
    global _reader
    if _reader is not None:
        _reader.kill()
        with _reader:  # closes its pipes, and waits
            _reader = None


def _read(path: Path, limit: float) -> int:
    """Let the reader read a file; return the number of the signal that ended it, or 0."""
    global _reader
    if _reader is not None and _reader.poll() is not None:  # killed, or that of our parent process
        stop()
    reader = _reader = _reader or _started()
    assert reader.stdin is not None
    assert reader.stdout is not None
    with contextlib.suppress(BrokenPipeError):
        reader.stdin.write(f"{limit} {os.fsencode(path).hex()}\n")
        reader.stdin.flush()
    if reader.stdout.readline():
        return 0
    ended = reader.wait()
    stop()
    return max(0, -ended)


def _started() -> subprocess.Popen[str]:
    atexit.register(stop)
    # -P: no module of the current folder is imported. A new session: Ctrl-C reaches only us.
    return subprocess.Popen(
        [sys.executable, "-P", "-c", READER],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        start_new_session=True,
    )
