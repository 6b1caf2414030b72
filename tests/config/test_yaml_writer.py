"""The YAML of a resolved config."""

from __future__ import annotations

from ruamel.yaml import YAML

from sweeps.config.load import from_yaml


def test_readers_of_yaml_1_1_see_the_same_numbers() -> None:
    reader = YAML(typ="safe", pure=True)
    reader.version = (1, 1)
    config = from_yaml("sweep: {h: [1e-9, 1e-300, 2.5e-9, 1e300]}\ntitle: 'no'")
    assert reader.load(config.resolved_yaml()) == config.resolved()
