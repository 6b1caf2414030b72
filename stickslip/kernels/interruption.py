"""A way to end a computation between two calls of a kernel, whose result nobody awaits any more.

A kernel cannot be interrupted; it returns after a budget of work, and is called again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

_CHECK: ContextVar[Callable[[], None] | None] = ContextVar("check", default=None)


@contextmanager
def checked_by(check: Callable[[], None]) -> Iterator[None]:
    """Call `check` between the kernels of this thread; what it raises ends the computation."""
    before = _CHECK.set(check)
    try:
        yield
    finally:
        _CHECK.reset(before)


def check_interruption() -> None:
    """Raise what the check of this thread raises; nothing where there is none."""
    if (check := _CHECK.get()) is not None:
        check()
