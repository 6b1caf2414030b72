"""The adaptive method in lanes: passes over many points, and the records of those points."""
