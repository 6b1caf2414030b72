"""Bisection of shapes with known kinds, for tests of borders."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from sweeps.borders.crossings import Bisection, Crossings, Floats, Kinds


class Model:
    """The kinds of places, and the number of places in each call, at most `most`."""

    def __init__(self, kinds: Callable[[Floats], Kinds], most: int | None = None) -> None:
        self.kinds, self.most = kinds, most
        self.calls: list[int] = []

    def bisect(self, bisection: Bisection, first: int = 0) -> Crossings:
        """Answer until nothing is left, from the middle `first` on; return the crossings."""
        found = self.answer(bisection, first)
        assert bisection.left == 0
        return found

    def answer(self, bisection: Bisection, first: int = 0) -> Crossings:
        """Answer until no middles remain, the last ones first; return the crossings."""
        waiting = np.arange(first, len(bisection))
        while len(waiting):
            count = self.most or len(waiting)
            waiting, which = waiting[:-count], waiting[-count:]
            places, before = bisection.middles(0)[which], len(bisection)
            self.calls.append(len(which))
            bisection.take_in(which, self.kinds(places), places[:, 0].copy())
            waiting = np.concatenate([waiting, np.arange(before, len(bisection))])
        return bisection.crossings()
