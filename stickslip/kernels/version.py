"""The version of the numbers."""

NUMERICS_VERSION = 18
"""Part of every point's identity. Raise it with every change that alters a number returned by a
kernel, even in the last bit; the golden tests notice if that was forgotten."""
