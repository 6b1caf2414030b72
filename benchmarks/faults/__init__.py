"""Attacks on sweeps, each a module with `run(quick)`; `arena` holds what they share."""
