"""How the computation of a point can end: codes for files, and sentences for readers."""

from __future__ import annotations

from enum import IntEnum


class Status(IntEnum):
    """How the computation of a point ended; its value is the code in a result file.

    >>> Status(0).name, Status.OK.is_result
    ('OK', True)
    """

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
    UNSTABLE = 10
    PENDING = 127

    @property
    def sentence(self) -> str:
        """The cause and a remedy, in one sentence."""
        return _SENTENCES[self]

    @property
    def is_result(self) -> bool:
        """Whether a point with this status has amplitudes."""
        return self in (Status.OK, Status.APERIODIC, Status.INTERPOLATED)


_SENTENCES = {
    Status.OK: "The stationary orbit was reached and measured.",
    Status.NOT_STATIONARY: (
        "The motion was still on its way to an orbit after `stationary.max_periods` drive periods; "
        "allow more (motions that never close are recognised within some 600), or start closer "
        "to it."
    ),
    Status.STEP_LIMIT: (
        "The step budget `integrator.max_steps` ran out before the orbit was found; raise it (a "
        "weakly viscous film takes 1e4 steps per drive period, and at most some 600 periods)."
    ),
    Status.DIVERGED: (
        "The state stopped being finite, or the step size fell to rounding level; "
        "look for extreme parameters or, with a fixed step, take a smaller `integrator.dt`."
    ),
    Status.REFUSED: (
        "The fixed step is unstable for these parameters; take a smaller `integrator.dt` "
        "or `method: adaptive`."
    ),
    Status.FAILED: "The computation raised an exception; see the log.",
    Status.INVARIANT_VIOLATED: (
        "The orbit breaks the power balance or the bounds of the order parameter, "
        "so its amplitudes cannot be trusted; take a tighter `integrator.rtol` or a smaller `dt`."
    ),
    Status.APERIODIC: (
        "The orbit does not close; its amplitudes are means over `stationary.window` drive periods."
    ),
    Status.INACCURATE: (
        "The orbit was found, but its amplitudes are not accurate to `integrator.max_error` even "
        "with finer tolerances; take a smaller `integrator.dt`, or allow a larger error."
    ),
    Status.INTERPOLATED: (
        "The point lies between computed points that agree (`refine`), and was interpolated."
    ),
    Status.UNSTABLE: (
        "The orbit that was found is unstable: the block oscillates about it on its springs with "
        "growing amplitude, which the steps do not resolve; take a tighter `integrator.rtol`, "
        "such as 1e-9."
    ),
    Status.PENDING: "The point has not been computed yet.",
}


class IntegrationError(RuntimeError):
    """A trajectory or orbit could not be computed; `status` says why.

    >>> try:
    ...     simulate(start="stationary", max_periods=1)
    ... except IntegrationError as error:
    ...     print(error.status.name)
    NOT_STATIONARY
    """

    def __init__(self, status: Status, context: str = "") -> None:
        super().__init__(f"{context}{status.sentence}")
        self.status = status
