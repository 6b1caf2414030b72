"""Run time against error: the solvers bound to their points, and what follows from the curves."""
