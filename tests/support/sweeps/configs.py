"""Configs that tests share, and the problems of a refused config."""

from __future__ import annotations

from pathlib import Path

import pytest

from sweeps.config.load import Config, ConfigError, from_yaml
from sweeps.config.schema import Section

CONFIGS = Path(__file__).parents[3] / "configs"

SECTIONS: dict[str, type[Section]] = {
    name: field.annotation
    for name, field in Config.model_fields.items()
    if isinstance(field.annotation, type) and issubclass(field.annotation, Section)
}

SHIPPED = sorted(CONFIGS.glob("*.yaml"))

EXAMPLE = """\
title: Fig. 7 - amplitudes
model:
  spring_stiffness: 3000
sweep:
  temperature: {linspace: [150, 320], num: 171}
  rheological_index: [-2/3, 0, 2/3]
cases:
  drive_amplitude: [0.4e-6, 0.8e-6]
  angular_frequency: [20, 10]
integrator: {method: adaptive, rtol: 1e-6}
stationary: {rtol: 1e-6, max_periods: 5000}
noise: {treatment: typical-path}
output: results/fig7.nc
execution: {backend: threads}
plot: {figure: amplitudes}
simulation: {periods: 6, start: initial, samples_per_period: 2000}
"""


def problems(yaml: str, *overrides: str) -> list[str]:
    with pytest.raises(ConfigError) as caught:
        from_yaml(yaml, "f.yaml", overrides)
    return [str(problem) for problem in caught.value.problems]
