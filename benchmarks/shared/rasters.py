"""Borders turned into the pixels of a finer map, to be compared with pixels that were computed."""

from __future__ import annotations

from collections import defaultdict

import numpy as np
import xarray as xr

CORNERS = np.array([(0, 0), (1, 0), (0, 1), (1, 1)])


def raster(coarse: xr.Dataset, borders: xr.Dataset, size: int) -> np.ndarray:
    """Return the regimes (size, size) of a finer map, as the lines of a coarse one have them.

    A pixel has the regime of a corner of its cell that it sees without a line of the cell between
    them; where it sees none, that of its side of the nearest line.
    """
    regimes = coarse.regime.values
    per_cell = (size - 1) // (len(regimes) - 1)
    nearest = (np.arange(size) + (per_cell - 1) // 2) // per_cell
    drawn = regimes[np.ix_(nearest, nearest)]
    ticks = np.arange(per_cell + 1) / per_cell
    pixels = np.stack(np.meshgrid(ticks, ticks, indexing="ij"), axis=-1).reshape(-1, 2)
    for cell, (parts, kinds) in _parts_by_cell(coarse, borders).items():
        i, j = np.array(cell) * per_cell
        corners = regimes[tuple((CORNERS + cell).T)]
        seen = _sees(pixels, parts)
        found = np.where(
            seen.any(axis=1), corners[seen.argmax(axis=1)], _side(pixels, parts, kinds)
        )
        own = found.reshape(len(ticks), len(ticks))
        drawn[i : i + per_cell + 1, j : j + per_cell + 1] = own
    return drawn


def _parts_by_cell(
    coarse: xr.Dataset, borders: xr.Dataset
) -> dict[tuple[int, int], tuple[np.ndarray, np.ndarray]]:
    """Return the straight parts (n, 2, 2) of lines in each cell, in cells, and their kinds."""
    axes = [coarse[dim].values for dim in coarse.regime.dims]
    names = coarse.regime.dims
    places = [
        (borders[name].values - axis[0]) / (axis[1] - axis[0])
        for name, axis in zip(names, axes, strict=True)
    ]
    points = np.column_stack(places)
    sides = np.column_stack([borders.kind_left, borders.kind_right])
    found: dict[tuple[int, int], list[tuple[np.ndarray, np.ndarray]]] = defaultdict(list)
    for number in np.flatnonzero(np.diff(borders.line.values) == 0):
        part = points[number : number + 2]
        i, j = np.floor(part.mean(axis=0)).astype(int)
        found[int(i), int(j)].append((part - (i, j), sides[number]))
    return {
        cell: (np.array([part for part, _ in own]), np.array([kinds for _, kinds in own]))
        for cell, own in found.items()
    }


def _sees(pixels: np.ndarray, parts: np.ndarray) -> np.ndarray:
    """Tell which corners (n, 4) each pixel (n, 2) sees past the parts (m, 2, 2) of lines."""
    p, q = pixels[:, None, None], CORNERS[None, :, None]
    a, b = parts[None, None, :, 0], parts[None, None, :, 1]
    apart = (_turn(a, b, p) * _turn(a, b, q) > 0) | (_turn(p, q, a) * _turn(p, q, b) > 0)
    return (apart | (p == q).all(axis=-1)).all(axis=-1)


def _turn(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Return twice the area of triangles, positive where they turn left; tiny ones are 0."""
    area = (b - a)[..., 0] * (c - a)[..., 1] - (b - a)[..., 1] * (c - a)[..., 0]
    return np.where(np.abs(area) < 1e-9, 0.0, area)


def _side(pixels: np.ndarray, parts: np.ndarray, kinds: np.ndarray) -> np.ndarray:
    """Return the kinds (n,) of pixels on their side of the nearest part of a line."""
    begin, along = parts[:, 0], parts[:, 1] - parts[:, 0]
    offset = pixels[:, None] - begin
    length = (along**2).sum(axis=-1) + 1e-300
    share = np.clip((offset * along).sum(axis=-1) / length, 0.0, 1.0)
    nearest = ((offset - share[..., None] * along) ** 2).sum(axis=-1).argmin(axis=1)
    left = _turn(parts[nearest, 0], parts[nearest, 1], pixels) >= 0
    return np.where(left, kinds[nearest, 0], kinds[nearest, 1])
