// The page: what is shown, what the controls and the mouse change, and who draws it.

const VIEWS = { map: mapView, curves: curvesView, points: pointsView, "point map": pointsView };

// `place` is what curves are drawn through, `pinned` what a click froze them at.
const state = {
  view: null,
  variable: variables[0],
  log: false,
  marks: true,
  place: data.start,
  pinned: null,
};

const control = (id) => document.getElementById(id);

// Draws one after the other: a figure is embedded once, and the last state is what stays.
let drawing = Promise.resolve();
function draw() {
  drawing = drawing.then(drawView);
  return drawing;
}

async function drawView() {
  const drawn = await state.view.draw(state);
  drawn.heard.move = (x, y) => point(state.view.placeAt(x, y, state));
  drawn.heard.leave = () => point(null);
  drawn.heard.tap = (x, y) => pin(state.view.placeAt(x, y, state));
  state.view.markOrbits(state.marks ? orbitsBeside(state.place, sliders()) : []);
  state.view.pin(isShown(state.pinned) ? state.pinned : null);
  await look(state.pinned ?? state.place);
}

// The axes that have sliders: all but those of the view.
function sliders() {
  return axes.map((_, axis) => axis).filter((axis) => !state.view.axes.includes(axis));
}

function isShown(place) {
  return place !== null && sliders().every((axis) => place[axis] === state.place[axis]);
}

// Show what there is at a place; curves go through it unless one is pinned.
async function look(place) {
  fillReadout("readout", place);
  const isPinned = state.pinned && pointAt(place) === pointAt(state.pinned);
  control("readout-heading").textContent = isPinned ? "Pinned point" : "Point";
  control("replay").textContent = replayCommand(place);
  if (!state.pinned || isPinned) await state.view.drawThrough(place, state);
}

// The mouse is at a place, or has left.
function point(place) {
  state.view.point(place);
  if (place && !state.pinned) state.place = place;
  look(place ?? state.pinned ?? state.place);
}

// Freeze the curves at a place, and show the orbit that is nearest to it.
async function pin(place) {
  state.pinned = place;
  state.place = place;
  state.view.pin(place);
  control("release").hidden = false;
  const shown = chosen.length ? showOrbit(nearestOrbit(place, sliders()), place) : null;
  await Promise.all([look(place), shown]);
}

function release() {
  state.pinned = null;
  state.view.pin(null);
  control("release").hidden = true;
}

// Go to a point wherever it is, as from the table of failures.
async function visit(pointNumber) {
  const place = placeOf(pointNumber);
  state.place = place;
  makeSliders();
  state.pinned = place;
  await draw();
  await pin(place);
  control("look").scrollIntoView();
}

function makeSliders() {
  control("sliders").replaceChildren(...sliders().map(slider));
}

function slider(axis) {
  const label = document.createElement("label");
  const text = document.createElement("output");
  const input = document.createElement("input");
  Object.assign(input, { type: "range", min: 0, max: axes[axis].size - 1, step: 1, value: state.place[axis] });
  input.name = axes[axis].name;
  const tell = () => { text.textContent = whereText(state.place, [axis]); };
  input.addEventListener("input", () => {
    state.place = at(state.place, axis, Number(input.value));
    tell();
    release();
    draw();
  });
  tell();
  label.append(text, input);
  return label;
}

function choices(select, names, choose) {
  select.replaceChildren(...names.map((name, number) => new Option(name, number)));
  select.addEventListener("change", () => choose(Number(select.value)));
}

function chooseView(number) {
  state.view = VIEWS[views[number].kind](views[number]);
  control("through").hidden = views[number].kind !== "map";
  makeSliders();
  return draw();
}

function chooseVariable(number) {
  state.variable = variables[number];
  state.log = /error/.test(state.variable.name) && state.variable.log_range !== undefined;
  control("log").checked = state.log;
  control("log").disabled = state.variable.log_range === undefined;
  return draw();
}

function begin() {
  choices(control("view"), views.map(({ label }) => label), chooseView);
  choices(control("variable"), variables.map(({ called }) => called), chooseVariable);
  control("log").addEventListener("change", () => { state.log = control("log").checked; draw(); });
  control("marks").addEventListener("change", () => { state.marks = control("marks").checked; draw(); });
  control("release").addEventListener("click", () => { release(); draw(); });
  document.addEventListener("keydown", ({ key }) => { if (key === "Escape") { release(); draw(); } });
  for (const button of document.querySelectorAll("[data-point]")) {
    button.addEventListener("click", () => visit(Number(button.dataset.point)));
  }
}

async function start() {
  Bokeh.set_log_level("warn");
  if (views.length) {
    begin();
    state.view = VIEWS[views[0].kind](views[0]);
    await chooseView(0);
  } else {
    fillReadout("readout", []);
    control("replay").textContent = replayCommand([]);
  }
  if (chosen.length) await showOrbit(nearestOrbit(state.place, views.length ? sliders() : []), null);
  document.body.dataset.ready = "yes";
}

start();
