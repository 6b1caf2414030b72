"""The computation of many points by workers, for everything that needs rows of results."""
