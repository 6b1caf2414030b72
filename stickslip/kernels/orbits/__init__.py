"""The search for orbits of many points, which all methods share.

A method only integrates motions. Here they are judged, and watched if they wander.
"""
