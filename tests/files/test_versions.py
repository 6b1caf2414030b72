"""What the names in a file tell of the version that wrote it."""

from __future__ import annotations

import pytest

from stickslip.variables import PARAMETERS, RESULT_COLUMNS
from sweeps.config.load import from_mapping
from sweeps.files.versions import unknown_keys, unknown_variables, version_note

NAMES = [*RESULT_COLUMNS, *PARAMETERS, "case"]


def test_a_file_of_this_version_has_nothing_unknown() -> None:
    config = from_mapping({"sweep": {"T": [200]}, "cases": {"K": [1e3, 2e3], "X_m": [1e-6, 2e-6]}})
    assert unknown_keys(config.resolved()) == []
    assert unknown_variables(NAMES) == []
    assert version_note(NAMES) == ""


@pytest.mark.parametrize(
    ("part", "unknown"),
    [
        ({"weather": {"wind": 1}}, ["weather"]),
        ({"model": {"temperature": 1.0, "wind": 1.0}}, ["model.wind"]),
        ({"sweep": {"wind": [1.0]}}, ["sweep.wind"]),
        ({"integrator": {"rtol": 1e-6, "wind": 1}}, ["integrator.wind"]),
        ({"integrator": None, "cases": {}}, []),
    ],
)
def test_keys_that_this_version_does_not_know_are_told_by_their_path(
    part: dict[str, object], unknown: list[str]
) -> None:
    assert unknown_keys(part) == unknown


def test_the_note_says_what_an_older_or_a_newer_file_is_about() -> None:
    older = [name for name in NAMES if name not in ("asymmetry", "melting_count")]
    assert version_note(older) == "written by an older version: lacks melting_count, asymmetry"
    newer = [*older, "wind"]
    assert version_note(newer) == "written by a newer version: this one does not know wind"
