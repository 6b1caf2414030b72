"""The documentation agrees with the code: symbols, units, defaults, numbers, names, links."""

import importlib
import math
import re
import runpy
import tomllib
from collections.abc import Callable, Iterator
from functools import reduce
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from ruamel.yaml import YAML

from stickslip.model import film, noise, solids
from stickslip.model.laws.power_law import viscous_stress
from stickslip.parameters import Parameters
from stickslip.variables import RESULTS, TRAJECTORY

ROOT = Path(__file__).parents[2]
WRITTEN = (path for path in ROOT.glob("docs/**/*.md") if "_build" not in path.parts)
PAGES = sorted([*ROOT.glob("*.md"), *WRITTEN, *ROOT.glob("benchmarks/*.md")])
LINK = re.compile(r"\]\(([^)\s]+)\)")
EQUATIONS = (ROOT / "docs" / "equations.md").read_text(encoding="utf-8")


def table(heading: str) -> list[list[str]]:
    """The rows below a header row that starts like `heading`; cells are stripped, `\\|` is `|`."""
    lines = iter(EQUATIONS.splitlines())
    next(line for line in lines if line.startswith(heading))
    next(lines)  # the dashes
    return [
        [cell.strip().replace("\\|", "|") for cell in re.split(r"(?<!\\)\|", line)[1:-1]]
        for line in _until_blank(lines)
    ]


def _until_blank(lines: Iterator[str]) -> Iterator[str]:
    for line in lines:
        if not line:
            return
        yield line


def test_trajectory_table_is_the_registry():
    declared = [[f"${v.tex}$", f"`{v.name}`", v.units, v.meaning] for v in TRAJECTORY.values()]
    assert table("| symbol | name | unit | meaning |") == declared


def test_result_table_is_the_registry():
    declared = [[f"`{v.name}`", v.units, v.meaning] for v in RESULTS.values()]
    assert table("| name | unit | meaning |") == declared


def test_every_equation_of_the_paper_is_there_once_and_in_order():
    assert [int(tag) for tag in re.findall(r"\\tag\{(\d+)\}", EQUATIONS)] == list(range(1, 27))


@pytest.mark.stress
def test_closed_forms_of_the_model_have_the_documented_values():
    p = Parameters()
    melting = solids.melting_strain(p)
    slip = p.film_thickness / p.strain_relaxation_time  # relative velocity for a strain of one
    strains = np.linspace(0.0, melting * (1 - 1e-12), 20_001).tolist()
    phi = [solids.solid_order_parameter(p, film.melting_function(p, eps)) for eps in strains]
    elastic = [film.elastic_stress(p, y, eps) for y, eps in zip(phi, strains, strict=True)]
    viscous = [viscous_stress(p, slip * eps, 0.0) for eps in strains]
    drive = p.drive_amplitude * p.angular_frequency
    computed = [
        solids.coexistence_limit(p),
        solids.melting_temperature(p, 0.0),
        solids.solidification_temperature(p, 0.0),
        solids.largest_order_parameter(p),
        melting,
        solids.solidification_strain(p),
        slip * melting,
        max(elastic),
        p.contact_area * np.max(np.add(elastic, viscous)),
        (2 * p.spring_stiffness - p.block_mass * p.angular_frequency**2) * p.drive_amplitude,
        math.sqrt(2 * p.spring_stiffness / p.block_mass),
        p.contact_area * viscous_stress(p, drive, 0.0),
    ]
    documented = [row[2].split()[0] for row in table("| quantity | formula | value |")]
    assert [
        _rounded_like(value, text) for value, text in zip(computed, documented, strict=True)
    ] == [float(text) for text in documented]


def _rounded_like(value: float, text: str) -> float:
    digits = re.sub(r"e.*", "", text).replace(".", "").lstrip("0")
    return float(f"{value:.{len(digits) - 1}e}")


def test_noise_factor_has_the_documented_value():
    (documented,) = re.findall(r"= (0\.\d+)\\,D", EQUATIONS)
    assert float(documented) == round(noise.TYPICAL_FRACTION, 7)


def test_citation_has_the_version_of_the_package():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert f"\nversion: {project['version']}\n" in (ROOT / "CITATION.cff").read_text("utf-8")


# --- names and links ---


@pytest.fixture
def scripts(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], Any]:
    """Scripts outside the packages, imported by the path of their file."""

    def script(path: str) -> Any:
        monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
        return runpy.run_path(str(ROOT / path))

    return script


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_somewhere(page: Path):
    for link in LINK.findall(page.read_text("utf-8")):
        if not link.startswith(("http:", "https:")):
            name, _, heading = link.partition("#")
            target = (page.parent / name).resolve() if name else page
            assert target.exists() or left_out(target), link
            assert not heading or heading in headings(target), link


def left_out(target: Path) -> bool:
    """Whether the target is a picture, and this a source distribution, which has none."""
    return target.suffix in {".png", ".gif"} and not (ROOT / ".git").exists()


