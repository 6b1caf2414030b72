"""Settings that hold for the whole suite."""

from collections import Counter
from collections.abc import Iterator

import pytest
from hypothesis import settings
from support.processes import end_all

settings.register_profile(
    "stickslip",
    deadline=None,  # the first call of a compiled function takes seconds, the others microseconds
    print_blob=True,
)
settings.load_profile("stickslip")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Files with the most slow tests come first, so that no worker is left with one at the end."""
    slow = Counter(item.path for item in items if item.get_closest_marker("slow"))
    items.sort(key=lambda item: -slow[item.path])


@pytest.fixture(autouse=True)
def no_process_is_left() -> Iterator[None]:
    """A test that fails leaves no process to the next one."""
    yield
    end_all()
