"""Executors of blocks: threads, processes, or the workers of a dask cluster."""
