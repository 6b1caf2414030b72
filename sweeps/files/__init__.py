"""Files on disk: journals, run folders, results and trajectories."""
