"""What tests of borders share: shapes whose kinds are known at every place, bisected."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from sweeps.borders.crossings import Bisection, Crossings, Floats, Kinds


class Model:
    """Kinds of places, and how many were asked for at a time, at most `most` of them."""

    def __init__(self, kinds: Callable[[Floats], Kinds], most: int | None = None) -> None:
        self.kinds, self.most = kinds, most
        self.calls: list[int] = []

    def bisect(self, bisection: Bisection, first: int = 0) -> Crossings:
        """Answer until nothing is left, from this middle on; return the crossings."""
        found = self.answer(bisection, first)
        assert bisection.left == 0
        return found

    def answer(self, bisection: Bisection, first: int = 0) -> Crossings:
        """Answer until nothing is asked any more, the middles that came last before the others."""
        waiting = np.arange(first, len(bisection))
        while len(waiting):
            count = self.most or len(waiting)
            waiting, which = waiting[:-count], waiting[-count:]
            places, before = bisection.middles(0)[which], len(bisection)
            self.calls.append(len(which))
            bisection.take_in(which, self.kinds(places), places[:, 0].copy())
            waiting = np.concatenate([waiting, np.arange(before, len(bisection))])
        return bisection.crossings()
