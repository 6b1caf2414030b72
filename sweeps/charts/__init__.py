"""Charts: what is to be drawn of a Dataset, and nothing of how.

From a Dataset and a choice (variable, axes, slice, scale) to cells, curves or points, with the
roles of dimensions, labels and shown units, colours of kinds, jumps and missing points. Painters
draw them: `sweeps.figures` with matplotlib, the pages in a browser.
"""
