"""Configs as tired people and broken disks write them, each with its expected outcome.

`refused(line, part of the message)`: ConfigError with a problem in that line; `warned`: accepted
with a warning; `valid`: accepted without one.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Outcome:
    kind: str
    line: int | None = None
    part: str = ""


def refused(line: int | None, part: str) -> Outcome:
    return Outcome("refused", line, part)


def warned(line: int, part: str) -> Outcome:
    return Outcome("warned", line, part)


valid = Outcome("valid")

SYNTAX: list[tuple[str, str | bytes, Outcome]] = [
    ("empty file", "", refused(None, "is empty")),
    ("only comments", "# nothing\n\n", refused(None, "is empty")),
    ("only a document start", "---\n", refused(None, "is empty")),
    ("an empty mapping", "{}\n", valid),
    ("a document start before the config", "---\nmodel: {T: 250}\n...\n", valid),
    ("two documents", "model: {}\n---\nmodel: {}\n", refused(2, "second document")),
    ("indented with a tab", "model:\n\tT: 200\n", refused(2, "tab")),
    ("a tab behind spaces", "model:\n  \tT: 200\n", refused(2, "tab")),
    ("a tab before a comment", "model:\n  T: 200\t# K\n", refused(2, "spaces instead of tabs")),
    ("an empty line with a tab", "model:\n\t\n  T: 200\n", refused(2, "spaces instead of tabs")),
    ("Windows line ends", "model:\r\n  T: 200\r\n", valid),
    ("UTF-8 byte order mark", b"\xef\xbb\xbfmodel: {T: 250}\n", valid),
    ("UTF-16", "model: {}\n".encode("utf-16"), refused(1, "not UTF-8")),
    ("Latin-1", "model: {}\ntitle: Reibungsmaß\n".encode("latin-1"), refused(2, "not UTF-8")),
    ("NUL", b"model:\n  T: 2\x0000\n", refused(2, "control character")),
    ("a file of NULs", b"\x00" * 4096, refused(1, "control character")),
    ("escape character", b"title: a\x1b[31m\n", refused(1, "control character")),
    ("a NetCDF file", b"\x89HDF\r\n\x1a\n", refused(1, "not UTF-8")),
    ("larger than 1 MiB", "#" * (1 << 20) + "\n{}", refused(None, "1 MiB")),
    ("exactly 1 MiB", "{}" + "\n" * ((1 << 20) - 2), valid),
    ("a scalar", "200\n", refused(1, "must hold lines")),
    ("a list", "- T: 200\n", refused(1, "must hold lines")),
    ("no space after a colon", "model:\n  T:200\n", refused(1, "must hold lines")),
    ("an unclosed bracket", "sweep:\n  T: [200, 250\n", refused(3, "bracket")),
    ("an unclosed brace", "model: {T: 200\n", refused(2, "bracket")),
    ("an unclosed quote", 'title: "Fig. 7\nmodel: {}\n', refused(3, "closing quote")),
    ("a colon in a text", "title: Fig. 7: T\n", refused(1, "quotes")),
    ("an @", "title: @home\n", refused(1, "cannot start any token")),
    ("wrong indentation", "model:\n    T: 200\n  K: 3\n", refused(3, "not valid YAML")),
    ("an escape beyond Unicode", 'title: "\\UFFFFFFFF"\n', refused(None, "not valid YAML")),
    ("an escaped surrogate", 'title: "\\ud800"\n', refused(1, "control characters")),
    ("10 000 brackets deep", "sweep: " + "[" * 10_000 + "\n", refused(1, "nested")),
    ("10 000 brackets, closed", "[" * 10_000 + "]" * 10_000, refused(1, "nested")),
    ("10 000 braces deep", "model: " + "{a: " * 10_000 + "\n", refused(1, "nested")),
    ("10 000 dashes deep", "sweep:\n  " + "- " * 10_000 + "\n", refused(2, "nested")),
    ("10 000 question marks deep", "? " * 10_000 + "\n", refused(1, "nested")),
]

SEMANTICS: list[tuple[str, str | bytes, Outcome]] = [
    ("YAML 1.1 floats", "model: {h: 1e-9, a: 4e12, x_0: -.5, T: 1E2}\n", valid),
    ("a leading zero", "model: {T: 010}\n", valid),
    ("an octal and a hexadecimal number", "model: {T: 0o310, K: 0xbb8}\n", valid),
    ("a fraction", "model: {gamma: -2/3}\n", valid),
    ("a quoted fraction", "model: {gamma: '-2/3'}\n", valid),
    ("a fraction by zero", "model: {gamma: 2/0}\n", refused(1, "divides by zero")),
    ("a sum", "model:\n  gamma: 1/3+1/3\n", refused(2, "nothing is computed")),
    ("sexagesimal", "model: {T: 1:30}\n", refused(1, "colon")),
    ("underscores", "model: {K: 1_000}\n", refused(1, "without underscores")),
    ("a thousands separator", "model:\n  K: 3,000\n", refused(2, "thousands")),
    ("a thousands separator in braces", "model: {K: 3,000}\n", refused(1, "3000")),
    ("a thousands separator in a list", "sweep: {T: [1,000]}\n", warned(1, "3000")),
    ("a decimal comma", "model:\n  M: 0,4\n", refused(2, "decimal point")),
    ("a unit", "model:\n  K: 3000 N/m\n", refused(2, "alone, in SI units")),
    ("a unit without a space", "model:\n  h: 1nm\n", refused(2, "alone, in SI units")),
    ("a quoted number", "model:\n  K: '3000'\n", refused(2, "without quotes")),
    ("a block scalar number", "model:\n  K: |\n    3000\n", refused(2, "without quotes")),
    ("a word", "model:\n  T: no\n", refused(2, "must be a number, not 'no'")),
    ("a boolean", "model:\n  T: true\n", refused(2, "must be a number, not true")),
    ("nothing", "model:\n  T:\n", refused(2, "must be a number, not nothing")),
    ("a number of 5000 digits", f"model: {{T: {'9' * 5000}}}\n", refused(1, "finite")),
    ("5000 hexadecimal digits", f"model: {{T: 0x{'f' * 5000}}}\n", refused(1, "finite")),
    ("nan as YAML has it", "model: {T: .nan}\n", refused(1, "finite")),
    ("nan as Python has it", "model: {T: nan}\n", refused(1, "must be a number")),
    ("infinity", "model:\n\n  K: .inf\n", refused(3, "finite")),
    ("1e999", "model: {K: 1e999}\n", refused(1, "finite")),
    ("a key twice", "model:\n  T: 200\n  T: 250\n", refused(3, "given twice (first in line 2)")),
    ("a section twice", "model: {}\nsweep: {}\nmodel: {}\n", refused(3, "given twice")),
    ("an anchor", "model: &m {T: 200}\n", refused(1, "anchor &m")),
    ("an alias", "model:\n  T: *t\n", refused(2, "alias *t")),
    ("a merge key", "model:\n  <<: {T: 200}\n", refused(2, "merge keys")),
    ("a tag", "model:\n  T: !!float 200\n", refused(2, "tag")),
    ("a tag without a name", "model: {T: ! 3}\n", refused(1, "tag")),
    ("an alias in a list", "sweep:\n  T:\n    - 1\n    - *t\n", refused(4, "T[1]: the alias *t")),
    ("a tag that runs code", "title: !!python/object/apply:os.system [ls]\n", refused(1, "tag")),
    ("a directive", "%YAML 1.1\n---\n{}\n", refused(1, "directives")),
    ("a list as a key", "model:\n  [T]: 200\n", refused(2, "a key must be a name")),
    ("a billion laughs", "a: &a [x, x]\nb: &b [*a, *a]\nc: [*b, *b]\n", refused(2, "alias *a")),
]

SCHEMA: list[tuple[str, str | bytes, Outcome]] = [
    ("a misspelt section", "{}\n".replace("{}", "modle: {T: 200}"), refused(1, "'model'?")),
    ("a misspelt parameter", "model:\n  temprature: 3\n", refused(2, "'temperature'?")),
    ("a parameter at the top", "temperature: 250\n", refused(1, "stands under `model`")),
    ("a setting at the top", "dt: 1e-9\n", refused(1, "stands under `integrator`")),
    ("a misspelt setting", "stationary: {max_period: 3}\n", refused(1, "'max_periods'?")),
    ("model is a number", "model: 200\n", refused(1, "must hold lines")),
    ("sweep is a list", "sweep: [T]\n", refused(1, "must hold lines")),
    ("integrator is a word", "integrator: adaptive\n", refused(1, "method, rtol, dt")),
    ("an empty section", "model:\nsweep:\nintegrator:\ntitle:\n", valid),
    ("a list as fixed value", "model:\n  T: [200, 250]\n", refused(2, "under `sweep`")),
    ("a title without quotes", "title: 2013\n", refused(1, "put it in quotes")),
    ("an empty output", "output: ''\n", refused(1, "must not be empty")),
    ("output is a list", "output: [a.nc]\n", refused(1, "must be a text")),
    ("a method that is not there", "integrator: {method: rk4}\n", refused(1, "'adaptive' or")),
    ("dt with the adaptive method", "integrator:\n  method: adaptive\n  dt: 1e-9\n",
     refused(3, "belongs to `method: euler-cromer`")),
    ("dt with the default method", "integrator: {dt: 1e-9}\n", refused(1, "euler-cromer")),
    ("rtol with a fixed step", "integrator: {method: euler-cromer, rtol: 1e-6}\n",
     refused(1, "belongs to `method: adaptive`")),
    ("a fixed step", "integrator: {method: euler-cromer, dt: 1e-9}\n", valid),
    ("dt of 0", "integrator: {method: euler-cromer, dt: 0}\n", refused(1, "greater than 0")),
    ("dt below 0", "integrator: {method: euler-cromer, dt: -1e-9}\n", refused(1, "than 0")),
    ("infinite dt", "integrator: {method: euler-cromer, dt: .inf}\n", refused(1, "finite")),
    ("rtol of 0", "integrator: {rtol: 0}\n", refused(1, "greater than 1e-13")),
    ("rtol of 1", "integrator: {rtol: 1}\n", refused(1, "at most 0.01")),
    ("rtol of the stationary regime", "stationary: {rtol: 1e-14}\n", refused(1, "than 1e-13")),
    ("0 steps", "integrator: {max_steps: 0}\n", refused(1, "at least 1")),
    ("half a step", "integrator: {max_steps: 1.5}\n", refused(1, "whole number")),
    ("2^200 steps", f"integrator: {{max_steps: {2**200}}}\n", refused(1, "at most")),
    ("a million steps", "integrator: {max_steps: 1e6}\n", valid),
    ("0 periods", "stationary: {max_periods: 0}\n", refused(1, "at least 1")),
    ("a switch that is a word", "stationary: {accelerate: yes}\n", refused(1, "boolean")),
    ("a switch", "stationary: {accelerate: false}\n", valid),
    ("0 periods of a trajectory", "simulation: {periods: 0}\n", refused(1, "at least 1")),
    ("too many samples", "simulation:\n  periods: 1e4\n  samples_per_period: 1e5\n",
     refused(1, "at most 100000000")),
    ("start of a trajectory", "simulation: {start: settled}\n", refused(1, "'stationary'")),
    ("true workers", "execution: {workers: true}\n", refused(1, "must be a number")),
    ("0 workers", "execution: {workers: 0}\n", refused(1, "at least 1")),
    ("processes", "execution: {backend: loky}\n", valid),
    (
        "a running cluster",
        "execution: {backend: dask, scheduler: 'tcp://localhost:8786'}\n",
        valid,
    ),
    ("a cluster on another machine",
     "execution:\n  backend: dask\n  scheduler: tcp://10.0.0.1:8786\n",
     refused(3, "another machine")),
    ("a backend that is not there", "execution: {backend: mpi}\n",
     refused(1, "must be 'threads', 'loky'")),
    ("a misspelt backend", "execution: {backend: thread}\n", refused(1, "'threads'?")),
    ("a scheduler for threads", "execution: {scheduler: 'tcp://a:1'}\n", refused(1, "dask")),
    ("a scheduler for processes", "execution:\n  backend: loky\n  scheduler: tcp://a:1\n",
     refused(3, "belongs to `backend: dask`, but the backend is loky")),
    ("a scheduler without a scheme", "execution:\n  backend: dask\n  scheduler: 'host:8786'\n",
     refused(3, "must be an address such as tcp://host:8786, not 'host:8786'")),
    ("a scheduler that is a number", "execution: {backend: dask, scheduler: 8786}\n",
     refused(1, "text")),
    ("0 points in a block", "execution: {block_points: 0}\n", refused(1, "at least 1")),
    ("no noise, capitalised", "noise: {treatment: None}\n", refused(1, "'none'?")),
    ("stochastic noise", "noise: {treatment: stochastic, realizations: 3}\n", valid),
    ("no realization", "noise: {treatment: stochastic, realizations: 0}\n",
     refused(1, "at least 1")),
    ("realizations of a typical path", "noise: {realizations: 3}\n",
     refused(1, "belongs to `treatment: stochastic`, but the treatment is typical-path")),
    ("a followed stochastic film",
     "sweep: {T: [200, 210]}\nfollow: T\nnoise: {treatment: stochastic}\n",
     refused(2, "does not go together with `noise: {treatment: stochastic}`")),
    ("a seed of 2^200", f"noise:\n  treatment: stochastic\n  seed: {2**200}\n",
     refused(3, "at most")),
    ("a seed of nothing", "noise: {seed: 1}\n", refused(1, "treatment: stochastic")),
    ("an unknown figure", "plot: {figure: amplitude}\n", refused(1, "'amplitudes'?")),
]  # fmt: skip

SWEEPS: list[tuple[str, str | bytes, Outcome]] = [
    ("k and K exchanged", "model:\n  k: 3000\n  K: 5e4\n",
     warned(3, "as if k and K were exchanged")),
    ("a soft spring alone", "model: {k: 3000}\n", valid),
    ("fixed and swept", "model: {T: 200}\nsweep:\n  T: [1]\n", refused(3, "second time")),
    ("fixed by name, swept by symbol", "sweep: {T: [1]}\nmodel: {temperature: 200}\n",
     refused(1, "gives temperature a second time")),
    ("by symbol and by name", "model:\n  T: 1\n  temperature: 1\n", refused(3, "line 2")),
    ("swept and linked", "sweep: {T: [1]}\ncases: {T: [1]}\n", refused(2, "second time")),
    ("an empty axis", "sweep:\n  T: []\n", refused(2, "has no values")),
    ("an axis of nothing", "sweep:\n  T:\n", refused(2, "must be a list")),
    ("an axis of one number", "sweep: {T: 200}\n", refused(1, "must be a list")),
    ("values twice", "sweep: {T: [200, 250, 200]}\n", refused(1, "more than once: 200.0")),
    ("0 and -0", "sweep: {x_0: [0, -0.0]}\n", refused(1, "more than once")),
    ("values almost twice", "sweep:\n  T: [200, 200.0000000001]\n",
     warned(2, "200.0 and 200.0000000001")),
    ("linspace between equals", "sweep: {T: {linspace: [1, 1], num: 3}}", refused(1, "once")),
    ("num of 0", "sweep:\n  T:\n    linspace: [1, 2]\n    num: 0\n", refused(4, "at least 1")),
    ("num of 1", "sweep: {T: {linspace: [1, 2], num: 1}}\n", valid),
    ("num of 2.5", "sweep: {T: {linspace: [1, 2], num: 2.5}}\n", refused(1, "whole number")),
    (
        "num missing",
        "sweep: {T: {linspace: [1, 2]}}\n",
        refused(1, "num: is missing; write {linspace:"),
    ),
    ("num of 1e12", "sweep: {T: {linspace: [1, 2], num: 1e12}}\n", refused(1, "at most 1000000")),
    (
        "num of 2^200",
        f"sweep: {{T: {{linspace: [1, 2], num: {2**200}}}}}",
        refused(1, "at most 1000000"),
    ),
    (
        "1e12 points",
        "sweep:\n  T: {linspace: [1, 2], num: 1e6}\n  k: {linspace: [1, 2], num: 1e6}\n",
        refused(1, "1000000000000 points"),
    ),
    ("1e12 points with cases",
     "sweep: {T: {linspace: [1, 2], num: 1e6}}\ncases: {k: {linspace: [1, 2], num: 1e6}}\n",
     refused(1, "1000000000000 points")),
    ("a log axis with 0", "sweep: {k: {geomspace: [0, 1], num: 3}}\n", refused(1, "same sign")),
    ("a log axis across 0", "sweep: {x_0: {geomspace: [-1, 1], num: 3}}", refused(1, "sign")),
    ("a log axis below 0", "sweep: {x_0: {geomspace: [-2, -1], num: 3}}\n", valid),
    ("three ends", "sweep: {T: {linspace: [1, 2, 3], num: 3}}\n", refused(1, "not 3")),
    ("a word as an end", "sweep: {T: {linspace: [1, b], num: 3}}\n", refused(1, "not 'b'")),
    ("nan as an end", "sweep: {T: {linspace: [1, .nan], num: 3}}\n", refused(1, "linspace[1]")),
    ("ends far apart", "sweep: {x_0: {linspace: [-1e308, 1e308], num: 3}}\n", valid),
    ("an unknown form", "sweep: {T: {logspace: [1, 2], num: 3}}\n", refused(1, "'linspace'?")),
    ("two forms", "sweep: {T: {linspace: [1, 2], geomspace: [1, 2]}}", refused(1, "must be")),
    ("a key too many", "sweep: {T: {arange: [1, 2, 1], num: 2}}\n", refused(1, "unknown key")),
    ("a step of 0", "sweep: {T: {arange: [1, 2, 0]}}\n", refused(1, "no steps")),
    ("a step backwards", "sweep: {T: {arange: [1, 2, -1]}}\n", refused(1, "no steps")),
    ("a tiny step", "sweep: {T: {arange: [1, 2, 1e-300]}}\n", refused(1, "take fewer")),
    ("lists in lists", "sweep: {T: [[1, 2], [3]]}\n", refused(1, "not a list")),
    ("cases of unequal length", "cases:\n  X_m: [4e-7, 8e-7]\n  omega: [20]\n",
     refused(1, "drive_amplitude 2, angular_frequency 1")),
    ("a case twice", "cases:\n  T: [1, 2, 1]\n", refused(1, "case 2 repeats case 0")),
    ("a value twice in cases", "cases: {T: [1, 1], k: [1e4, 2e4]}\n", valid),
    ("a case that is no list", "cases: {T: 200}\n", refused(1, "must be a list")),
    ("a bad value on an axis", "sweep:\n  T:\n    - 200\n    - -5\n", refused(4, "not -5.0")),
    ("bad values in a form", "sweep: {T: {linspace: [-10, 10], num: 21}}\n",
     refused(1, "not -10.0 (and 9 more")),
    ("phi_0 = 0 and no noise", "noise:\n  treatment: none\n", refused(2, "could never solidify")),
    ("phi_0 = 0 somewhere and no noise", "sweep:\n  phi_0: [0, 0.1]\nnoise: {treatment: none}\n",
     refused(2, "could never solidify")),
    ("phi_0 = 0 and D = 0", "model:\n  D: 0\n", refused(2, "could never solidify")),
    ("phi_0 = 0 meets D = 0 in the product", "sweep: {D: [0, 1e-18], phi_0: [0, 0.1]}\n",
     refused(1, "could never solidify")),
    ("phi_0 = 0 misses D = 0 in the cases", "cases: {D: [0, 1e-18], phi_0: [0.1, 0]}\n", valid),
    ("phi_0 = 0 meets D = 0 in the cases", "cases: {D: [0, 1e-18], phi_0: [0, 0.1]}\n",
     refused(1, "could never solidify")),
    ("a quintic term somewhere without a sextic one", "sweep:\n  d: [0, 1]\n  e: [0, 1]\n",
     refused(2, "would grow without bound")),
    ("quintic terms with sextic ones", "cases: {d: [0, 1], e: [0, 1]}\n", valid),
    ("a strain that relaxes by a method that does not know it",
     "integrator: {method: euler-cromer, dt: 1e-8}\nfilm:\n  strain: relaxing\n",
     refused(3, "relaxing needs `integrator: {method: adaptive}`")),
    ("a strain that relaxes", "film: {strain: relaxing}\n", valid),
    ("no noise, solid start", "model: {phi_0: 0.6}\nnoise: {treatment: none}\n", valid),
]  # fmt: skip

POSITIVE = ("omega", "M", "h", "tau", "A", "delta")
NOT_NEGATIVE = ("T", "k", "K", "T_c", "a", "alpha", "b", "e")


def bounds() -> list[tuple[str, str | bytes, Outcome]]:
    """Each bound of each parameter, from both sides."""
    table: list[tuple[str, str | bytes, Outcome]] = []
    for symbol in (*POSITIVE, *NOT_NEGATIVE):
        part = "must be greater than 0" if symbol in POSITIVE else "must be at least 0"
        table += [
            (
                f"{symbol} of 0",
                f"model: {{{symbol}: 0}}\n",
                refused(1, part) if symbol in POSITIVE else valid,
            ),
            (f"{symbol} of 5e-324", f"model: {{{symbol}: 5e-324}}\n", valid),
            (f"{symbol} below 0", f"model: {{{symbol}: -5e-324}}\n", refused(1, part)),
        ]
    for text, outcome in {
        "gamma: -1": refused(1, "greater than -1"),
        "gamma: -0.9999999999999999": valid,
        "phi_0: 2": valid,
        "phi_0: 2.0000000000000005": refused(1, "at most 2"),
        "phi_0: -1e-300": refused(1, "at least 0"),
        "D: -1e-300": refused(1, "at least 0"),
        "D: 5e-324": valid,
        "X_m: 0": refused(1, "must not be 0"),
        "X_m: -0.8e-6": valid,
        "c: 0": refused(1, "c) = 0 needs a sextic_coefficient (e) > 0: the order parameter would"),
        "c: -5e-324": refused(1, "at least 0"),
        "d: 1": refused(1, "d) > 0 needs a sextic_coefficient (e) > 0"),
        "d: -5e-324": refused(1, "at least 0"),
        "d: 1, e: 1": valid,
        "c: 0, e: 1": valid,
        "x_0: -1": valid,
        "v_0: -1": valid,
    }.items():
        table.append((text, f"model: {{{text}}}\n", outcome))
    return table


ALL = [*SYNTAX, *SEMANTICS, *SCHEMA, *SWEEPS, *bounds()]
