"""The page in a notebook: a cell shows it, and it ends with the kernel."""

from __future__ import annotations

import re
import urllib.error
import urllib.request
from typing import Any

import pytest

pytest.importorskip("bokeh", reason="bokeh is not installed")
nbclient = pytest.importorskip("nbclient", reason="nbclient is not installed")
nbformat = pytest.importorskip("nbformat", reason="nbformat is not installed")

pytestmark = pytest.mark.slow  # a kernel starts

CODE = """\
import sweeps
from stickslip import Parameters
sweeps.explore(Parameters(temperature=250))
"""


def status(address: str) -> int:
    with urllib.request.urlopen(address, timeout=60) as page:
        policy = page.headers["Content-Security-Policy"]
        assert "frame-ancestors 'self' http://127.0.0.1:* http://localhost:*" in policy
        assert page.headers["Referrer-Policy"] == "no-referrer"
        return int(page.status)


def shown(notebook: Any) -> str:
    (output,) = notebook.cells[0].outputs
    return str(output["data"]["text/html"])


def test_a_cell_shows_the_page_which_ends_with_the_kernel():
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(CODE)])
    client = nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3")
    with client.setup_kernel():
        client.execute_cell(notebook.cells[0], 0)
        (address,) = re.findall(
            r'<iframe src="(http://127\.0\.0\.1:\d+/\?token=[^"]+)"', shown(notebook)
        )
        assert status(address) == 200
    with pytest.raises(urllib.error.URLError):
        urllib.request.urlopen(address, timeout=60)
    words = re.sub("<[^>]+>", "", shown(notebook))
    assert "The page is served by the kernel of this notebook" in words
    assert "ssh -L" in words
