// Where a curve jumps: sweeps/figures/jumps.py, for curves that are chosen in the page.

const KINDS_OF_MOTION = ["regime", "orbit_periods", "melting_count"];
const MARKED = 4.0; // times the steepest slope beside it: less is a bend
const VISIBLE = 0.02; // of the range of the curve: less is no gap on a screen

// True for each interval of a curve over which the value jumps; `along` are its places across, on
// the axis's own scale, `heights` its values as drawn.
function jumpsOf(points, along, heights) {
  const largest = heights.reduce((most, height) => (Math.abs(height) > most ? Math.abs(height) : most), 0);
  const intervals = heights.slice(1).map((height, at) => ({
    changes: changesAfter(points, at),
    step: along[at + 1] - along[at],
    rise: Math.abs(height - heights[at]),
  }));
  const slopes = intervals.map(({ changes, step, rise }) => (changes || step === 0 ? NaN : rise / step));
  return intervals.map(({ changes, step, rise }, at) => {
    const explained = MARKED * steepestBeside(slopes, at) * step;
    return changes && rise > explained && rise > VISIBLE * largest;
  });
}

function changesAfter(points, at) {
  return KINDS_OF_MOTION.map(variableCalled).some((variable) => {
    if (!variable) return false;
    const values = valuesOf(variable);
    const [before, after] = [values[points[at]], values[points[at + 1]]];
    return before !== after && !Number.isNaN(before + after);
  });
}

// Of the two intervals on each side; NaN where none of them counts.
function steepestBeside(slopes, at) {
  const beside = [at - 2, at - 1, at + 1, at + 2].map((other) => slopes[other] ?? NaN);
  const known = beside.filter((slope) => !Number.isNaN(slope));
  return known.length ? Math.max(...known) : NaN;
}
