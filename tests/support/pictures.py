"""Small datasets to draw, and the contents of their pictures."""

from __future__ import annotations

import numpy as np
import xarray as xr

from stickslip.status import Status
from stickslip.variables import PARAMETERS, PULLED, RESULTS, TRAJECTORY

VARIABLES = {**PARAMETERS, **TRAJECTORY, **PULLED, **RESULTS}
GAMMAS = (-2 / 3, 0.0, 2 / 3)
TEMPERATURES = np.linspace(150.0, 320.0, 35)


def described(ds: xr.Dataset) -> xr.Dataset:
    for name in map(str, ds.variables):
        if name in VARIABLES:
            ds[name].attrs.update(units=VARIABLES[name].units, symbol=VARIABLES[name].symbol)
    return ds


def sweep(**axes) -> xr.Dataset:
    """Return a sweep whose stress falls along every axis and whose force is constant."""
    shape = tuple(len(values) for values in axes.values())
    ramps = np.meshgrid(*(np.linspace(1.0, 0.2, n) for n in shape), indexing="ij")
    stress = 4e6 * np.prod(ramps, axis=0) if shape else np.array(4.3e6)
    dims = tuple(axes)
    data = {
        "elastic_stress_amplitude": (dims, stress),
        "friction_force_amplitude": (dims, np.full(shape, 4.768e-3)),
        "melting_count": (dims, np.full(shape, 4, dtype="i4")),
        "status": (dims, np.zeros(shape, dtype="i1")),
    }
    fixed = {"block_mass": 0.4, "spring_stiffness": 3000.0, "temperature": 200.0}
    coords = {**{name: value for name, value in fixed.items() if name not in axes}, **axes}
    return described(xr.Dataset(data, coords, attrs={"title": "Three lubricants, γ ≠ 1"}))


def fitted(*hues: float) -> xr.Dataset:
    """Return a fit of four temperatures per frequency; the second datum is next to a jump."""
    axes = {"temperature": TEMPERATURES} | ({"angular_frequency": list(hues)} if hues else {})
    count = 4 * max(len(hues), 1)
    temperature = np.tile([160.0, 200.0, 240.0, 280.0], max(len(hues), 1))
    data = {
        "datum_temperature": temperature,
        "measured_value": np.full(count, 4.8e-3),
        "measured_error": np.full(count, 5e-5),
        "fitted_value": np.full(count, 4.768e-3),
        "residual": np.linspace(-1.0, 1.0, count),
        "datum_at_jump": np.arange(count) == 1,
    } | ({"datum_angular_frequency": np.repeat(hues, 4)} if hues else {})
    of_parameters = {"parameter_value": [7e4], "parameter_standard_error": [2e3]}
    ds = sweep(**axes).assign({name: ("datum", values) for name, values in data.items()})
    ds = ds.assign({name: ("free_parameter", values) for name, values in of_parameters.items()})
    coords = {
        "datum_variable": ("datum", ["friction_force_amplitude"] * count),
        "free_parameter": ["viscosity_coefficient"],
    }
    return ds.assign_coords(coords).assign_attrs(reduced_chi2=1.2)


def drawn() -> xr.Dataset:
    """Return a fit with a posterior of k and gamma, which are correlated."""
    k, gamma = (
        np.random.default_rng(1)
        .multivariate_normal([7e4, -0.55], [[4e6, -6.0], [-6.0, 1e-5]], (8, 200))
        .transpose(2, 0, 1)
    )
    names = ["viscosity_coefficient", "rheological_index"]
    ds = fitted().drop_dims("free_parameter")
    ds = ds.assign(posterior_draws=(("free_parameter", "chain", "draw"), [k, gamma]))
    ds = ds.assign(
        parameter_value=("free_parameter", [7e4, -0.55]),
        parameter_standard_error=("free_parameter", [2e3, 3e-3]),
    )
    return ds.assign_coords(free_parameter=names).assign_attrs(posterior_independent_draws=1600.0)


