"""docs/configuration.md is made from the declarations, and the examples in it are accepted."""

from __future__ import annotations

import re
import runpy

import pytest
from support.sweeps.configs import CONFIGS, SECTIONS

from stickslip.variables import PARAMETERS
from sweeps.config.load import KEYS, from_yaml
from sweeps.config.yaml_reader import read_mapping
from sweeps.grid import Grid

DOCS = CONFIGS.parent / "docs"
PAGE = (DOCS / "configuration.md").read_text()
BLOCKS = re.findall(r"```yaml\n(.*?)```", PAGE, re.DOTALL)
INLINE = re.findall(r"`(\w+: \{.*?\})`", PAGE)
OVERRIDES = [text.strip('"') for text in re.findall(r"`--set ([^`]*?=[^`]*?)`", PAGE)]
OVERRIDES.remove("KEY=VALUE")


def test_the_page_is_up_to_date() -> None:
    """Run `python docs/configuration.py` if it is not."""
    with_tables = runpy.run_path(str(DOCS / "configuration.py"))["with_tables"]
    assert with_tables(PAGE) == PAGE


def test_every_key_has_a_row() -> None:
    keys = [*KEYS, *PARAMETERS, *(key for kind in SECTIONS.values() for key in kind.model_fields)]
    missing = [key for key in keys if not re.search(rf"^\| \[?`{key}`", PAGE, re.MULTILINE)]
    assert missing == []


def test_the_first_example_has_as_many_points_as_the_text_says() -> None:
    grid = Grid.from_config(from_yaml(BLOCKS[0]))
    assert f"= {grid.size} points" in PAGE
    assert grid.dims == ("temperature", "rheological_index", "case")


@pytest.mark.parametrize("text", [*BLOCKS, *INLINE])
def test_what_the_page_shows_is_accepted(text: str) -> None:
    from_yaml(text, overrides=["phi_0=0.01"])


@pytest.mark.parametrize("override", OVERRIDES)
def test_the_overrides_that_the_page_shows_are_accepted(override: str) -> None:
    assert len(OVERRIDES) > 6
    from_yaml("cases: {omega: [10, 20]}\nsweep: {gamma: [0, 1]}", overrides=[override])


def test_the_examples_show_every_key_that_is_available() -> None:
    shown: set[str] = set()
    for text in [*BLOCKS, *INLINE]:
        written = read_mapping(text, "page")
        shown |= {f"{name}.{key}" for name in SECTIONS for key in written.get(name, {})}
    keys = {f"{name}.{key}" for name, kind in SECTIONS.items() for key in kind.model_fields}
    in_no_file = {"execution.scheduler"}
    assert keys - shown == {"noise.seed", "noise.realizations"} | in_no_file
