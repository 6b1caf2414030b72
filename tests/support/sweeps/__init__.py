"""Helpers for tests of configs, files, sweeps and the command line."""
