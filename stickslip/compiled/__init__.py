"""Compiled code: the house decorators, the loop over lanes, the cache, elementary functions."""
