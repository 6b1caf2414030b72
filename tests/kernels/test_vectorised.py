"""No kernel is compiled with a complaint of LLVM that it could not vectorise a loop over lanes.

The numbers of such a kernel are right, and nothing but time shows that it is slow.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

COMPILE = """
import sys
import numpy as np
from stickslip.kernels.families import KIND
from stickslip.options import Options
from stickslip.orbit import prepare_kernels
method, index = sys.argv[1:]
options = Options(method=method, dt=2e-5) if method == "euler-cromer" else Options()
prepare_kernels(options, np.array([[float(index), *[0.0] * (len(KIND) - 1)]]))
print("compiled")
"""


@pytest.mark.stress
@pytest.mark.parametrize(
    ("method", "index"),
    [("euler-cromer", "0"), ("euler-cromer", "-0.5"), ("adaptive", "0"), ("adaptive", "-0.5")],
)
def test_a_kernel_is_compiled_without_complaint(method: str, index: str, tmp_path: Path) -> None:
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    done = subprocess.run(
        [sys.executable, "-c", COMPILE, method, index],
        env=environment,
        capture_output=True,
        text=True,
        timeout=1800,
        check=False,
    )
    assert done.stdout == "compiled\n", done.stderr
    assert "not vectorized" not in done.stderr
