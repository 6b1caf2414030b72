"""A local page on which every parameter is a slider, and the orbit follows."""
