"""Kernels: the only place where the model and the numerical methods meet.

A kernel takes plain arrays and a Settings tuple, works through many points without the interpreter
and leaves a status for each; it raises nothing. One folder a method, with a module that the
table `options.METHODS` names; `plain_iteration/` is for all methods with a fixed step.
"""
