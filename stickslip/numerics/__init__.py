"""The numerical methods: they take functions and know nothing of friction.

A `make_*` function binds a method to the functions it integrates; the result is compiled into the
kernels of `stickslip.kernels`.
"""
