"""The adaptive method in lanes, with passes over many points and the records of their orbits."""
