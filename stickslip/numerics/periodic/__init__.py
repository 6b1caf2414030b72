"""Periodic orbits of a driven system: recognising and accelerating convergence to a cycle."""
