"""What the benchmarks share: records, random points and their errors, timings, processes."""
