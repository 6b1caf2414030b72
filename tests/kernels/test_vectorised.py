"""LLVM never complains that it could not vectorise a loop over lanes.

The numbers of such a kernel are right, and only the time shows that it is slow.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from support.package import run_python

from stickslip.options import METHODS

COMPILE = """
import numpy as np
from stickslip.kernels.families import KIND
from stickslip.options import Options
from stickslip.orbit import prepare_kernels
kinds = np.zeros((1, len(KIND)))
kinds[0, 0] = {index}
prepare_kernels(Options(method={method!r}), kinds)
"""


@pytest.mark.stress
@pytest.mark.parametrize("index", [0.0, -0.5, -2 / 3])
@pytest.mark.parametrize("method", METHODS)
def test_compiling_prints_and_warns_nothing(method: str, index: float, tmp_path: Path) -> None:
    assert run_python(COMPILE.format(index=index, method=method), tmp_path) == ("", "")
