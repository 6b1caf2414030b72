// Curves: a variable along an axis, with gaps where it jumps; one for each value of another axis.

const FEW = 40; // points that are worth a dot each
const PARTED = 0.6; // of the distance of two kinds: how far apart the curves of one are

// Which of three figures a variable is drawn in: by its values, their logarithms, or its kinds.
function scaleOf(variable, log) {
  if (variable.named) return "kinds";
  return log && !isOfKinds(variable) ? "log" : "linear";
}

// The height of a value; kinds have a line each.
function heightsOf(variable, points) {
  const values = valuesOf(variable);
  if (!variable.named) return points.map((point) => values[point]);
  return points.map((point) => {
    const kind = variable.kinds.findIndex(({ code }) => code === values[point]);
    return kind < 0 ? NaN : kind;
  });
}

function heightRange(variable, scale) {
  if (variable.named) return [-0.5, variable.kinds.length - 0.5];
  const codes = variable.kinds.map(({ code }) => code);
  const range = codes.length ? [Math.min(0, ...codes), Math.max(1, ...codes)] : rangeOf(variable, scale === "log");
  return roomAround(range, scale === "log");
}

function setHeight(drawn, variable, scale) {
  setRange(drawn.model.y_range, heightRange(variable, scale));
  const axis = drawn.named("height");
  axis.axis_label = scale === "kinds" ? "" : variable.label;
  if (scale !== "kinds") return;
  axis.major_label_overrides = new Map(variable.kinds.map(({ name }, line) => [line, name]));
  axis.ticker.ticks = variable.kinds.map((_, line) => line);
}

// `shift` parts curves of kinds, which would lie on one another.
function fillCurve(drawn, number, axis, points, variable, scale, shift = 0) {
  const across = axis.places;
  const heights = heightsOf(variable, points).map((y) => (scale === "log" && y <= 0 ? NaN : y + shift));
  const along = axis.geometric ? across.map(Math.log) : across;
  const jumps = scale === "kinds" ? [] : jumpsOf(points, along, heights);
  fill(drawn, `line ${number}`, lineWithGaps(axis, heights, jumps, scale));
  fill(drawn, `dots ${number}`, dots(axis, heights, jumps, variable));
  fill(drawn, `jumps ${number}`, steps(axis, heights, jumps));
  const missing = across.filter((_, i) => Number.isNaN(heights[i]));
  const top = valueAt(heightRange(variable, scale), 0.97, scale === "log");
  fill(drawn, `crosses ${number}`, { x: missing, y: missing.map(() => top) });
}

// A gap is a NaN in the middle of a jump; nothing connects kinds.
function lineWithGaps(axis, heights, jumps, scale) {
  const [x, y] = [[], []];
  if (scale === "kinds") return { x, y };
  heights.forEach((height, i) => {
    x.push(axis.places[i]);
    y.push(height);
    if (!jumps[i]) return;
    x.push(axis.edges[i + 1]);
    y.push(NaN);
  });
  return { x, y };
}

// All points where they are few or of kinds, and those that no line reaches.
function dots(axis, heights, jumps, variable) {
  const isJoined = (i) => i >= 0 && i + 1 < heights.length && !jumps[i] && !Number.isNaN(heights[i] + heights[i + 1]);
  const isAlone = (i) => variable.named || heights.length <= FEW || !(isJoined(i - 1) || isJoined(i));
  const shown = heights.map((_, i) => i).filter((i) => !Number.isNaN(heights[i]) && isAlone(i));
  return {
    x: shown.map((i) => axis.places[i]),
    y: shown.map((i) => heights[i]),
  };
}

function steps(axis, heights, jumps) {
  const at = heights.map((_, i) => i).filter((i) => jumps[i]);
  return { x: at.map((i) => axis.edges[i + 1]), below: at.map((i) => heights[i]), above: at.map((i) => heights[i + 1]) };
}

// The curve through a place along an axis of a map.
async function drawAlong(host, axis, place, { variable, log }) {
  const scale = scaleOf(variable, log);
  const drawn = await figureIn(host, `along ${axes[axis].name} ${scale}`);
  setHeight(drawn, variable, scale);
  fillCurve(drawn, 0, axes[axis], lineThrough(place, axis), variable, scale);
  drawn.named("pinned").setv({ location: axes[axis].places[place[axis]], visible: true });
  const others = axes.map((_, other) => other).filter((other) => other !== axis);
  document.getElementById(`${host}-where`).textContent = others.length ? `at ${whereText(place, others)}` : "";
}

function curvesView(view) {
  const across = axisCalled(view.x);
  const hue = axisCalled(view.hue);
  const ways = view.ways ? axisCalled("direction") : -1;
  const steps = (axis) => (axis < 0 ? [0] : axes[axis].places.map((_, step) => step));
  let drawn, scale, shownVariable, shifts;

  // The place of each curve at the beginning of the axis.
  function curveStarts(place) {
    const start = at(place, across, 0);
    return steps(hue).flatMap((one) =>
      steps(ways).map((way) => {
        const curve = [...start];
        if (hue >= 0) curve[hue] = one;
        if (ways >= 0) curve[ways] = way;
        return curve;
      }),
    );
  }

  function heightAt(place) {
    const line = Math.max(0, place[hue] ?? 0) * steps(ways).length + (place[ways] ?? 0);
    return heightsOf(shownVariable, [pointAt(place)])[0] + shifts[line];
  }

  return {
    axes: [across, hue, ways].filter((axis) => axis >= 0),

    async draw(state) {
      shownVariable = state.variable;
      scale = scaleOf(state.variable, state.log);
      drawn = await figureIn("picture", `${view.figure} ${scale}`);
      setHeight(drawn, state.variable, scale);
      const lines = curveStarts(state.place).map((start) => lineThrough(start, across));
      shifts = lines.map((_, line) => (scale === "kinds" ? (line - (lines.length - 1) / 2) * PARTED / lines.length : 0));
      lines.forEach((points, line) => fillCurve(drawn, line, axes[across], points, state.variable, scale, shifts[line]));
      fillLegend(state.variable, lines.flat(), false);
      return drawn;
    },

    // The point of the nearest curve.
    placeAt(x, y, state) {
      const column = gapOf(axes[across].edges, x);
      const far = (place) => {
        const height = heightAt(place);
        if (Number.isNaN(height)) return Infinity;
        return Math.abs(shareOf(height, drawn.model.y_range, scale === "log") - shareOf(y, drawn.model.y_range, scale === "log"));
      };
      const there = curveStarts(state.place).map((start) => at(start, across, column));
      return there.reduce((best, place) => (far(place) < far(best) ? place : best));
    },

    point(place) {
      showPointer(drawn, place && pointBox(axes[across].places[place[across]], heightAt(place)));
    },

    pin(place) {
      const x = place ? axes[across].places[place[across]] : 0;
      drawn.named("pinned").setv({ location: x, visible: Boolean(place) });
      const isKnown = place && !Number.isNaN(heightAt(place));
      fill(drawn, "ring", isKnown ? { x: [x], y: [heightAt(place)] } : { x: [], y: [] });
    },

    markOrbits(places) {
      fill(drawn, "orbits", {
        x: places.map((place) => axes[across].places[place[across]]),
        y: places.map(heightAt),
      });
    },

    async drawThrough() {},
  };
}
