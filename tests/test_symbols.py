"""Mathtext as plain text and as HTML."""

from __future__ import annotations

import pytest

from stickslip.symbols import as_html, plain
from stickslip.variables import PARAMETERS, PHASES, RESULTS, TRAJECTORY

ALL = [*PARAMETERS.values(), *TRAJECTORY.values(), *PHASES.values(), *RESULTS.values()]


@pytest.mark.parametrize(
    ("label", "letters", "html"),
    [
        (r"$\sigma_\mathrm{el,max}$ (MPa)", "σₑₗ,ₘₐₓ (MPa)", "σ<sub>el,max</sub> (MPa)"),
        (r"$x_0 = -2\times10^{-7}$ m", "x₀ = −2×10⁻⁷ m", "x<sub>0</sub> = −2×10<sup>−7</sup> m"),
        (r"$T_c^0$", "T_c⁰", "T<sub>c</sub><sup>0</sup>"),
        (r"Pa$\cdot$s$^{\gamma+1}$", "Pa·sᵞ⁺¹", "Pa·s<sup>γ+1</sup>"),
        (r"Pa$\cdot$s$^{1/3}$", "Pa·s^(1/3)", "Pa·s<sup>1/3</sup>"),
        (r"$\max\sigma_\mathrm{el}$", "max σₑₗ", "max σ<sub>el</sub>"),
        ("a <b> & c", "a <b> & c", "a &lt;b&gt; &amp; c"),
    ],
)
def test_labels(label: str, letters: str, html: str):
    assert plain(label) == letters
    assert as_html(label) == html


@pytest.mark.parametrize("variable", ALL, ids=lambda variable: variable.name)
def test_every_symbol_of_the_registry_is_known(variable):
    for text in (plain(f"${variable.tex}$"), as_html(f"${variable.tex}$")):
        assert not set("\\{}$") & set(text)
        assert not {"varphi", "mathrm", "omega", "sigma"} & set(text.split())
