"""How orbits are found: once, over n points, for every method.

A method takes motions along; here they are judged, watched where they wander, and measured.
"""
