"""A way to end a computation whose result nobody awaits any more, between two calls of a kernel.

A kernel cannot be interrupted, but it returns after a budget of work and is then called again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

_CHECK: ContextVar[Callable[[], None] | None] = ContextVar("check", default=None)


@contextmanager
def checked_by(check: Callable[[], None]) -> Iterator[None]:
    """Call `check` between the kernels of this thread; an exception that it raises ends them."""
    before = _CHECK.set(check)
    try:
        yield
    finally:
        _CHECK.reset(before)


def check_interruption() -> None:
    """Call the check of this thread, if there is one."""
    if (check := _CHECK.get()) is not None:
        check()
