"""Periodic orbits of a driven system: when has a sequence of states reached its cycle."""
