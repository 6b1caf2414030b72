"""The numerical methods, which take functions and know nothing of friction.

A `make_*` function binds a method to the functions that it integrates; the kernels of
`stickslip.kernels` contain the result.
"""
