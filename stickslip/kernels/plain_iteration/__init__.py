"""Orbits by plain iteration of the drive period, for every method with a fixed step.

A method supplies a `march.March`, which takes points through a drive period. The modules here
recognise orbits, watch wandering motions and estimate errors for all such methods.
"""
