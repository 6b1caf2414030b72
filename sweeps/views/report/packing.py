"""Numbers and texts in a page: compact, and unable to be taken for HTML or scripts."""

from __future__ import annotations

import base64
import json
from typing import Any

import numpy as np
from numpy.typing import NDArray


def packed(values: NDArray[Any], dtype: str = "f4") -> dict[str, Any]:
    """Numbers as a script of the page unpacks them, in C order: base64 of little-endian `dtype`.

    Where all are the same, or NaN, the one number is kept, NaN as null.
    """
    flat = np.ravel(values).astype(f"<{dtype}")
    if flat.size and (np.isnan(flat).all() or (flat == flat[0]).all()):
        return {"size": flat.size, "all": None if np.isnan(flat[0]) else flat[0].item()}
    return {"dtype": dtype, "base64": base64.b64encode(flat.tobytes()).decode()}


def script_json(data: Any) -> str:
    """JSON inside of a script element: no `<` can end the element, or begin a comment."""
    text = json.dumps(data, separators=(",", ":"), allow_nan=False)
    return text.replace("<", "\\u003c")


def thinned(columns: NDArray[np.float64], tolerance: float = 1e-3, most: int = 6000) -> Any:
    """Samples (n,) of which straight lines between the chosen ones tell all columns (m, n).

    No column is missed by more than `tolerance` of its range, unless that takes more than about
    `most` samples. The first column, the time, is what lies across.
    """
    across, heights = columns[0], columns[1:]
    spans = np.ptp(heights, axis=1)
    heights = heights / np.where(spans > 0, spans, 1.0)[:, None]
    kept = np.union1d([0, across.size - 1], [heights.argmin(1), heights.argmax(1)])
    while kept.size < most:
        drawn = np.stack([np.interp(across, across[kept], height[kept]) for height in heights])
        missed = np.abs(heights - drawn).max(axis=0)
        worst = _worst_of_each_gap(missed, kept)
        worst = worst[missed[worst] > tolerance]
        if not worst.size:
            break
        kept = np.union1d(kept, worst)
    return kept


def _worst_of_each_gap(missed: NDArray[np.float64], kept: NDArray[np.int64]) -> Any:
    """Where the most is missed in each gap between kept samples that has samples inside."""
    begins = kept[:-1][np.diff(kept) > 1] + 1
    ends = kept[1:][np.diff(kept) > 1]
    return np.array(
        [begin + missed[begin:end].argmax() for begin, end in zip(begins, ends, strict=True)],
        dtype=np.int64,
    )
