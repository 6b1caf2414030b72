"""The adaptive method in lanes: passes over many points, and their records."""
