"""Other people's solvers on this model, each behind the same small interface.

`Worker` runs a peer in a process of its own, which is killed when it takes too long. Every peer
gets the same scaled equations (`scaled`), compiled where it takes compiled code, with a Jacobian
where it takes one.
"""

from peers.solvers import LADDER, CasadiCvodes, Cyrk, Numbalsoda, Peer, ScipyIvp
from peers.stationary import StationaryOrbit
from peers.worker import Failure, Worker

NUMBALSODA = "numbalsoda LSODA"

PEERS: dict[str, Peer] = {
    NUMBALSODA: Numbalsoda(),
    "CyRK LSODA": Cyrk("LSODA"),
    "CyRK BDF": Cyrk("BDF"),
    "CyRK Radau": Cyrk("RADAU"),
    "casadi CVODES": CasadiCvodes(),
    "SciPy LSODA": ScipyIvp("LSODA"),
    "SciPy BDF": ScipyIvp("BDF"),
    "SciPy Radau": ScipyIvp("Radau"),
}

__all__ = ["LADDER", "NUMBALSODA", "PEERS", "Failure", "StationaryOrbit", "Worker"]
