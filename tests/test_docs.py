"""The documentation agrees with the code: symbols, units, defaults, numbers, file names."""

import math
import re
import tomllib
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from stickslip.parameters import Parameters
from stickslip.variables import PARAMETERS, RESULTS, TRAJECTORY, ParameterVariable

ROOT = Path(__file__).parents[1]
EQUATIONS = (ROOT / "docs" / "equations.md").read_text(encoding="utf-8")


def table(heading: str) -> list[list[str]]:
    """The rows below a header row that starts like `heading`; cells are stripped, `\\|` is `|`."""
    lines = iter(EQUATIONS.splitlines())
    next(line for line in lines if line.startswith(heading))
    next(lines)  # the dashes
    return [
        [cell.strip().replace("\\|", "|") for cell in re.split(r"(?<!\\)\|", line)[1:-1]]
        for line in _until_blank(lines)
    ]


def _until_blank(lines: Iterator[str]) -> Iterator[str]:
    for line in lines:
        if not line:
            return
        yield line


def valid_range(variable: ParameterVariable) -> str:
    if variable.nonzero:
        return "not 0"
    if math.isfinite(variable.upper):
        return f"{variable.lower:g} to {variable.upper:g}"
    if math.isfinite(variable.lower):
        return f"{'>' if variable.lower_open else 'at least'} {variable.lower:g}"
    return "finite"


def test_parameter_table_is_the_registry():
    documented = table("| symbol | name | unit | default |")
    declared = [
        [
            f"${variable.tex}$",
            f"`{name}`",
            variable.units,
            valid_range(variable),
            "; ".join(filter(None, [variable.meaning, variable.comment])),
        ]
        for name, variable in PARAMETERS.items()
    ]
    assert [row[:3] + row[4:] for row in documented] == declared


def test_documented_defaults_are_the_defaults():
    documented = {row[1].strip("`"): float(Fraction(row[3])) for row in table("| symbol | name")}
    assert documented == Parameters()._asdict()


def test_trajectory_table_is_the_registry():
    declared = [[f"${v.tex}$", f"`{v.name}`", v.units, v.meaning] for v in TRAJECTORY.values()]
    assert table("| symbol | name | unit | meaning |") == declared


def test_result_table_is_the_registry():
    declared = [[f"`{v.name}`", v.units, v.meaning] for v in RESULTS.values()]
    assert table("| name | unit | meaning |") == declared


def test_every_equation_of_the_paper_is_there_once_and_in_order():
    assert [int(tag) for tag in re.findall(r"\\tag\{(\d+)\}", EQUATIONS)] == list(range(1, 27))


def test_closed_forms_have_the_documented_values():
    p = Parameters()
    alpha, T_c, a, b, c = p[14:19]
    B_rest = 2 * alpha * (p.temperature - T_c)
    eps_melt = math.sqrt((b**2 / (4 * c) - B_rest) / a)
    eps = np.linspace(0.0, eps_melt * (1 - 1e-12), 20_001)
    phi = b / (2 * c) + np.sqrt((b / (2 * c)) ** 2 - (a * eps**2 + B_rest) / c)
    sigma_el = a * phi**2 * eps
    rate = eps / p.strain_relaxation_time
    sigma_v = p.viscosity_coefficient * rate ** (p.rheological_index + 1)
    drive_rate = p.drive_amplitude * p.angular_frequency / p.film_thickness
    expected = [
        b**2 / (4 * c),
        T_c + b**2 / (8 * alpha * c),
        T_c,
        phi[0],
        eps_melt,
        math.sqrt(-B_rest / a),
        p.film_thickness * eps_melt / p.strain_relaxation_time,
        sigma_el.max(),
        p.contact_area * (sigma_el + sigma_v).max(),
        (2 * p.spring_stiffness - p.block_mass * p.angular_frequency**2) * p.drive_amplitude,
        math.sqrt(2 * p.spring_stiffness / p.block_mass),
        p.viscosity_coefficient * p.contact_area * drive_rate ** (p.rheological_index + 1),
    ]
    documented = [row[2].split()[0] for row in table("| quantity | formula | value |")]
    assert [
        _rounded_like(value, text) for value, text in zip(expected, documented, strict=True)
    ] == [float(text) for text in documented]


def _rounded_like(value: float, text: str) -> float:
    digits = re.sub(r"e.*", "", text).replace(".", "").lstrip("0")
    return float(f"{value:.{len(digits) - 1}e}")


def test_noise_factor_has_the_documented_value():
    (documented,) = re.findall(r"= (0\.\d+)\\,D", EQUATIONS)
    assert float(documented) == round(math.exp(-np.euler_gamma) / 2, 7)


@pytest.mark.parametrize("path", sorted(set(re.findall(r"`(stickslip/[\w/]+\.py)`", EQUATIONS))))
def test_files_named_in_equations_exist(path: str):
    assert (ROOT / path).is_file()


def test_citation_has_the_version_of_the_package():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert f"\nversion: {project['version']}\n" in (ROOT / "CITATION.cff").read_text("utf-8")
