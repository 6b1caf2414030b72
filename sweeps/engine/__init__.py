"""Sweeps: what is missing is computed, recorded and put into a result."""
