"""Kernels: the only place where the model and the numerical methods meet.

A kernel takes plain arrays and a Settings tuple, works through many points without the interpreter
and leaves a status for each; it raises nothing. One folder a method, each with a `driver` that the
table `options.METHODS` names.
"""
