"""Where blocks are computed: threads, processes, or the workers of a dask cluster."""
