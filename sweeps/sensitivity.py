"""Sobol indices over the box that a config samples, for `stickslip sensitivity`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from stickslip.boxes import BoxError, Design
from stickslip.datasets import parameter_scalars
from stickslip.indices import (
    LARGEST_MISSING,
    indices_of,
    refuse_confidence,
    refuse_share,
    results_named,
)
from sweeps.config.load import Config
from sweeps.engine.run import compute
from sweeps.exits import ExpectedError
from sweeps.files.attributes import add_provenance
from sweeps.human import counted

if TYPE_CHECKING:
    import xarray as xr

_EXAMPLE = "sample: {sobol: 1024, temperature: [200, 280], k: {log: [2e4, 2e5]}}"


class SensitivityError(ExpectedError, ValueError):
    """A config or an option that gives no indices; the message says what would help."""


@dataclass(frozen=True)
class Request:
    """A request for indices of results over the box that a config samples.

    Raises SensitivityError for a config or an option that gives no indices.
    """

    config: Config
    of: Sequence[str]
    confidence: float = 0.95
    largest_missing: float = LARGEST_MISSING
    design: Design = field(init=False, repr=False)

    def __post_init__(self) -> None:
        with _refusals():
            object.__setattr__(self, "of", results_named(self.of))
            refuse_confidence(self.confidence)
            refuse_share(self.largest_missing)
            object.__setattr__(self, "design", _design_of(self.config))

    def computed(self, *, progress: bool = False) -> xr.Dataset:
        """Return the indices, with the attributes of a file; raises SensitivityError.

        `stickslip.sensitivity_indices` gives the same indices for the same box.
        """
        config, design = self.config, self.design
        points = {name: tuple(values.tolist()) for name, values in design.points().items()}
        rows = compute(
            config.model_copy(update={"sample": None, "cases": points}), progress=progress
        )
        with _refusals():
            ds = indices_of(
                design,
                rows,
                list(self.of),
                seed=config.sample.seed if config.sample else 0,
                confidence=self.confidence,
                largest_missing=self.largest_missing,
            )
        constant = {n: v for n, v in config.parameters()._asdict().items() if n not in design.box}
        box = ", ".join(f"{name} {limits}" for name, limits in design.box.items())
        title = config.title or "Sensitivity of stationary amplitudes over a box"
        return add_provenance(
            ds.assign_coords(parameter_scalars(constant)),
            config,
            title,
            f"Sobol indices over {box}",
        )


@contextmanager
def _refusals() -> Iterator[None]:
    try:
        yield
    except BoxError as error:
        raise SensitivityError(str(error)) from None


def _design_of(config: Config) -> Design:
    """Return the design for the box of a config; raises SensitivityError."""
    sample = config.sample
    if sample is None or not sample.sobol:
        raise SensitivityError(
            f"indices need a box that a Sobol sequence samples; write {_EXAMPLE}"
        )
    if sample.fitted or config.sweep or config.follow:
        key = "from" if sample.fitted else "sweep" if config.sweep else "follow"
        why = ", but parameters of a fit are correlated" if sample.fitted else " over one box"
        raise SensitivityError(
            f"indices need parameters that vary independently{why}: leave out `{key}`, and give "
            "each parameter a range in `sample`"
        )
    return Design.of(sample.ranges, sample.sobol, sample.seed)


def summary_of(ds: xr.Dataset) -> str:
    """Return the indices as a table for people, with the number of points behind them."""
    used = ds.attrs["base_points"] - ds.attrs["base_points_without_result"]
    percent = f"{100 * ds.attrs['confidence_level']:g}"
    rows = f"{counted(ds.attrs['points'], 'point')}, {used} of {ds.attrs['base_points']}"
    lines = [f"{rows} base points used; {percent} % intervals"]
    shares = ds.regime_share[ds.regime_share > 0].sortby(ds.regime_share, ascending=False)
    kinds = (f"{float(share):.1%} {share.regime.values!s}" for share in shares)
    lines.append(f"motions: {', '.join(kinds)}")
    width = max(len(str(name)) for name in ds.parameter.values)
    for name in map(str, ds.result.values):
        one = ds.sel(result=name)
        lines += ["", f"{name:<{width}}  first order            total"]
        order = one.total_order.fillna(0).argsort().values[::-1]
        for parameter in map(str, ds.parameter.values[order]):
            at = one.sel(parameter=parameter)
            cells = (_cell(at[o], at[f"{o}_interval"]) for o in ("first_order", "total_order"))
            lines.append(f"{parameter:<{width}}  {'  '.join(cells)}")
    return "\n".join(lines)


def _cell(index: xr.DataArray, interval: xr.DataArray) -> str:
    if index.isnull():
        return f"{'does not vary':<21}"
    if interval.isnull().any():
        return f"{float(index):5.2f} {'no interval':<15}"
    low, high = interval.values
    return f"{float(index):5.2f} [{low:5.2f}, {high:5.2f}]"
