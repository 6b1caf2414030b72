"""Compute rates, observables and a row, which need the registry, with the law given as argument."""

import sys

import numpy as np

from stickslip import Options, Parameters
from stickslip.kernels.adaptive import rows
from stickslip.kernels.fastest_rates import fastest_rate
from stickslip.kernels.orbits.motions import new_motions
from stickslip.kernels.parameter_rows import write_results
from stickslip.kernels.trajectories import observables_kernel

physics = Options(friction=sys.argv[1]).physics
points = np.array([Parameters()])
fastest_rate(points, physics.friction)
observables_kernel(physics)(points[0], np.zeros(1), np.ones((1, 3)), 0.0, np.zeros((1, 6)))
motions = new_motions(np.zeros((1, 40)), np.zeros((1, 4)))
orbits = rows.Orbits(
    np.zeros((1, 4)),
    motions.measured.copy(),
    np.zeros(1, bool),
    np.zeros((1, 2)),
    np.zeros(1),
    np.zeros((1, 4, 3)),
    np.zeros((1, 3)),
    np.zeros((1, 3)),
    np.zeros((1, 3)),
)
states, results = np.zeros((1, 4)), np.zeros((1, 30))
measured = rows.measured_of(points, motions, orbits, states, states, 1e-6, physics)
write_results(points, measured, results)
