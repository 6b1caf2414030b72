"""The adaptive method in lanes: passes of many points, and what they record."""
