"""A solver that shares nothing with the package, for `bench_reference.py`."""

from reference.taylor import EXTREMES, Film, film_of, half_period

__all__ = ["EXTREMES", "Film", "film_of", "half_period"]
