// Maps: a variable over two axes, in colours, and the curves through a point along both.

function mapView(view) {
  const across = axisCalled(view.x);
  const up = axisCalled(view.y);
  let drawn;

  function pointsOf(place) {
    const rows = lineThrough(at(place, up, 0), up);
    return rows.flatMap((first) => lineThrough(placeOf(first), across));
  }

  function cellOf({ [across]: column, [up]: row }) {
    const [x, y] = [axes[across].edges, axes[up].edges];
    return { left: x[column], right: x[column + 1], bottom: y[row], top: y[row + 1] };
  }

  return {
    axes: [across, up],

    async draw(state) {
      drawn = await figureIn("picture", view.figure);
      const points = pointsOf(state.place);
      fill(drawn, "cells", cells(drawn, points, state));
      showColourBar(drawn, state);
      fillLegend(state.variable, points);
      return drawn;
    },

    // The place under the pointer.
    placeAt(x, y, state) {
      const place = [...state.place];
      place[across] = gapOf(axes[across].edges, x);
      place[up] = gapOf(axes[up].edges, y);
      return place;
    },

    point(place) {
      showPointer(drawn, place && cellOf(place));
    },

    pin(place) {
      const sides = ["left", "right", "bottom", "top"];
      fill(drawn, "pinned", Object.fromEntries(sides.map((side) => [side, place ? [cellOf(place)[side]] : []])));
    },

    markOrbits(places) {
      const along = (axis) => places.map((place) => axes[axis].places[place[axis]]);
      fill(drawn, "orbits", { x: along(across), y: along(up) });
    },

    async drawThrough(place, state) {
      await Promise.all([
        drawAlong("along-x", across, place, state),
        drawAlong("along-y", up, place, state),
      ]);
    },
  };

  function cells(drawn, points, { variable, log }) {
    const colour = painter(variable, log);
    const values = valuesOf(variable);
    const [x, y] = [axes[across].edges, axes[up].edges];
    const [width, height] = [axes[across].size, axes[up].size];
    if (!isImage(axes[across], axes[up])) return quads(points, x, y, (point) => colour(values[point]).css);
    const bytes = Uint32Array.from(points, (point) => colour(values[point]).bytes);
    const Image = drawn.named("cells").data.image[0].constructor;
    const extent = { x: [x[0]], y: [y[0]], dw: [x[width] - x[0]], dh: [y[height] - y[0]] };
    return { image: [new Image(bytes, [height, width])], ...extent };
  }
}

function at(place, axis, value) {
  return place.with(axis, value);
}

function isImage(x, y) {
  return x.uniform && y.uniform;
}

function quads(points, x, y, colourOfPoint) {
  const columns = x.length - 1;
  const column = (i) => i % columns;
  const row = (i) => Math.floor(i / columns);
  return {
    left: points.map((_, i) => x[column(i)]),
    right: points.map((_, i) => x[column(i) + 1]),
    bottom: points.map((_, i) => y[row(i)]),
    top: points.map((_, i) => y[row(i) + 1]),
    colour: points.map(colourOfPoint),
  };
}

// The bar of the scale that is used; kinds have a legend instead.
function showColourBar(drawn, { variable, log }) {
  for (const scale of ["linear", "log"]) {
    const bar = drawn.named(`${scale} bar`);
    const used = !isOfKinds(variable) && (scale === "log") === log;
    bar.visible = used;
    if (!used) continue;
    const [low, high] = rangeOf(variable, log);
    bar.color_mapper.setv({ low, high });
  }
}
