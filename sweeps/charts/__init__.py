"""Charts: what to draw of a Dataset, but not how to draw it.

A Dataset and a choice (variable, axes, slice, scale) become cells, curves or points. The modules
find the roles of dimensions, labels and shown units, colours, jumps and missing points.
`sweeps.figures` draws the charts with matplotlib, and the pages draw them in a browser.
"""
