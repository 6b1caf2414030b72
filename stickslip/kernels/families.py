"""Kernels specialised by fluid: the one table, and the one dispatch.

A law of friction names rheological indices for which the compiler makes better code; points with
these go to kernels of their own, all others to a general one. Kernels are made when they are first
asked for, by factories that are given the law and the index.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from stickslip.model.laws import friction_law


class Family(NamedTuple):
    """Fluids that share a kernel: those with one rheological index, or, for None, all others."""

    law: str
    gamma: float | None

    def __str__(self) -> str:
        gamma = "any" if self.gamma is None else f"{self.gamma:.17g}"
        return f"{self.law},gamma={gamma}"


def families(law: str, indices: np.ndarray) -> Iterator[tuple[Family, np.ndarray]]:
    """The families that occur among fluids with these rheological indices (n,).

    Each comes with the positions (m,) of its members.
    """
    special = friction_law(law).special_indices
    for index in special:
        members = np.flatnonzero(indices == index)
        if len(members):
            yield Family(law, index), members
    others = np.flatnonzero(~np.isin(indices, list(special)))
    if len(others):
        yield Family(law, None), others
