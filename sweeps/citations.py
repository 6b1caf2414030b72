"""BibTeX entries for a result: the program, the paper, and the methods that made the file."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from importlib import metadata
from typing import Any

PAPER = """\
@article{lyashenko2013stick,
  author  = {Lyashenko, I. A. and Zaskoka, A. M.},
  title   = {Stick-slip mode of boundary friction as the first-order phase transition},
  journal = {Ukrainian Journal of Physics},
  volume  = {58},
  pages   = {91},
  year    = {2013},
  note    = {arXiv:1302.0720},
}"""

_PROGRAM = """\
@software{{stickslip,
  author  = {{{{The stickslip developers}}}},
  title   = {{stickslip: stick-slip of boundary friction as a first-order phase transition}},
  version = {{{version}}},
  note    = {{{note}}},
}}"""

METHODS: Mapping[str, str] = {
    "adaptive": """\
@incollection{steinebach2020improvement,
  author    = {Steinebach, G.},
  title     = {Improvement of {Rosenbrock--Wanner} method {RODASP}},
  booktitle = {Progress in Differential-Algebraic Equations II},
  editor    = {Reis, T. and Grundel, S. and Sch{\\"o}ps, S.},
  publisher = {Springer},
  pages     = {165--184},
  year      = {2020},
}""",
    "euler-cromer": """\
@article{cromer1981stable,
  author  = {Cromer, A.},
  title   = {Stable solutions using the {Euler} approximation},
  journal = {American Journal of Physics},
  volume  = {49},
  pages   = {455--459},
  year    = {1981},
}""",
    "stochastic": """\
@book{kloeden1992numerical,
  author    = {Kloeden, P. E. and Platen, E.},
  title     = {Numerical Solution of Stochastic Differential Equations},
  publisher = {Springer},
  year      = {1992},
}""",
    "indices": """\
@article{saltelli2010variance,
  author  = {Saltelli, A. and Annoni, P. and Azzini, I. and Campolongo, F. and Ratto, M. and
             Tarantola, S.},
  title   = {Variance based sensitivity analysis of model output},
  journal = {Computer Physics Communications},
  volume  = {181},
  pages   = {259--270},
  year    = {2010},
}""",
    "fit": """\
@article{storn1997differential,
  author  = {Storn, R. and Price, K.},
  title   = {Differential evolution},
  journal = {Journal of Global Optimization},
  volume  = {11},
  pages   = {341--359},
  year    = {1997},
}""",
    "posterior": """\
@article{foremanmackey2013emcee,
  author  = {Foreman-Mackey, D. and Hogg, D. W. and Lang, D. and Goodman, J.},
  title   = {emcee: The {MCMC} Hammer},
  journal = {Publications of the Astronomical Society of the Pacific},
  volume  = {125},
  pages   = {306--312},
  year    = {2013},
}

@article{terbraak2006markov,
  author  = {ter Braak, C. J. F.},
  title   = {A {Markov} Chain {Monte} {Carlo} version of the genetic algorithm {Differential}
             {Evolution}: easy {Bayesian} computing for real parameter spaces},
  journal = {Statistics and Computing},
  volume  = {16},
  pages   = {239--249},
  year    = {2006},
}

@article{terbraak2008differential,
  author  = {ter Braak, C. J. F. and Vrugt, J. A.},
  title   = {Differential Evolution {Markov} Chain with snooker updater and fewer chains},
  journal = {Statistics and Computing},
  volume  = {18},
  pages   = {435--446},
  year    = {2008},
}""",
}
"""The source of each method; docs/numerics.md describes its use."""

# A line of a config as in files, where texts are quoted, or as people write it.
_STOCHASTIC = re.compile(r"""^ +treatment: ["']?stochastic["']?$""", re.MULTILINE)


def bibtex(attributes: Mapping[str, Any] | None = None, kind: str = "sweep") -> str:
    """Return the entries of the program and the paper, and of the methods that made a file.

    `attributes` are the attributes of the file; `kind` is the kind of its data, as returned by
    `sweeps.charts.choice.data_of`.
    """
    attributes = attributes or {}
    return "\n\n".join([_program(attributes), PAPER, *_methods(attributes, kind)])


def _program(attributes: Mapping[str, Any]) -> str:
    """Return the entry of the program, in the version that wrote a file or else in this one."""
    source = str(attributes.get("source", ""))  # `stickslip 1.0.0, method adaptive`
    written = source.partition(",")[0].removeprefix("stickslip ")
    version = written or metadata.version("stickslip")
    digest = attributes.get("code_sha256")
    note = f"sources with SHA-256 {digest}" if digest else "computes the model of the paper below"
    return _PROGRAM.format(version=version, note=note)


def _methods(attributes: Mapping[str, Any], kind: str) -> Iterator[str]:
    source, config = str(attributes.get("source", "")), str(attributes.get("config", ""))
    if kind == "phases":  # nothing was integrated
        return
    for name in ("adaptive", "euler-cromer"):
        if source.endswith(f"method {name}"):
            yield METHODS[name]
    if _STOCHASTIC.search(config):
        yield METHODS["stochastic"]
    if kind in METHODS:
        yield METHODS[kind]
    if "posterior_steps" in attributes:  # a fit with draws
        yield METHODS["posterior"]
