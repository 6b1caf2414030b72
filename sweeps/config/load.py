"""A config: what to compute and how, read strictly from YAML or from a dict.

Nothing here computes physics: checks that do are handed to `load` as functions.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

from stickslip.options import STOCHASTIC, default_window, methods_for
from stickslip.parameters import Parameters
from stickslip.variables import PARAMETERS, canonical_name
from sweeps.config.diagnostics import ConfigError, Diagnostics, Located, Problem, located, quoted
from sweeps.config.numbers import text
from sweeps.config.order import Refine, read_follow, read_refine
from sweeps.config.overrides import apply_overrides
from sweeps.config.parameter_space import (
    PARAMETER_SECTIONS,
    read_parameter_space,
    refuse_frozen_start,
    refuse_unbounded_films,
)
from sweeps.config.sample import settle_sample
from sweeps.config.schedule import settle_schedule
from sweeps.config.schema import (
    DEFINING,
    SECTIONS,
    Execution,
    Integrator,
    Noise,
    Section,
    Sections,
    Stationary,
    is_local,
    read_section,
)
from sweeps.config.yaml_reader import read_file, read_text
from sweeps.config.yaml_writer import block_yaml
from sweeps.human import did_you_mean

__all__ = ["Check", "Config", "ConfigError", "Problem", "from_mapping", "from_yaml", "load"]

KEYS = ("title", "model", "sweep", "cases", "sample", "follow", "refine", *SECTIONS, "output")


class Config(Sections):
    """A config without problems, every key resolved; made by `load` and `from_mapping`.

    Parameters go by their full names. `model` holds the fixed ones that were given; `parameters`
    adds the paper's values for the rest. `sweep` keeps the order of its axes. What `sample` draws
    stands in `cases`; `sampled` says how. Two configs are equal if they ask for the same
    computation, executed in the same way into the same file.
    """

    title: str | None
    model: dict[str, float]
    sweep: dict[str, tuple[float, ...]]
    cases: dict[str, tuple[float, ...]]
    output: str
    follow: str | None = None
    refine: Refine | None = None
    sampled: str = ""
    warnings: tuple[str, ...] = ()

    def parameters(self) -> Parameters:
        """The fixed parameters, with the paper's values for those that are not given."""
        return Parameters(**self.model)

    def defining(self) -> dict[str, Section]:
        """The sections that, besides the parameters, make the numbers of a point."""
        return {name: getattr(self, name) for name in DEFINING}

    def resolved(self) -> dict[str, Any]:
        """Everything that defines the result, without `execution` and `output`, ready for JSON."""
        varied = {*self.sweep, *self.cases}
        fixed = self.parameters()._asdict()
        title = {} if self.title is None else {"title": self.title}
        return title | {
            "model": {name: value for name, value in fixed.items() if name not in varied},
            "sweep": {name: list(values) for name, values in self.sweep.items()},
            "cases": {name: list(values) for name, values in self.cases.items()},
            **self.order(),
            **{name: section.used() for name, section in self.defining().items()},
            "plot": self.plot.model_dump(exclude_none=True),
            "simulation": self.simulation.model_dump(mode="json", exclude_none=True),
        }

    def order(self) -> dict[str, Any]:
        """The keys that say in which order points are computed, and which, where they are given."""
        follow = {} if self.follow is None else {"follow": self.follow}
        return follow | ({} if self.refine is None else {"refine": self.refine.resolved()})

    def resolved_yaml(self) -> str:
        """`resolved` as YAML; loading it gives an equal config but for `execution` and `output`."""
        return block_yaml(self.resolved())

    def sha256(self) -> str:
        """Hash of what defines the numbers of a sweep: title, plot and simulation do not enter."""
        resolved = self.resolved()
        parts: dict[str, Any] = {key: resolved[key] for key in (*PARAMETER_SECTIONS, *DEFINING)}
        parts |= self.order()
        # As pairs, because the order of the axes is the order of the dimensions.
        parts["sweep"] = list(parts["sweep"].items())
        canonical = json.dumps(parts, sort_keys=True, separators=(",", ":"), allow_nan=False)
        return hashlib.sha256(canonical.encode()).hexdigest()

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Config):
            return NotImplemented
        return self._identity() == other._identity()

    def __hash__(self) -> int:
        return hash(self._identity())

    def _identity(self) -> tuple[str, str, Execution]:
        return self.resolved_yaml(), self.output, self.execution


# Looks at a config that is otherwise sound, and yields the key and the message of each problem.
Check: TypeAlias = Callable[[Config], Iterable[tuple[str, str]]]


def load(
    path: str | Path, overrides: Sequence[str] = (), *, checks: Sequence[Check] = ()
) -> Config:
    """The config in a YAML file; the default output is `results/<stem of the file>.nc`.

    `overrides` are `KEY=VALUE` texts as of `--set`; see `sweeps.config.overrides`. `checks` look at
    a config that is otherwise sound, such as those that need the physics.

    Raises ConfigError where the file cannot be used; all problems are reported at once.
    """
    path, diagnostics = Path(path), Diagnostics()
    root = read_file(path, diagnostics)
    return _config(root, diagnostics, overrides, f"results/{path.stem}.nc", checks)


