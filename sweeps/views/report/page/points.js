// Points: cases in no order, over a parameter and a variable, or over two parameters in colours.

function pointsView(view) {
  const parameterCalled = (name) => parameters.find((parameter) => parameter.name === name);
  const [x, y] = [parameterCalled(view.x), view.y ? parameterCalled(view.y) : null];
  const cases = x.axis;
  const regime = variableCalled("regime");
  let drawn, scale, xs, ys, points;

  const shown = (parameter, point) => valuesOf(parameter)[placeOf(point)[parameter.axis]] * parameter.factor;
  const isLog = (way) => drawn.model[`${way}_scale`].type === "LogScale";

  function positionOf(place) {
    const i = place[cases];
    return Number.isNaN(ys[i]) ? { x: [], y: [] } : { x: [xs[i]], y: [ys[i]] };
  }

  return {
    axes: [cases],

    async draw(state) {
      const { variable, log } = state;
      scale = y ? "linear" : scaleOf(variable, log);
      drawn = await figureIn("picture", y ? view.figure : `${view.figure} ${scale}`);
      points = lineThrough(at(state.place, cases, 0), cases);
      xs = points.map((point) => shown(x, point));
      ys = y ? points.map((point) => shown(y, point)) : heightsOf(variable, points);
      const coloured = y || !regime ? variable : regime;
      const colour = painter(coloured, y ? log : false);
      fill(drawn, "cells", { x: xs, y: ys, colour: points.map((point) => colour(valuesOf(coloured)[point]).css) });
      setRange(drawn.model.x_range, roomAround(extent(xs), isLog("x")));
      if (y) setRange(drawn.model.y_range, roomAround(extent(ys), isLog("y")));
      else setHeight(drawn, variable, scale);
      showColourBar(drawn, { variable: coloured, log: y ? log : false });
      fillLegend(coloured, points);
      return drawn;
    },

    // The nearest point on the screen.
    placeAt(across, up, state) {
      const { model } = drawn;
      const far = (i) => {
        const dx = shareOf(xs[i], model.x_range, isLog("x")) - shareOf(across, model.x_range, isLog("x"));
        const dy = shareOf(ys[i], model.y_range, isLog("y")) - shareOf(up, model.y_range, isLog("y"));
        const far = (dx * model.inner_width) ** 2 + (dy * model.inner_height) ** 2;
        return Number.isNaN(far) ? Infinity : far;
      };
      const distances = points.map((_, i) => far(i));
      return at(state.place, cases, distances.indexOf(Math.min(...distances)));
    },

    point(place) {
      showPointer(drawn, place && pointBox(xs[place[cases]], ys[place[cases]]));
    },

    pin(place) {
      fill(drawn, "ring", place ? positionOf(place) : { x: [], y: [] });
    },

    markOrbits(places) {
      const known = places.map(positionOf);
      fill(drawn, "orbits", { x: known.flatMap((one) => one.x), y: known.flatMap((one) => one.y) });
    },

    async drawThrough() {},
  };
}

function extent(values) {
  const known = values.filter((value) => !Number.isNaN(value));
  return [known.reduce((a, b) => Math.min(a, b)), known.reduce((a, b) => Math.max(a, b))];
}
