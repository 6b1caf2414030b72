"""Orbits by plain iteration of the drive period: for every method with a fixed step.

A method brings a `motions.March`, which takes points through a drive period. How an orbit is
recognised, a wandering motion watched and an error estimated stands here, once.
"""
