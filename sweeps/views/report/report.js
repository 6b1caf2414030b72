// Puts the numbers of the variable and the slice that are chosen into the figures of the page, and
// answers the mouse. Figures, colours and words come from Python, sweeps/views/report.

const page = JSON.parse(document.getElementById("data").textContent);
const { axes, parameters, variables, views, orbits } = page;
const state = { view: views[0], variable: variables[0], log: false, place: page.start, pinned: false };

const element = (id) => document.getElementById(id);
const inputs = [...element("sliders").querySelectorAll("input")];
const regime = variables.find(({ name }) => name === "regime") ?? variables[0];

// A place is one number for each axis; points are numbered as in the arrays, the last axis first.
const strides = axes.map((_, axis) => axes.slice(axis + 1).reduce((all, { size }) => all * size, 1));
const pointAt = (place) => place.reduce((point, at, axis) => point + at * strides[axis], 0);
const placeOf = (point) => axes.map(({ size }, axis) => Math.floor(point / strides[axis]) % size);

const models = new Map();
function model(name) {
  if (!models.has(name)) models.set(name, Bokeh.documents[0].get_model_by_name(name));
  return models.get(name);
}
const sourceOf = (sheet, name) => model(sheet.figure).renderers.find((shape) => shape.name === name).data_source;
const valueOf = (name, at) => model(`values of ${name}`).data.values[at];

// --- charts ---

const scaleNow = () => (state.variable.names ? "kinds" : state.log ? "log" : "linear");

// What goes up; a logarithm has no place for what is not above 0.
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

// The place of each curve of a sheet, at one place of its axis.
function placesOfCurves({ x, curves }, place, at) {
  return curves.map((own) => own.reduce((start, [axis, index]) => start.with(axis, index), place.with(x.axis, at)));
}

// Fill a figure and show it in its host, the only one there.
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
  if (sheet.kind === "curves" || sheet.heights) {
    figure.y_range.setv({ start, end, reset_start: start, reset_end: end });
    figure.left[0].axis_label = label;
    if (names) figure.left[0].major_label_overrides = new Map(names.entries());
  }
  FILL[sheet.kind](sheet, place);
  const host = Bokeh.documents[0].roots()[page.hosts.indexOf(id)];
  if (host.children[0] !== figure) host.children = [figure];
}

// Where a point lies in a figure.
function spotOf(sheet, place) {
  if (sheet.kind === "cells") return [sheet.x, sheet.y].map(({ places, axis }) => places[place[axis] ?? 0]);
  if (sheet.kind === "curves") return [sheet.x.places[place[sheet.x.axis]], heightAt(pointAt(place))];
  const { x, y } = sourceOf(sheet, "cells").data;
  return [x[place[sheet.axis]], y[place[sheet.axis]]];
}

function mark(sheet, name, places) {
  const spots = places.map((place) => spotOf(sheet, place)).filter(([, y]) => !Number.isNaN(y));
  sourceOf(sheet, name).data = { x: spots.map(([x]) => x), y: spots.map(([, y]) => y) };
}

// NaN is none of them.
function indexOfLeast(distances) {
  return distances.reduce((best, one, at) => (one < distances[best] || Number.isNaN(distances[best]) ? at : best), 0);
}

// The place that the mouse means: the cell under it, else the nearest point, as it is seen.
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

// --- words; whatever of them is text of the file was escaped in Python ---

function numberText(value) {
  if (!Number.isFinite(value)) return "none";
  const [rounded, size] = [Number(value.toPrecision(6)), Math.abs(value)];
  const text = size && (size < 1e-4 || size >= 1e6) ? rounded.toExponential() : String(rounded);
  return text.replace(/e\+?(.*)/, "×10<sup>$1</sup>").replaceAll("-", "−");
}

function variableText({ name, names, units }, point) {
  const value = valueOf(name, point);
  return names ? (names[value] ?? "none") : numberText(value) + (Number.isFinite(value) ? units : "");
}

function parameterText({ name, axis, texts, units, factor }, place) {
  return texts ? texts[place[axis]] : numberText(valueOf(name, place[axis]) * factor) + units;
}

// The parameters along some axes, or all.
function whereText(place, wanted = () => true) {
  const along = parameters.filter(({ axis }) => wanted(axis));
  return along.map((one) => one.prefix + parameterText(one, place)).join(", ") || "the only point";
}

