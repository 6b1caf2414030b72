"""Charts of a result, and of an orbit, as Bokeh figures: what is drawn, and how it looks.

The page of `explore` draws them anew for each choice; a report has them once, and fills them in the
browser.
"""

from __future__ import annotations

import importlib.util


def bokeh_is_missing() -> str:
    """Return what to do where bokeh, which draws the charts, is not installed; else nothing."""
    if importlib.util.find_spec("bokeh") is not None:
        return ""
    return "bokeh is not installed; try: pip install 'bokeh>=3.9'"
