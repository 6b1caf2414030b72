"""Periodic orbits of a driven system: tests and acceleration of the convergence to a cycle."""
