"""Families of fluids, each with a specialised kernel, and the dispatch of points to them.

A law of friction names rheological indices for which the compiler makes better code; points with
these go to kernels of their own, all others to a general one. Factories make a kernel from the
physics and the index when it is first needed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np

from stickslip.model.film import HIGHER_COEFFICIENTS
from stickslip.model.laws import friction_law
from stickslip.options import Physics

KIND = ("rheological_index", *HIGHER_COEFFICIENTS)
"""The parameters that determine the family of a point."""


class Family(NamedTuple):
    """Points that share a kernel: those with the same rheological index or, for None, all others.

    `higher` if their free energy has higher terms than the paper's.
    """

    physics: Physics
    gamma: float | None
    higher: bool = False

    def __str__(self) -> str:
        gamma = "any" if self.gamma is None else f"{self.gamma:.17g}"
        return f"{self.physics},gamma={gamma}{',higher' if self.higher else ''}"


class FamilyKernel(NamedTuple):
    """A kernel of one family, and the function that compiles or loads it."""

    kernel: Any
    compile: Callable[[], object]


def families(physics: Physics, kinds: np.ndarray) -> Iterator[tuple[Family, np.ndarray]]:
    """Yield the families among points of these kinds (n, k), with columns in the order of `KIND`.

    Each comes with the positions (m,) of its members.
    """
    special = friction_law(physics.friction).special_indices
    indices, has_higher = kinds[:, 0], np.any(kinds[:, 1:] != 0.0, axis=1)
    for higher in (False, True):
        for index in (*special, None):
            same = indices == index if index is not None else ~np.isin(indices, list(special))
            members = np.flatnonzero(same & (has_higher == higher))
            if len(members):
                yield Family(physics, index, higher), members