function fillReadout(id, place) {
  const texts = [
    ...parameters.map((one) => parameterText(one, place)),
    ...variables.map((one) => variableText(one, pointAt(place))),
  ];
  element(id).querySelectorAll("td").forEach((cell, row) => { cell.innerHTML = texts[row]; });
}

// The command that computes a point again; it takes the nearest point.
function replayCommand(place) {
  const own = parameters.filter(({ name, axis }) => axes[axis].name === name);
  const words = own.map(({ name, axis }) => `--at ${name}=${valueText(axis, place[axis])}`);
  return [page.replay, ...words].join(" ");
}

// Show the orbit that is nearest to a place, of its kind if there is one.
function showOrbit(place) {
  const number = valueOf("nearest orbit", pointAt(place));
  const { point, words, drawn } = orbits[number];
  const own = placeOf(point);
  const [here, there] = [point, pointAt(place)].map((one) => variableText(regime, one));
  const kinds = here === there ? " among those of its kind" : ` (${here}; there: ${there})`;
  const other = `<span>The point with an orbit in this page that is nearest to ${whereText(place)}${kinds}.</span>`;
  const head = `<strong>${whereText(own)}</strong>${point === pointAt(place) ? "" : other}`;
  element("orbit-words").innerHTML = `${head}${words}<code>${replayCommand(own)}</code>`;
  element("orbit-figures").hidden = !drawn;
  if (drawn) model("motion").data = model(`orbit ${number}`).data;
  fillReadout("orbit-numbers", own);
}

// --- what is moved ---

// Show what there is at a place and, on a map, the curves through it unless another is pinned.
function look(place) {
  const isOther = state.pinned && place !== state.place;
  fillReadout("readout", place);
  element("readout-heading").textContent = state.pinned && !isOther ? "Pinned point" : "Point";
  element("replay").innerHTML = replayCommand(place);
  const sheet = state.view?.[scaleNow()];
  const lines = sheet?.kind === "cells" ? [sheet.x.axis, sheet.y.axis].filter((axis) => page.along[axis]) : [];
  element("through").hidden = !lines.length;
  lines.forEach((axis, at) => {
    if (isOther) return;
    const [id, along] = [["along-x", "along-y"][at], page.along[axis][scaleNow()]];
    show(along, id, place);
    mark(along, "mark", [place]);
    element(`${id}-where`).innerHTML = `at ${whereText(place, (other) => other !== axis)}`;
  });
}

function draw() {
  element("view").selectedIndex = views.indexOf(state.view);
  element("variable").selectedIndex = variables.indexOf(state.variable);
  element("log").checked = state.log;
  const sheet = state.view[scaleNow()];
  const inSlice = (place) => sheet.sliders.every((axis) => place[axis] === state.place[axis]);
  const marked = element("marks").checked ? orbits.map(({ point }) => placeOf(point)).filter(inSlice) : [];
  show(sheet, "picture", state.place);
  mark(sheet, "orbits", marked);
  mark(sheet, "mark", state.pinned ? [state.place] : []);
  element("picture").ariaLabel = ["view", "variable"].map((id) => element(id).selectedOptions[0].text).join(": ");
  element("legend").innerHTML = (sheet.heights ? regime : state.variable).legend;
  element("release").hidden = !state.pinned;
  element("log").disabled = Boolean(state.variable.names);
  inputs.forEach((input, axis) => {
    input.value = state.place[axis];
    const slider = input.closest("div");
    slider.hidden = !sheet.sliders.includes(axis);
    const output = slider.querySelector("output");
    output.innerHTML = whereText(state.place, (other) => other === axis);
    input.ariaValueText = output.textContent; // its own value is the number of a point
  });
  look(state.place);
}

function change(changes) {
  Object.assign(state, changes);
  element("strange").hidden = true;
  draw();
  remember();
}

// The picture has the focus then: keys move the pin on.
function pin(place) {
  change({ place, pinned: true });
  if (orbits.length) showOrbit(place);
  element("picture").focus({ preventScroll: true });
}

function release() {
  if (state.pinned) change({ pinned: false });
}

// Take over what the controls say; errors are looked at on a logarithmic scale.
function read({ target }) {
  const [view, variable] = [views[element("view").selectedIndex], variables[element("variable").selectedIndex]];
  if (target.id === "variable") element("log").checked = !variable.names && variable.name.includes("error");
  const place = inputs.map((input) => Number(input.value));
  const log = element("log").checked && !variable.names;
  change(target.type === "range" ? { place, pinned: false } : { view, variable, log });
}

