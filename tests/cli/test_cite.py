"""`stickslip cite`: BibTeX entries of the program, the paper and the methods of a file."""

from __future__ import annotations

import re
from importlib import metadata
from pathlib import Path

import pytest
from support.sweeps.commands import Command

from sweeps import run
from sweeps.citations import METHODS, bibtex
from sweeps.config.load import from_mapping
from sweeps.files.netcdf import write_checked

STOCHASTIC = from_mapping({"noise": {"treatment": "stochastic"}})


def keys(entries: str) -> list[str]:
    return re.findall(r"^@\w+\{([\w-]+),$", entries, re.MULTILINE)


def test_without_a_file_the_program_and_the_paper_are_cited(command: Command) -> None:
    done = command.ok("cite")
    assert keys(done.out) == ["stickslip", "lyashenko2013stick"]
    assert f"version = {{{metadata.version('stickslip')}}}" in done.out


def test_a_file_cites_its_method_and_the_sources_that_wrote_it(command: Command) -> None:
    ds = run({"sweep": {"T": [290, 300]}, "integrator": {"rtol": 1e-4}})
    ds.attrs["source"] = ds.attrs["source"].replace(metadata.version("stickslip"), "0.9.1")
    write_checked(ds, Path("a.nc"))
    done = command("cite", "a.nc")
    assert keys(done.out) == ["stickslip", "lyashenko2013stick", "steinebach2020improvement"]
    assert "version = {0.9.1}" in done.out
    assert ds.attrs["code_sha256"] in done.out
    missing = command("cite", "b.nc")
    assert missing.code == 5
    assert "b.nc" in missing.err


@pytest.mark.parametrize(
    ("source", "config", "kind", "method"),
    [
        ("method euler-cromer", "", "sweep", "cromer1981stable"),
        ("method adaptive", STOCHASTIC.resolved_yaml(), "sweep", "kloeden1992numerical"),
        ("method adaptive", "", "indices", "saltelli2010variance"),
        ("method adaptive", "", "fit", "storn1997differential"),
    ],
)
def test_each_method_has_its_source(source: str, config: str, kind: str, method: str) -> None:
    entries = bibtex({"source": f"stickslip 1.0.0, {source}", "config": config}, kind)
    assert keys(entries)[-1] == method
    assert keys(bibtex({"source": f"stickslip 1.0.0, {source}"}, "phases")) == keys(bibtex())


def test_a_posterior_cites_its_sampler_and_its_moves() -> None:
    fitted = {"source": "stickslip 1.0.0, method adaptive"}
    entries = bibtex(fitted | {"posterior_steps": 600}, "fit")
    added = ["foremanmackey2013emcee", "terbraak2006markov", "terbraak2008differential"]
    assert keys(entries) == [*keys(bibtex(fitted, "fit")), *added]


def test_a_title_is_no_method() -> None:
    titled = from_mapping({"title": "treatment: stochastic, or not?"}).resolved_yaml()
    assert keys(bibtex({"config": titled})) == keys(bibtex())


def test_entries_are_complete() -> None:
    for entry in METHODS.values():
        assert entry.count("{") == entry.count("}")
        for field in ("author", "title", "year"):
            assert re.search(rf"^  {field} +=", entry, re.MULTILINE), entry
