"""Files that cannot be read as YAML give readable messages."""

from __future__ import annotations

from pathlib import Path

import pytest

from sweeps.config.load import ConfigError, load


@pytest.mark.parametrize("name", ["", "x" * 5000 + ".yaml"])
def test_a_file_that_cannot_be_read_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(ConfigError, match="cannot be read"):
        load(tmp_path / name)


@pytest.mark.parametrize(
    "text",
    [
        "[" + "1," * 20_000 + "]",
        "a\n" * 100_000,
        "title: [" + "a " * 100_000,
        '"' + "\\n" * 100_000,
        "? " * 5_000 + "a",
        "x" * 500_000 + ": 1",
        "".join(f"k{i}: 1\n" for i in range(10_000)),
        "model: {" + "K: 1, " * 10_000 + "}",
        "*a " * 10_000,
        ":" * 100_000,
        "model:\n  T: " + "1" * 200_000 + "x\n",
        "model:\n  T: " + "1," * 100_000 + "\n",
    ],
    ids=range(12),
)
def test_large_nonsense_is_refused_in_readable_lines(tmp_path: Path, text: str) -> None:
    path = tmp_path / "large.yaml"
    path.write_text(text)
    with pytest.raises(ConfigError) as caught:
        load(path)
    assert all(len(problem.message) < 500 for problem in caught.value.problems)
