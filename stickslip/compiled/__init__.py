"""Compiled code: the decorators, the loop over lanes, the cache, elementary functions."""
