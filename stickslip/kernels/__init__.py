"""Kernels, in which the model and the numerical methods meet.

A kernel takes plain arrays and a Settings tuple, works through many points without the interpreter
and writes a status for each; it raises no exceptions. Each method has a folder with a module that
the table `options.METHODS` names. `orbits/` finds orbits for all methods, and `plain_iteration/`
serves the methods with a fixed step.
"""
