"""Other people's solvers on this model, each behind the same small interface.

    peer = PEERS["numbalsoda LSODA"]
    peer.version()                                     # None where it is not installed
    x, v, psi = peer.end_state(parameters, start, periods, rtol)   # or PeerFailed

`Worker` runs a peer in a process of its own, which is killed when it takes too long. Every peer
gets the same scaled equations (`scaled`), compiled where it takes compiled code, with a Jacobian
where it takes one.
"""

from __future__ import annotations

from peers.base import LADDER, Peer, PeerFailed, State
from peers.casadi_cvodes import CasadiCvodes
from peers.cyrk_implicit import Cyrk
from peers.numbalsoda_lsoda import NumbalsodaLsoda
from peers.scipy_ivp import ScipyIvp
from peers.stationary import StationaryOrbit, numbalsoda_stationary
from peers.worker import Failure, Measurement, Worker

NUMBALSODA = "numbalsoda LSODA"

PEERS: dict[str, Peer] = {
    NUMBALSODA: NumbalsodaLsoda(),
    "CyRK LSODA": Cyrk("LSODA"),
    "CyRK BDF": Cyrk("BDF"),
    "CyRK Radau": Cyrk("RADAU"),
    "casadi CVODES": CasadiCvodes(),
    "SciPy LSODA": ScipyIvp("LSODA"),
    "SciPy BDF": ScipyIvp("BDF"),
    "SciPy Radau": ScipyIvp("Radau"),
}

__all__ = [
    "LADDER",
    "NUMBALSODA",
    "PEERS",
    "Failure",
    "Measurement",
    "Peer",
    "PeerFailed",
    "State",
    "StationaryOrbit",
    "Worker",
    "numbalsoda_stationary",
]
