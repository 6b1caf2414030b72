"""Kernels: the only place where the model and the numerical methods meet.

A kernel takes plain arrays and a Settings tuple, works through many points without the interpreter
and leaves a status for each; it raises nothing. Each method has a folder, with a module named in
the table `options.METHODS`; `orbits/` finds orbits for all of them, and `plain_iteration/` serves
those with a fixed step.
"""
