"""The site that `make docs` builds: the pages of the repository, and what is made for them.

The source folder of Sphinx is the root of the repository, so that a link between two pages leads to
the same file here and on a site that shows the repository.
"""

from __future__ import annotations

import os
import sys
from importlib import metadata
from pathlib import Path

from sphinx.application import Sphinx

_DOCS = Path(__file__).parent
sys.path.insert(0, str(_DOCS))

from contents import LISTINGS, with_contents  # noqa: E402 - needs the path set above
from gallery import with_configs, with_thumbnails  # noqa: E402
from made_tables import with_made_tables  # noqa: E402
from source_hash import PACKAGES, source_hash  # noqa: E402

project = "stickslip"
author = copyright = "The stickslip developers"  # noqa: A001 - Sphinx reads this name
release = version = metadata.version("stickslip")

root_doc = "docs/README"
include_patterns = [
    "*.md",
    "docs/*.md",
    "docs/decisions/*.md",
    "docs/how-to/*.md",
    "benchmarks/README.md",
]
exclude_patterns = [".*", "build", "dist", "results", "**/_build"]
extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
    "sphinx_copybutton",
    "sphinx_design",
    "formulas",
]

myst_enable_extensions = ["colon_fence", "dollarmath"]
myst_fence_as_directive = ["math"]  # as the sites that show repositories do
myst_heading_anchors = 6

# The output of a notebook depends only on the sources; each is executed once per state of them.
os.environ["JUPYTER_PATH"] = str(_DOCS)  # this interpreter, whatever kernels a home folder names
nb_execution_mode = "cache"
nb_execution_cache_path = str(_DOCS / "_build" / "notebooks" / source_hash(*PACKAGES)[:12])
nb_execution_timeout = 900  # seconds; the first run compiles
nb_execution_raise_on_error = True
nb_merge_streams = True
nb_output_stderr = "remove"  # that kernels are compiled

default_role = "code"  # docstrings put code in single backticks
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented_params"
autodoc_member_order = "bysource"
napoleon_google_docstring = False
# Types of other packages, whose inventories are on the network; names without their module, as
# docstrings have them and hints that only type checkers read.
nitpick_ignore_regex = [
    (r"py:.*", r"(xarray|xr|numpy|np|pathlib|collections|typing|sweeps|stickslip)\..*"),
    (r"py:(class|exc)", r"\w+"),
]

html_theme = "furo"
html_title = f"stickslip {release}"
html_math_renderer = "drawn"
html_static_path = ["style/site.css"]
html_css_files = ["site.css"]
html_extra_path = ["style/index.html"]  # redirects to the root page, which is in docs/


def _made(_app: Sphinx, name: str, source: list[str]) -> None:
    """Fill the generated parts of a page: menu, tables from declarations, configs, thumbnails."""
    if name in LISTINGS:
        source[0] = with_contents(source[0])
    source[0] = with_thumbnails(with_configs(with_made_tables(source[0])))


def setup(app: Sphinx) -> None:
    """Called by Sphinx."""
    app.connect("source-read", _made)
