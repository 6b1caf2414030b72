"""BokehJS, to stand inside a page."""

from __future__ import annotations

from bokeh.resources import Resources


def library(*components: str) -> str:
    """Return the parts of BokehJS that are named, as one script.

    It tells the console of what goes wrong alone: Bokeh tells it of each of its steps too, and
    of the level of its log.
    """
    script = "\n".join(Resources(mode="inline", components=list(components)).js_raw)
    script = script.replace('Bokeh.set_log_level("info");', 'Bokeh.logger.set_level("warn");')
    return script.replace('console.log("Bokeh items were rendered successfully")', "0")
