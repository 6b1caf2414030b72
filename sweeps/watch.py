"""A watched trial reading of files that may be damaged.

In a damaged NetCDF file the HDF5 library can loop forever, ignoring signals, or crash the process.
So a separate process reads every file to its end before we do.
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

# The limit of the slowest disk that anybody would wait for.
SECONDS = 20.0
_BYTES_A_SECOND = 5e6

# Reads one file after another, a megabyte at a time. The alarm ends it even inside the library, and
# even if we are gone.
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
    """Raise StorageError if reading a NetCDF file hangs or crashes, or if it is not a file.

    A file whose reading fails with an error passes: its reader gets that error.
    """
    if path.exists() and not path.is_file():  # opening a pipe would wait for its other end
        raise StorageError(f"{path} is not a readable NetCDF file: it is not an ordinary file")
    if not path.exists():
        return
    limit = SECONDS + path.stat().st_size / _BYTES_A_SECOND
    with _lock:
        ended = _read(path.absolute(), limit)
    if ended == signal.SIGALRM:
        raise StorageError(f"{path} is damaged: it cannot be read to its end in {limit:.0f} s")
    if ended:
        raise StorageError(f"{path} is damaged: reading it ends in signal {ended}")


def stop() -> None:
    """End the reader; the next file starts another."""
    global _reader
    if _reader is not None:
        _reader.kill()
        with _reader:  # closes its pipes, and waits
            _reader = None


def _read(path: Path, limit: float) -> int:
    """Let the reader read a file; return the number of the signal that ended it, 0 if none."""
    global _reader
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
    # -P: what lies in the present folder is not imported. A session of its own: Ctrl-C is for us.
    return subprocess.Popen(
        [sys.executable, "-P", "-c", READER],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        start_new_session=True,
    )