// --- keys: which way they go, across or upward, and how far ---

const STEPS = {
  ArrowLeft: [0, -1],
  ArrowRight: [0, 1],
  ArrowDown: [1, -1],
  ArrowUp: [1, 1],
  Home: [0, -Infinity],
  End: [0, Infinity],
};

// The points among which there is no axis to go along: those of a cloud, or of all curves at one value.
function placesAround(sheet) {
  if (sheet.kind === "cells") return [];
  if (sheet.kind === "curves") return placesOfCurves(sheet, state.place, state.place[sheet.x.axis]);
  return Array.from({ length: axes[sheet.axis].size }, (_, at) => state.place.with(sheet.axis, at));
}

// The place next to the present one: along an axis, else the next point that is seen on that side.
function placeBeside(sheet, [side, step]) {
  const moved = (at, size) => Math.min(Math.max(at + step, 0), size - 1);
  const axis = [sheet.x, sheet.y][side]?.axis ?? -1;
  if (axis >= 0) return state.place.with(axis, moved(state.place[axis], axes[axis].size));
  const seen = placesAround(sheet).map((place) => ({ place, spot: spotOf(sheet, place) }))
    .filter(({ spot }) => spot.every(Number.isFinite))
    .sort((one, other) => one.spot[side] - other.spot[side]);
  const here = seen.findIndex(({ place }) => pointAt(place) === pointAt(state.place));
  return seen[moved(here, seen.length)]?.place ?? state.place;
}

// Whether a key is for the picture: it has the focus, or nothing has. Of a page that is only read, keys
// that scroll are left alone until a point is pinned, and while the picture is out of sight.
function isForPicture({ key, altKey, ctrlKey, metaKey, shiftKey }) {
  if (!STEPS[key] || altKey || ctrlKey || metaKey || shiftKey) return false;
  const { top, bottom } = element("picture").getBoundingClientRect();
  if (bottom < 0 || top > window.innerHeight) return false;
  if (element("picture").contains(document.activeElement)) return true;
  const scrolls = !["ArrowLeft", "ArrowRight"].includes(key);
  return document.activeElement === document.body && (state.pinned || !scrolls);
}

// It would stay where the mouse is, away from the pin.
function hideCrosshair(sheet) {
  const crosshair = model(sheet.figure).toolbar.tools.find(({ name }) => name === "crosshair");
  crosshair?.overlay.forEach((line) => { line.location = null; });
}

function press(event) {
  if (event.key === "Escape") release();
  if (!isForPicture(event)) return;
  event.preventDefault(); // or the page scrolls
  const sheet = state.view[scaleNow()];
  pin(placeBeside(sheet, STEPS[event.key]));
  hideCrosshair(sheet);
  const values = new Set([state.variable, regime]);
  const texts = [...values].map((one) => variableText(one, pointAt(state.place)));
  element("spoken").innerHTML = `${whereText(state.place)}: ${texts.join(", ")}`;
}

// --- the address: it says what the page shows, so that a link opens it there ---

// The values along an axis in the file.
function valuesAlong(axis) {
  const { name, keys } = parameters.find((one) => one.name === axes[axis].name);
  return keys ?? model(`values of ${name}`).data.values;
}

// As few digits as tell a value from the others.
function valueText(axis, at) {
  const value = valuesAlong(axis)[at];
  if (typeof value === "string") return value;
  for (let digits = 4; digits < 17; digits++) {
    const text = String(Number(value.toPrecision(digits)));
    if (placeAlong(axis, text) === at) return text;
  }
  return String(value);
}

// Where a value of the address is on an axis: at the nearest one; nowhere if that is more than a step away.
function placeAlong(axis, text) {
  const values = valuesAlong(axis);
  if (values.includes(text)) return values.indexOf(text);
  const [wanted, low, high] = [text.trim() ? Number(text) : NaN, values[0], values.at(-1)];
  if (!(wanted >= low - (values[1] - low) && wanted <= high + (high - values.at(-2)))) return undefined;
  return indexOfLeast(Array.from(values, (value) => Math.abs(value - wanted)));
}

