"""The command line; `main` loads it when called, so that importing this costs nothing."""

from __future__ import annotations

import os
import signal


def main() -> None:
    """Run the command `stickslip`."""
    # Ctrl-C during an import would print a traceback, or become an error of another type.
    loading = signal.getsignal(signal.SIGINT)
    if loading is signal.default_int_handler:  # not ignored, as in the background of a script
        signal.signal(signal.SIGINT, _end)
    from sweeps.cli.app import main as run

    signal.signal(signal.SIGINT, loading)
    run()


def _end(*_: object) -> None:
    """End the process before a command has begun."""
    os.write(2, b"Interrupted; nothing was begun.\n")
    os._exit(130)  # sweeps.exits.Exit.INTERRUPTED, which would have to be imported
