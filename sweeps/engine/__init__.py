"""Sweeps: they compute the missing points, record them and write the result."""
