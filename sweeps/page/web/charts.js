// Puts the numbers of the chosen variable and slice into the figures.

const scaleOf = (variable, log) => (variable.names ? "kinds" : log ? "log" : "linear");
const scaleNow = () => scaleOf(state.variable, state.log);

// Whether the variable is on the vertical axis.
const isOfValues = ({ kind, heights }) => kind === "curves" || Boolean(heights);

// The height of a point; a logarithmic scale has no place for values that are not above 0.
function heightAt(point) {
  const value = valueOf(state.variable.name, point);
  return state.log && !(value > 0) ? NaN : value;
}

const FILL = {
  cells(sheet, place) {
    const [columns, rows] = [sheet.x, sheet.y].map(({ pixels, places }) => pixels ?? [...places.keys()]);
    const [right, up] = [sheet.x, sheet.y].map(({ axis }) => strides[axis] ?? 0);
    const first = pointAt(place.map((at, axis) => (axis === sheet.x.axis || axis === sheet.y.axis ? 0 : at)));
    const values = rows.flatMap((row) =>
      columns.map((column) => valueOf(state.variable.name, first + row * up + column * right)));
    const source = sourceOf(sheet, "cells");
    const Image = source.data.image[0].constructor;
    source.data = { image: [new Image(Float32Array.from(values), [rows.length, columns.length])] };
  },

  curves(sheet, place) {
    const { places, edges, axis } = sheet.x;
    const bit = variables.indexOf(state.variable);
    const jumping = `jumps along ${axes[axis].name}`;
    placesOfCurves(sheet, place, 0).map(pointAt).forEach((first, number) => {
      const line = { x: [], y: [] };
      const jumps = { x: [], below: [], above: [] };
      const points = places.map((_, at) => first + at * strides[axis]);
      points.forEach((point, at) => {
        line.x.push(places[at]);
        line.y.push(heightAt(point));
        if (!((valueOf(jumping, point) >> bit) & 1)) return;
        line.x.push(edges[at + 1]);
        line.y.push(NaN);
        jumps.x.push(edges[at + 1]);
        jumps.below.push(heightAt(point));
        jumps.above.push(heightAt(points[at + 1]));
      });
      const missing = places.filter((_, at) => Number.isNaN(heightAt(points[at])));
      sourceOf(sheet, `curve ${number}`).data = line;
      sourceOf(sheet, `jumps ${number}`).data = jumps;
      sourceOf(sheet, `missing ${number}`).data = { x: missing, y: missing.map(() => page.crosses) };
    });
  },

  cloud(sheet, place) {
    const source = sourceOf(sheet, "cells");
    const points = Array.from(source.data.x, (_, at) => pointAt(place.with(sheet.axis, at)));
    const value = points.map((point) => valueOf((sheet.heights ? regime : state.variable).name, point));
    source.data = { ...source.data, value, ...(sheet.heights && { y: points.map(heightAt) }) };
  },
};

// The place of each curve of a sheet, at one point of its axis.
function placesOfCurves({ x, curves }, place, at) {
  return curves.map((own) => own.reduce((start, [axis, index]) => start.with(axis, index), place.with(x.axis, at)));
}

// A figure keeps its ranges while others are shown, and may have been zoomed before.
function zoomTo({ x_range, y_range }, zoom) {
  if (zoom) {
    const [left, right, bottom, top] = zoom;
    x_range.setv({ start: left, end: right });
    y_range.setv({ start: bottom, end: top });
    // Otherwise Bokeh would fit ranges of points to all points again when it draws them.
    for (const range of [x_range, y_range]) range.have_updated_interactively = true;
  } else for (const range of [x_range, y_range]) range.reset();
}

