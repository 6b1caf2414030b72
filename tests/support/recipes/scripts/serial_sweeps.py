"""Run a sweep in memory and into a file by the new executor, and print the threads it used."""

import json
import sys
import threading

from sweeps import run
from sweeps.cli.sweeps import BackendOption
from sweeps.engine.executors import serial
from sweeps.files.netcdf import content_hash

threads, compute_block = [], serial.compute_block


def watched(task):
    threads.append(threading.current_thread().name)
    return compute_block(task)


serial.compute_block = watched
config = {
    "sweep": {"temperature": [240, 250, 260]},
    "integrator": {"rtol": 1e-4},
    "stationary": {"rtol": 1e-4},
    "execution": {"block_points": 1},
}
asked = config | {"execution": {"block_points": 1, "backend": "serial"}}
found = {
    "by threads": content_hash(run(config)),
    "in memory": content_hash(run(asked)),
    "into a file": content_hash(run(config, output="a.nc", backend="serial")),
    "threads": threads,
    "help": BackendOption.__metadata__[0].metavar,
}
json.dump(found, sys.stdout)
