"""The version of the numbers."""

NUMERICS_VERSION = 16
"""Part of every point's identity. It is raised whenever a change alters any number that a kernel
returns, in the last bit even; the golden tests notice when that was forgotten."""