function address() {
  const places = axes.map(({ name }, axis) => [name, valueText(axis, state.place[axis])]);
  return new URLSearchParams([
    ["view", element("view").value],
    ["variable", state.variable.name],
    ...(state.log ? [["scale", "log"]] : []),
    ...places,
    ...(state.pinned ? [["pinned", "yes"]] : []),
  ]);
}

// Browsers limit how often an address changes, and a slider that is drawn changes it often.
let waiting;
function remember() {
  clearTimeout(waiting);
  waiting = setTimeout(() => history.replaceState(null, "", `#${address()}`), 200);
}

// What the address may choose beside values of the axes.
const CHOICES = new Map([
  ["view", (text) => views[[...element("view").options].findIndex(({ value }) => value === text)]],
  ["variable", (text) => variables.find(({ called }) => called.includes(text))],
  ["scale", (text) => ["linear", "log"].find((one) => one === text)],
  ["pinned", (text) => ["no", "yes"].find((one) => one === text)],
]);

// What is chosen and where that is, and what the page does not have. A part of the page may be named as well.
function readAddress() {
  const [chosen, place, strange] = [{}, [...page.start], []];
  const hash = location.hash.slice(1);
  for (const [key, text] of new URLSearchParams(element(hash) ? "" : hash)) {
    const axis = axes.findIndex(({ called }) => called.includes(key));
    const isChoice = CHOICES.has(key);
    const found = isChoice ? CHOICES.get(key)(text) : axes[axis] && placeAlong(axis, text);
    if (found === undefined) strange.push({ isChoice, words: isChoice || axes[axis] ? `${key}=${text}` : key });
    else if (isChoice) chosen[key] = found;
    else place[axis] = found;
  }
  return { chosen, place, strange };
}

// Take over what the address says; what it does not say, or says of no such thing, is as on a page without one.
function recall() {
  clearTimeout(waiting);
  const { chosen, place, strange } = readAddress();
  const { view = views[0], variable = variables[0], scale, pinned } = chosen;
  const isThere = strange.every(({ isChoice }) => isChoice); // or the pin would be at another point
  Object.assign(state, { view, variable, place, log: scale === "log" && !variable.names, pinned: pinned === "yes" && isThere });
  const words = strange.map((one) => one.words).join(", ");
  element("strange").textContent = words && `The address names ${words}, which this page does not have.`;
  element("strange").hidden = !words;
  draw();
  if (orbits.length) showOrbit(state.place);
}

function listen() {
  window.addEventListener("hashchange", recall);
  element("controls").addEventListener("input", read);
  element("release").addEventListener("click", release);
  document.addEventListener("keydown", press);
  document.querySelectorAll("[data-point]").forEach((button) => button.addEventListener("click", () => {
    pin(placeOf(Number(button.dataset.point)));
    element("look").scrollIntoView();
  }));
  for (const sheet of views.flatMap((scales) => Object.values(scales))) {
    const figure = model(sheet.figure);
    figure.on_event("tap", ({ x, y }) => pin(placeAt(sheet, x, y)));
    figure.on_event("mouseleave", () => look(state.place));
    figure.on_event("mousemove", ({ x, y }) => {
      const place = placeAt(sheet, x, y);
      if (!state.pinned) state.place = place;
      look(place);
    });
  }
}

// A thumb scrolls the page over pictures too; in a narrow window these are lower, and a legend is a column.
function fit() {
  const [isTouched, isNarrow] = ["(pointer: coarse)", "(max-width: 600px)"].map((query) => matchMedia(query).matches);
  for (const figure of Bokeh.documents[0].all_models) {
    if (figure.type !== "Figure") continue;
    if (isTouched) figure.toolbar.active_drag = null;
    if (!isNarrow) continue;
    figure.height = Math.min(figure.height, 400);
    for (const part of figure.above) if (part.orientation === "vertical") part.ncols = 1;
  }
}

async function start() {
  const ids = page.hosts.map((_, at) => page.document.roots[at].id);
  const roots = Object.fromEntries(ids.map((id, at) => [id, page.hosts[at]]));
  await Bokeh.embed.embed_items({ page: page.document }, [{ docid: "page", root_ids: ids, roots }]);
  fit();
  if (views.length) {
    listen();
    recall();
  } else {
    look(state.place);
    if (orbits.length) showOrbit(state.place);
  }
  document.body.dataset.ready = "yes";
}

start();