def from_mapping(
    mapping: Mapping[str, Any],
    source: str = "<dict>",
    overrides: Sequence[str] = (),
    *,
    checks: Sequence[Check] = (),
) -> Config:
    """Return the config in a dict of the same shape as a file; see `load`.

    The default output is `results/sweep.nc`; `source` stands for the file in messages.
    """
    diagnostics = Diagnostics()
    root = located(mapping, source, diagnostics)
    return _config(root, diagnostics, overrides, "results/sweep.nc", checks)


def from_yaml(yaml: str, source: str = "<text>", overrides: Sequence[str] = ()) -> Config:
    """The config in a YAML text, such as the one that a result file carries; see `load`."""
    diagnostics = Diagnostics()
    root = read_text(yaml, source, diagnostics)
    return _config(root, diagnostics, overrides, "results/sweep.nc", ())


def _config(
    root: Located | None,
    diagnostics: Diagnostics,
    overrides: Sequence[str],
    output: str,
    checks: Sequence[Check],
) -> Config:
    if root is not None and not isinstance(root.value, dict):
        root.refuse(f"must hold lines `key: value`, not {quoted(root.value)}")
        root = None
    # Overrides of an unreadable config are judged all the same, on an empty one.
    base = root or located({}, "", diagnostics)
    case = apply_overrides(base, overrides, diagnostics)
    fields = _fields(base, case, output) if root else {}
    diagnostics.raise_problems()
    config = Config(**fields, warnings=tuple(map(str, diagnostics.warnings)))
    for check in checks:
        for key, message in check(config):
            base.refuse(message, *key.split("."))
    diagnostics.raise_problems()
    return config


def _fields(root: Located, case: Located | None, output: str) -> dict[str, Any]:
    for key in root.value:
        if key not in KEYS:
            root.refuse(f"unknown key{_place_or_name(key)}", key)
    sampled = settle_sample(root)
    space = read_parameter_space(root, case)
    settle_schedule(root, space)
    sections = {name: read_section(root, name) for name in SECTIONS}
    _refuse_strangers(root)
    refuse_unbounded_films(root, space)
    _refuse_unfit(root, sections)
    noise, follow = sections["noise"], read_follow(root, space)
    if isinstance(noise, Noise):
        refuse_frozen_start(root, space, noise.treatment)
        sections |= with_noise(sections, noise)
        if follow and noise.treatment == STOCHASTIC:
            stochastic = f"`noise: {{treatment: {STOCHASTIC}}}`"
            root.refuse(f"does not go together with {stochastic}: no state to go on from", "follow")
    return {
        "title": _text(root, "title", None),
        "model": space.model,
        "sweep": space.sweep,
        "cases": space.cases,
        "output": _text(root, "output", output),
        "follow": follow,
        "refine": read_refine(root, space),
        "sampled": sampled,
        **sections,
    }


def with_noise(sections: Mapping[str, Any], noise: Noise) -> dict[str, Any]:
    """The sections that change with a treatment of the noise, every key of them resolved."""
    stationary = sections["stationary"]
    if isinstance(stationary, Stationary) and "window" not in stationary.model_fields_set:
        window = {"window": default_window(noise.treatment)}
        stationary = Stationary.model_construct(
            stationary.model_fields_set, **{**dict(stationary), **window}
        )
    return {"noise": noise.settled(), "stationary": stationary}


def _refuse_strangers(root: Located) -> None:
    """Refuse a scheduler on another machine that a file names: it can run code on this one.

    Whoever gives it on the command line, or in Python, means it.
    """
    node = root.children().get("execution")
    named = node.children().get("scheduler") if node else None
    if named and named.line is not None and not is_local(str(named.value)):
        named.refuse(
            f"{quoted(named.value)} is another machine, whose answers could run code on this one; "
            "if you trust it, leave the line out and give it as --scheduler ADDRESS"
        )


def _place_or_name(key: str) -> str:
    """Where an unknown key would be right, or which key may be meant."""
    if canonical_name(key):
        return "; a parameter stands under `model`, `sweep` or `cases`"
    homes = [f"`{name}`" for name, section in SECTIONS.items() if key in section.model_fields]
    if homes:
        return f"; it stands under {' or '.join(homes)}"
    return did_you_mean(key, [*KEYS, *PARAMETERS]) or f"; known are {', '.join(KEYS)}"


def _refuse_unfit(root: Located, sections: Mapping[str, Any]) -> None:
    """Refuse a model of the strain or a treatment of the noise that the method does not know."""
    integrator = sections["integrator"]
    for section, key, field in (("film", "strain", "strains"), ("noise", "treatment", "noises")):
        choice = getattr(sections[section], key, None)
        if isinstance(integrator, Integrator) and choice is not None:
            able = methods_for(field, choice)
            if integrator.method not in able:
                message = f"{choice} needs `integrator: {{method: {' or '.join(able)}}}`"
                root.refuse(message, section, key)


def _text(root: Located, key: str, default: str | None) -> str | None:
    node = root.value.get(key)
    value = node.read(text) if node and node.value is not None else None
    if value is not None and not value.strip():
        node.refuse("must not be empty; leave it out instead")
    return default if value is None else value
