"""Spectral radii against a general solver, and where the eigenvectors are of no help."""

import numpy as np
import pytest

from stickslip.numerics.spectrum import spectral_radii


@pytest.mark.parametrize("width", [1, 2, 3, 4])
def test_random_matrices_of_any_size(width: int) -> None:
    rng = np.random.default_rng(width)
    matrices = rng.normal(size=(500, width, width)) * 10.0 ** rng.uniform(-8, 8, (500, 1, 1))
    expected = np.abs(np.linalg.eigvals(matrices)).max(axis=1)
    np.testing.assert_allclose(spectral_radii(matrices), expected, rtol=2e-6)


def test_nearly_parallel_eigenvectors() -> None:
    jordan = np.array([[0.5, 1e6, 0.0], [0.0, 0.5, 1e6], [0.0, 0.0, 0.5]])
    assert spectral_radii(jordan[None])[0] == pytest.approx(0.5, rel=1e-5)


def test_a_tiny_matrix_has_a_radius() -> None:
    tiny = 1e-161 * np.array([[[-0.7, 6e-4, 0.0], [-56.0, 0.05, 0.0], [6e-3, 0.0, 0.0]]])
    assert 0.0 <= spectral_radii(tiny)[0] < 1e-150


def test_a_nilpotent_matrix_has_radius_0() -> None:
    nilpotent = np.diag([1.0, 1.0], 1)
    np.testing.assert_array_equal(spectral_radii(np.stack([nilpotent, 0.0 * nilpotent])), 0.0)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_an_unknown_entry_affects_only_its_own_radius(bad: float) -> None:
    matrices = np.stack([np.eye(3), np.eye(3)])
    matrices[0, 1, 2] = bad
    radii = spectral_radii(matrices)
    assert np.isnan(radii[0])
    assert radii[1] == pytest.approx(1.0)
