"""Measurements along an orbit, and the result row that follows from them, for all methods."""