def failed(ds: xr.Dataset, status: Status, **index) -> xr.Dataset:
    """Return the sweep with another status of some points, as in a result file."""
    ds = ds.copy(deep=True)
    ds["status"][index] = status
    for name in ("elastic_stress_amplitude", "friction_force_amplitude"):
        ds[name][index] = np.nan
    return ds


def linked(ds: xr.Dataset) -> xr.Dataset:
    """Return a sweep along `case` with the parameters of two to nine linked cases."""
    count = ds.sizes["case"]
    amplitude = np.linspace(0.4e-6, 0.8e-6, count)
    linked_coords = {
        "drive_amplitude": ("case", amplitude),
        "angular_frequency": ("case", 8e-6 / amplitude),
    }
    return described(ds.assign_coords(case=np.arange(count, dtype="i4"), **linked_coords))


def both_ways(ds: xr.Dataset) -> xr.Dataset:
    """Return the sweep upward, and downward with half its stress."""
    down = ds.assign(elastic_stress_amplitude=ds.elastic_stress_amplitude * 0.5)
    both = xr.concat([ds, down], dim="direction", combine_attrs="override")
    return described(both.assign_coords(direction=["up", "down"]))


def random_cases(count: int = 60, **varied: tuple[float, float]) -> xr.Dataset:
    """Return a sweep over unordered linked cases, a third each of the regimes 0, 1 and 2."""
    ds = sweep(case=np.arange(count))
    rng = np.random.default_rng(7)
    coords = {name: ("case", rng.uniform(*bounds, count)) for name, bounds in varied.items()}
    ds = ds.drop_vars([name for name in coords if name in ds.coords]).assign_coords(coords)
    return described(ds.assign(regime=("case", (np.arange(count) % 3).astype("i1"))))


def motion(omega: float = 10.0, start: float = 0.0, samples: int = 400) -> dict[str, np.ndarray]:
    t = start + np.linspace(0.0, 2 * 2 * np.pi / omega, samples)
    X, V = 0.8e-6 * np.cos(omega * t), -0.8e-6 * omega * np.sin(omega * t)
    x, v = 0.3e-6 * np.sin(3 * omega * t), 0.9e-6 * omega * np.cos(3 * omega * t)
    strain = (V - v) * 10.0
    columns = [t, X, x, V, v, np.full_like(t, 0.6), strain, strain * 1e12, strain * 1e9, V * 500]
    return dict(zip(TRAJECTORY, columns, strict=True))


def trajectory() -> xr.Dataset:
    columns = motion()
    time = columns.pop("elapsed_time")
    columns["spring_force"] = 6000.0 * columns["lower_displacement"]
    data = {name: ("elapsed_time", values) for name, values in columns.items()}
    return described(xr.Dataset(data, {"elapsed_time": time, "temperature": 200.0}))


def trajectories(dim: str, values, columns) -> xr.Dataset:
    data = {name: ((dim, "sample"), np.stack([c[name] for c in columns])) for name in TRAJECTORY}
    return described(xr.Dataset(data, {dim: list(values)}).set_coords("elapsed_time"))


def portraits() -> xr.Dataset:
    omegas = (10.0, 15.0, 32.0, 38.0)
    return trajectories("angular_frequency", omegas, [motion(omega) for omega in omegas])


def curves(axes):
    """Return the lines of a panel that show data."""
    furniture = {"missing", "origin", "border", "jump"}
    return [line for line in axes.get_lines() if line.get_gid() not in furniture]


def crosses(axes):
    return [line for line in axes.get_lines() if line.get_gid() == "missing"]


def jumps(axes):
    """Return the positions of the dotted lines of a panel."""
    return [float(line.get_xdata()[0]) for line in axes.get_lines() if line.get_gid() == "jump"]


def legend_of(figure) -> list[str]:
    return [text.get_text() for legend in figure.legends for text in legend.get_texts()]


def note(figure) -> str:
    return figure.get_supxlabel().replace("\n", " ")


def panels(figure):
    return [axes for axes in figure.axes if axes.get_label() != "<colorbar>"]
