"""The kinds of motion of an orbit: codes for files, and sentences for readers."""

from __future__ import annotations

from enum import IntEnum


class Regime(IntEnum):
    """The kind of motion of an orbit; its value is the code in a result file.

    The first that applies, in this order: aperiodic, subharmonic, liquid, locked, stick-slip.

    >>> stationary_orbit().regime.name
    'STICK_SLIP_SYMMETRIC'
    """

    LIQUID = 0
    LOCKED = 1
    STICK_SLIP_SYMMETRIC = 2
    STICK_SLIP_ASYMMETRIC = 3
    SUBHARMONIC = 4
    APERIODIC = 5
    UNKNOWN = 127

    @property
    def sentence(self) -> str:
        """An explanation in one sentence."""
        return _SENTENCES[self]


_SENTENCES = {
    Regime.LIQUID: "The film is never solid.",
    Regime.LOCKED: "The film is solid and never melts.",
    Regime.STICK_SLIP_SYMMETRIC: (
        "The film melts and freezes; half a drive period later the motion is its mirror image."
    ),
    Regime.STICK_SLIP_ASYMMETRIC: (
        "The film melts and freezes, and slips farther to one side than to the other."
    ),
    Regime.SUBHARMONIC: "The orbit closes after several drive periods.",
    Regime.APERIODIC: "The orbit never closes.",
    Regime.UNKNOWN: "There is no result.",
}
