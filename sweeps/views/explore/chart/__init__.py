"""The chart of a result, on which points are chosen: what is drawn, how, and by which choice."""
