"""Measurements along an orbit and the result row made of them, the same for all methods."""
