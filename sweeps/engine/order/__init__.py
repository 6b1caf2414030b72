"""In which order the points of a sweep are computed: one module for each order."""
