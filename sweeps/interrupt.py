"""Ctrl-C during compiled code, which does not look for signals and cannot be stopped."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable
from typing import Any, TypeVar

_T = TypeVar("_T")

INTERRUPTED = 130


def interruptible(
    work: Callable[[], _T], message: str, *, tidy: Callable[[], None] | None = None
) -> _T:
    """The result of `work`, computed in a thread while the main thread listens for Ctrl-C.

    On Ctrl-C `tidy` is called, `message` is printed and the process ends at once with exit code
    130: nothing else that would have to be tidied up may happen inside `work`. What `work` raises
    is raised here.
    """
    outcome: dict[str, Any] = {}

    def attempt() -> None:
        try:
            outcome["result"] = work()
        except BaseException as error:  # noqa: BLE001 - handed over to the main thread
            outcome["error"] = error

    worker = threading.Thread(target=attempt, daemon=True)
    try:
        worker.start()
        while worker.is_alive():
            worker.join(0.1)
    except KeyboardInterrupt:
        if tidy is not None:
            tidy()
        sys.stderr.write(f"\n{message}\n")
        sys.stderr.flush()
        sys.stdout.flush()
        os._exit(INTERRUPTED)
    if "error" in outcome:
        raise outcome["error"]
    return outcome["result"]  # type: ignore[no-any-return]
