"""What two result files have in common, bit for bit, and what else differs between them.

    .venv/bin/python benchmarks/compare_results.py OLD.nc NEW.nc

Ends with 1 where a variable that both files have differs in a bit.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import xarray as xr


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n\n")[0])
    parser.add_argument("old", type=Path)
    parser.add_argument("new", type=Path)
    chosen = parser.parse_args()
    with (
        xr.open_dataset(chosen.old, mask_and_scale=False) as old,
        xr.open_dataset(chosen.new, mask_and_scale=False) as new,
    ):
        both = [name for name in old.variables if name in new.variables]
        differing = [name for name in both if not _equal(old[name], new[name])]
        print(f"variables in both: {len(both)}; with other bits: {_listed(differing)}")
        print(f"only in the old: {_listed(set(old.variables) - set(both))}")
        print(f"only in the new: {_listed(set(new.variables) - set(both))}")
        print(f"attributes of the file: {_listed(_changed(old.attrs, new.attrs))}")
        print(
            "attributes of variables: "
            + _listed(name for name in both if _changed(old[name].attrs, new[name].attrs))
        )
    return 1 if differing else 0


def _equal(one: xr.DataArray, other: xr.DataArray) -> bool:
    """Whether names, shapes, types and every bit of the values agree."""
    same = one.dims == other.dims and one.shape == other.shape and one.dtype == other.dtype
    return same and np.asarray(one).tobytes() == np.asarray(other).tobytes()


def _changed(one: dict[str, object], other: dict[str, object]) -> set[str]:
    """Names of attributes that are not the same."""
    return {name for name in {*one, *other} if repr(one.get(name)) != repr(other.get(name))}


def _listed(names: Iterable[object]) -> str:
    return ", ".join(sorted(map(str, names))) or "none"


if __name__ == "__main__":
    raise SystemExit(main())
