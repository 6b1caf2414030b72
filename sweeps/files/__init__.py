"""What lies on the disk: journals, run folders, result and trajectory files."""
