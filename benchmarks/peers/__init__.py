"""Other people's solvers on this model, each behind the same small interface.

`Worker` runs a peer in a process of its own, which is killed when it takes too long. Every peer
gets the same scaled equations (`scaled`), compiled where it takes compiled code, with a Jacobian
where it takes one.
"""

from peers.solvers import LADDER, NUMBALSODA, PEERS
from peers.stationary import StationaryOrbit
from peers.worker import Failure, Worker

__all__ = ["LADDER", "NUMBALSODA", "PEERS", "Failure", "StationaryOrbit", "Worker"]
