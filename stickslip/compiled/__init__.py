"""Compiled code: its decorators and cache, the loop over lanes, and elementary functions."""
