"""Settings that hold for the whole suite."""

from hypothesis import settings

settings.register_profile(
    "stickslip",
    deadline=None,  # the first call of a compiled function takes seconds, the others microseconds
    print_blob=True,
)
settings.load_profile("stickslip")
