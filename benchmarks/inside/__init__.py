"""What benchmarks use of the inside of the package, below `stickslip.orbit`: all of it stands here.

So a change of the kernels touches no other benchmark.
"""
