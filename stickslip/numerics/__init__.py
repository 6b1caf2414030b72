"""The numerical methods: they take functions and know nothing of friction.

A `make_*` function binds a method to the functions it integrates, once, at module level of
`stickslip.kernels`; what it returns is compiled into the kernels there.
"""
