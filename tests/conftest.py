"""Settings that hold for the whole suite."""

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings
from support.sweeps.processes import end_all
from support.warm import compile_kernels

# The suite looks at the same examples every time, and says the same of the same sources. With the
# other profile `make stress` searches on, at random.
settings.register_profile(
    "suite",
    deadline=None,  # the first call of a compiled function takes seconds, the others microseconds
    print_blob=True,
    derandomize=True,
)
settings.register_profile("search", settings.get_profile("suite"), derandomize=False)
settings.load_profile("suite")


def pytest_sessionstart(session: pytest.Session) -> None:
    """Before the workers of a whole run begin, compile what all of them would compile."""
    config = session.config
    begins_workers = bool(config.getoption("numprocesses", None))  # they themselves have none
    if begins_workers and config.args_source is pytest.Config.ArgsSource.TESTPATHS:
        compile_kernels()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put the files with the most slow tests first, so that no worker finishes late."""
    slow = Counter(item.path for item in items if item.get_closest_marker("slow"))
    items.sort(key=lambda item: -slow[item.path])


@pytest.fixture(autouse=True)
def compiling_is_not_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """No command says that it compiles, so messages do not depend on what is cached."""
    monkeypatch.setattr("sweeps.engine.progress.MOMENT", 1e6)


@pytest.fixture
def shell(
    request: pytest.FixtureRequest,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> Any:
    """The command line in this process, in a folder that holds the `A_YAML` of the test file."""
    from support.sweeps.sweeping import Shell  # here: most tests do without what it loads

    shell = Shell(tmp_path, monkeypatch, capsys)
    if hasattr(request.module, "A_YAML"):
        Path("a.yaml").write_text(request.module.A_YAML)
    return shell


@pytest.fixture(autouse=True)
def no_process_is_left() -> Iterator[None]:
    """A test that fails leaves no process behind for the next one."""
    yield
    end_all()