// Fill a figure and show it in its host, which shows one figure at a time.
function show(sheet, id, place) {
  const { palette, label, names, ranges } = state.variable;
  const [low, high, start, end] = ranges[scaleNow()];
  const figure = model(sheet.figure);
  const mapper = model(`colours ${state.log ? "log" : "linear"}`);
  mapper.setv({ low, high, palette: palette ?? model("colours log").palette });
  for (const shape of figure.renderers.filter(({ glyph }) => glyph.color_mapper)) {
    shape.visible = shape.glyph.color_mapper === mapper;
  }
  for (const bar of figure.right) bar.visible = bar.color_mapper === mapper && !palette;
  if (isOfValues(sheet)) {
    figure.y_range.setv({ start, end, reset_start: start, reset_end: end });
    figure.left[0].axis_label = label;
    if (names) figure.left[0].major_label_overrides = new Map(names.entries());
  }
  if (id === "picture") zoomTo(figure, state.zoom);
  FILL[sheet.kind](sheet, place);
  const host = Bokeh.documents[0].roots()[page.hosts.indexOf(id)];
  if (host.children[0] !== figure) host.children = [figure];
}

// The position of a point in a figure.
function spotOf(sheet, place) {
  if (sheet.kind === "cells") return [sheet.x, sheet.y].map(({ places, axis }) => places[place[axis] ?? 0]);
  if (sheet.kind === "curves") return [sheet.x.places[place[sheet.x.axis]], heightAt(pointAt(place))];
  const { x, y } = sourceOf(sheet, "cells").data;
  return [x[place[sheet.axis]], y[place[sheet.axis]]];
}

function mark(sheet, name, places) {
  markSpots(sheet, name, places.map((place) => spotOf(sheet, place)));
}

function markSpots(sheet, name, all, dash = []) {
  for (const shape of model(sheet.figure).renderers) if (shape.name === name) shape.glyph.line_dash = dash;
  const spots = all.filter((spot) => spot.every(Number.isFinite));
  sourceOf(sheet, name).data = { x: spots.map(([x]) => x), y: spots.map(([, y]) => y) };
}

// The position of a computed point in a figure; NaN for a coordinate that its numbers do not give.
function spotOfOpened(sheet, { shown }) {
  const along = ({ axis, places }) => {
    if (axis < 0) return places[0];
    const { name, isNumber } = axes[axis];
    return isNumber ? (shown[name] ?? NaN) : NaN;
  };
  if (sheet.kind === "cells") return [along(sheet.x), along(sheet.y)];
  const { name: own, codes } = state.variable;
  // Kinds are at their places among those of the file, which may lack this one.
  const height = codes && !codes.includes(shown[own]) ? NaN : (codes?.indexOf(shown[own]) ?? shown[own] ?? NaN);
  if (sheet.kind === "curves") return [along(sheet.x), height];
  return sheet.names.map((name) => (name === "" ? height : (shown[name] ?? NaN)));
}

// The index of the least distance that is not NaN.
function indexOfLeast(distances) {
  return distances.reduce((best, one, at) => (one < distances[best] || Number.isNaN(distances[best]) ? at : best), 0);
}

// The place under the mouse: its cell or, without cells, the nearest point on the screen.
function placeAt(sheet, x, y) {
  const cell = ({ edges }, value) => edges.slice(1, -1).filter((edge) => edge <= value).length;
  if (sheet.kind === "cells") {
    const [column, row] = [cell(sheet.x, x), cell(sheet.y, y)];
    return state.place.map((at, axis) => (axis === sheet.x.axis ? column : axis === sheet.y.axis ? row : at));
  }
  const { x_range, y_range } = model(sheet.figure);
  const far = (a, b, { start, end }, log) => (log ? Math.log(a / b) / Math.log(end / start) : (a - b) / (end - start));
  if (sheet.kind === "curves") {
    const places = placesOfCurves(sheet, state.place, cell(sheet.x, x));
    return places[indexOfLeast(places.map((place) => Math.abs(far(spotOf(sheet, place)[1], y, y_range, state.log))))];
  }
  const { x: xs, y: ys } = sourceOf(sheet, "cells").data;
  const [logX, logY] = sheet.log;
  const distances = Array.from(xs, (_, at) => Math.hypot(far(xs[at], x, x_range, logX), far(ys[at], y, y_range, logY)));
  return state.place.with(sheet.axis, indexOfLeast(distances));
}
