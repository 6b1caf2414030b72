"""What the names in a file tell of the version that wrote it."""

from __future__ import annotations

from importlib import metadata

import pytest

from stickslip.kernels.version import NUMERICS_VERSION
from stickslip.variables import PARAMETERS, RESULT_COLUMNS
from sweeps.config.load import from_mapping
from sweeps.files.versions import is_newer, unknown_keys, unknown_variables, version_note

NAMES = [*RESULT_COLUMNS, *PARAMETERS, "case"]


def test_a_file_of_this_version_has_nothing_unknown() -> None:
    config = from_mapping({"sweep": {"T": [200]}, "cases": {"K": [1e3, 2e3], "X_m": [1e-6, 2e-6]}})
    assert unknown_keys(config.resolved()) == []
    assert unknown_variables(NAMES) == []
    assert version_note(NAMES, {}) == ""


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
    assert version_note(older, {}) == "written by an older version: lacks melting_count, asymmetry"
    newer = {"source": "stickslip 99.0, method adaptive"}
    told = "written by a newer version: this one does not know wind"
    assert version_note([*older, "wind"], newer) == told
    assert version_note([*NAMES, "wind"], {}) == ""  # a variable of the user


def test_a_newer_version_is_told_by_its_number_or_that_of_its_numerics() -> None:
    here = metadata.version("stickslip")
    assert is_newer({"numerics_version": str(NUMERICS_VERSION + 1)})
    assert is_newer({"source": f"stickslip {here}.1, method adaptive"})
    assert is_newer({"source": "stickslip 10.0.0, method adaptive"})
    assert not is_newer({"numerics_version": str(NUMERICS_VERSION), "source": f"stickslip {here},"})
    assert not is_newer({"source": "stickslip 0.0.9, method adaptive"})
    assert not is_newer({"source": "another program"})
