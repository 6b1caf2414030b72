"""Charts of a result, and of an orbit, as Bokeh figures: what is drawn, and how it looks.

The page of `explore` draws them anew for each choice; a report has them once, and fills them in the
browser.
"""