def headings(page: Path) -> set[str]:
    """The headings of a page, as the anchors by which links name them."""
    lines = re.findall(r"^#+ (.*)$", page.read_text("utf-8"), flags=re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", line.lower()).replace(" ", "-") for line in lines}


@pytest.mark.parametrize(
    "page",
    [*(page for page in PAGES if page.name != "CHANGELOG.md"), ROOT / "pyproject.toml"],
    ids=lambda page: str(page.relative_to(ROOT)),
)
def test_files_and_modules_named_in_pages_exist(page: Path):
    text = page.read_text("utf-8")
    known = {path.name for path in ROOT.glob("benchmarks/*.py")}
    missing = [name for name in named_paths(text) if not (ROOT / name).exists()]
    missing += [name for name in re.findall(r"\bbench_\w+\.py", text) if name not in known]
    missing += [name for name in named_modules(text) if not importable(name)]
    assert not missing


def named_paths(text: str) -> list[str]:
    """Files and folders of the repository that a text names from its root."""
    tops = "stickslip|sweeps|tests|docs|benchmarks|configs"
    found = re.findall(rf"(?<![\w/.-])((?:{tops})/[\w./-]*\w/?)", text)
    return [name for name in found if name.endswith("/") or "." in name.rsplit("/", 1)[1]]


def named_modules(text: str) -> list[str]:
    """Dotted names below the packages."""
    found = re.findall(r"(?<![\w/.])((?:stickslip|sweeps)(?:\.[a-z_]\w*)+)(?![\w/*(]|\.\w)", text)
    return [name for name in found if not name.endswith((".md", ".json"))]


def importable(name: str) -> bool:
    """Whether a dotted name is a module, or something in one."""
    for split in range(name.count(".") + 1):
        module, *rest = name.rsplit(".", split) if split else [name]
        try:
            found: Any = importlib.import_module(module)
        except ImportError:
            continue
        try:
            return bool(reduce(getattr, rest, found))
        except AttributeError:
            return False
    return False


def test_modules_named_in_the_picture_exist(scripts: Callable[[str], Any]):
    drawing = scripts("docs/data_flow.py")
    for stage in drawing["STAGES"]:
        for module, _ in stage.steps:
            assert (ROOT / module).exists(), module
    assert drawing["PICTURE"].read_text("utf-8") == drawing["picture"]()


# --- measured numbers ---


def test_numbers_of_the_readme_stand_on_the_pages_of_measurements():
    readme = (ROOT / "README.md").read_text("utf-8")
    section = readme.split("## What has been tested")[1].split("\n## ")[0]
    items = section.split("\n\n")[1].split("\n* ")
    assert sum(len(measured_numbers(item)) for item in items) >= 8
    for item in items:
        pages = set(re.findall(r"\((docs/[\w-]+\.md)", item))
        text = "".join((ROOT / page).read_text("utf-8") for page in pages)
        assert measured_numbers(LINK.sub("]", item)) <= measured_numbers(text), item


def test_sizes_in_the_questions_are_those_measured():
    questions = (ROOT / "docs" / "faq.md").read_text("utf-8").split("\n\n")
    (answer,) = [text for text in questions if "[measured](performance.md" in text]
    sizes = set(re.findall(r"[\d.]+ MiB", answer))
    assert len(sizes) >= 2
    assert sizes <= set(re.findall(r"[\d.]+ MiB", (ROOT / "docs" / "performance.md").read_text()))


def measured_numbers(text: str) -> set[str]:
    return set(re.findall(r"(?<![\w.])\d[\d.e%-]*(?<![.-])", text))


def test_tables_of_measurements_are_those_of_the_records(scripts: Callable[[str], Any]):
    tables = scripts("benchmarks/pages/tables.py")
    for page in tables["PAGES"]:
        text = page.read_text("utf-8")
        assert "<!-- table: " in text
        assert text == tables["filled"](text), "run make tables"


BENCHMARKS = sorted((ROOT / "benchmarks").glob("bench_*.py"))


@pytest.mark.parametrize("path", BENCHMARKS, ids=lambda path: path.stem)
def test_a_benchmark_is_one_of_the_family(path: Path, scripts: Callable[[str], Any]):
    text, readme = path.read_text("utf-8"), (ROOT / "benchmarks" / "README.md").read_text("utf-8")
    name = path.stem.removeprefix("bench_")
    # Takes --quick and --full, and keeps quick runs away from the records.
    assert f'measure("{name}", __doc__, ' in text
    assert callable(scripts(str(path.relative_to(ROOT)))["measure"])  # all that it imports is there
    tables = scripts("benchmarks/pages/tables.py")["TABLES"].values()
    assert name in {table.script for table in tables}, "what it measures is shown"
    assert f"| `{path.name}` |" in readme
    assert len(text.splitlines()) <= 300


# What in the scripts shows that they need an extra.
SIGNS = {
    "dask": "distributed.cli", "explore": '"explore"', "report": '"report"',
    "fit": "from sweeps import fit", "posterior": "--posterior", "table": ".parquet",
}  # fmt: skip


def test_benchmarks_are_installed_with_the_extras_that_they_need():
    scripts = (ROOT / "benchmarks").rglob("*.py")
    text = "\n".join(path.read_text("utf-8") for path in scripts)
    rule = (ROOT / "Makefile").read_text("utf-8").split("$(VENV)/.bench: ")[1].split("\n\n")[0]
    installed = re.search(r'--editable "\.\[(.*)\]"', rule)
    assert installed is not None
    assert {*installed[1].split(",")} == {extra for extra, sign in SIGNS.items() if sign in text}


@pytest.mark.parametrize("path", sorted((ROOT / ".github" / "workflows").glob("*.yml")))
def test_a_job_that_may_publish_runs_nothing_but_that(path: Path):
    """What a build installs could use the token of its job to publish something else."""
    jobs = YAML(typ="safe").load(path)["jobs"].values()
    for job in jobs:
        if job.get("permissions", {}).get("id-token") == "write":
            assert job["needs"]
            for step in job["steps"]:
                assert "run" not in step
                assert not re.match("actions/(checkout|setup-)", step["uses"])
