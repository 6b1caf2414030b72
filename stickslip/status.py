"""How the computation of one point can end: a code that is stored, and a sentence that is read."""

from __future__ import annotations

from enum import IntEnum


class Status(IntEnum):
    """The ways in which a point ends; the values are those of `status` in a result file."""

    OK = 0
    NOT_STATIONARY = 1
    STEP_LIMIT = 2
    DIVERGED = 3
    REFUSED = 4
    FAILED = 5
    INVARIANT_VIOLATED = 6
    APERIODIC = 7
    INACCURATE = 8
    INTERPOLATED = 9
    PENDING = 127

    @property
    def sentence(self) -> str:
        """One sentence that says what happened and what may help."""
        return _SENTENCES[self]

    @property
    def is_result(self) -> bool:
        """Whether a point that ended so has amplitudes."""
        return self in (Status.OK, Status.APERIODIC, Status.INTERPOLATED)


_SENTENCES = {
    Status.OK: "The stationary orbit was reached and measured.",
    Status.NOT_STATIONARY: (
        "The motion was still on its way to an orbit after `stationary.max_periods` drive periods; "
        "allow more (after some 600 what never closes is known, too), or start nearer to the orbit."
    ),
    Status.STEP_LIMIT: (
        "The step budget `integrator.max_steps` ran out before the motion was known; raise it (a "
        "weakly viscous film takes 1e4 steps a drive period, and some 600 of these at most)."
    ),
    Status.DIVERGED: (
        "The state stopped being finite, or the step size fell to rounding level; "
        "look for extreme parameters or, with a fixed step, take a smaller `integrator.dt`."
    ),
    Status.REFUSED: (
        "The fixed step is unstable for these parameters; take a smaller `integrator.dt` "
        "or `method: adaptive`."
    ),
    Status.FAILED: "The computation raised an exception; the log has it.",
    Status.INVARIANT_VIOLATED: (
        "The orbit breaks the power balance or the bounds of the order parameter, "
        "so its amplitudes cannot be trusted; take a tighter `integrator.rtol` or a smaller `dt`."
    ),
    Status.APERIODIC: (
        "The orbit does not close; its amplitudes are means over `stationary.window` drive periods."
    ),
    Status.INACCURATE: (
        "The orbit was found, but its amplitudes are not known to `integrator.max_error`, with "
        "finer tolerances neither; take a smaller `integrator.dt`, or allow a larger error."
    ),
    Status.INTERPOLATED: (
        "The point lies between computed ones that agree (`refine`), and was interpolated."
    ),
    Status.PENDING: "The point has not been computed yet.",
}
