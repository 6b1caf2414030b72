"""Families of fluids, each with a specialised kernel, and the dispatch of points to them.

A law of friction lists rheological indices for which the compiler makes better code. Points with
such an index go to special kernels, all others to a general one. Factories make a kernel from the
physics and the index when it is first needed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from stickslip.model.drive import HARMONIC_AMPLITUDES
from stickslip.model.film import HIGHER_COEFFICIENTS
from stickslip.model.laws import friction_law
from stickslip.options import COSINE, HARMONICS, Physics
from stickslip.parameters import Parameters

KIND = ("rheological_index", *HIGHER_COEFFICIENTS, *HARMONIC_AMPLITUDES)
"""The parameters that determine the family of a point."""

_HIGHER = slice(1, 1 + len(HIGHER_COEFFICIENTS))
_HARMONICS = slice(1 + len(HIGHER_COEFFICIENTS), None)


class Family(NamedTuple):
    """Points that share a kernel.

    All have the rheological index `gamma` or, if it is None, any index without a kernel of its own.
    `higher` is true if their free energy has terms of higher order than the paper's; `physics`
    includes their drive.
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

    With each family comes an array (m,) of the positions of its members.
    """
    special = friction_law(physics.friction).special_indices
    indices, has_higher = kinds[:, 0], np.any(kinds[:, _HIGHER] != 0.0, axis=1)
    has_harmonics = np.any(kinds[:, _HARMONICS] != 0.0, axis=1)
    for drive, index, higher in product((COSINE, HARMONICS), (*special, None), (False, True)):
        same = indices == index if index is not None else ~np.isin(indices, list(special))
        same = same & (has_harmonics == (drive == HARMONICS)) & (has_higher == higher)
        members = np.flatnonzero(same)
        if len(members):
            yield Family(physics._replace(drive=drive), index, higher), members


def physics_at(point: np.ndarray, physics: Physics) -> Physics:
    """Return these physics with the drive of a point (parameters,)."""
    harmonics = point[[Parameters._fields.index(name) for name in HARMONIC_AMPLITUDES]]
    return physics._replace(drive=HARMONICS if np.any(harmonics != 0.0) else COSINE)
