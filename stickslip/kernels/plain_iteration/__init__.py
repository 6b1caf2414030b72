"""Orbits by plain iteration of the drive period, for every method with a fixed step.

A method supplies a `motions.March`, which takes points through a drive period. Recognising orbits,
watching wandering motions and estimating errors are common to all, and are done here.
"""
