// The look of the page: the picture, the numbers of a point, the pin, and the keys that move it.

// Show the numbers at a place and, on a map, the curves through it unless another point is pinned.
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

// The ring is at the pin; a dashed ring is at the parameters of a point outside the file.
function markOpened(sheet) {
  if (state.pinned || !state.opened) mark(sheet, "mark", state.pinned ? [state.place] : []);
  else markSpots(sheet, "mark", [spotOfOpened(sheet, state.opened)], [4, 3]);
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
  markOpened(sheet);
  element("picture").ariaLabel = ["view", "variable"].map((id) => element(id).selectedOptions[0].text).join(": ");
  element("legend").innerHTML = (sheet.heights ? regime : state.variable).legend;
  element("release").hidden = live || !state.pinned;
  element("log").disabled = Boolean(state.variable.names);
  inputs.forEach((input, axis) => {
    input.value = state.place[axis];
    const slider = input.closest("div");
    slider.hidden = !sheet.sliders.includes(axis);
    const output = slider.querySelector("output");
    output.innerHTML = whereText(state.place, (other) => other === axis);
    input.ariaValueText = output.textContent; // the value of the slider is just a point number
  });
  look(state.place);
}

function change(changes) {
  Object.assign(state, changes);
  element("strange").hidden = true;
  draw();
  remember();
}

// Pin a point. The picture gets the focus, so that keys move the pin.
function pin(place) {
  change({ place, pinned: true });
  if (live) ask(partsOfPlace(place));
  else if (orbits.length) showOrbit(place);
  element("picture").focus({ preventScroll: true });
}

function release() {
  if (state.pinned && !live) change({ pinned: false });
}

// Read the controls. Errors get a logarithmic scale. An open point of the file moves with the slice. The zoom
// stays where the axes do.
function read({ target }) {
  if (target.type === "range") {
    const place = inputs.map((input) => Number(input.value));
    change(live ? { place } : { place, pinned: false });
    if (live && state.pinned) ask(partsOfPlace(place));
    return;
  }
  const [view, variable] = [views[element("view").selectedIndex], variables[element("variable").selectedIndex]];
  if (target.id === "variable") element("log").checked = !variable.names && variable.name.includes("error");
  const log = element("log").checked && !variable.names;
  const isOther = variable !== state.variable || log !== state.log;
  const ofValues = [state.view[scaleNow()], view[scaleOf(variable, log)]].some(isOfValues);
  change({ view, variable, log, zoom: view !== state.view || (isOther && ofValues) ? null : state.zoom });
}

// --- keys: whether they go across or up, and how far ---

const WAYS = {
  ArrowLeft: [0, -1],
  ArrowRight: [0, 1],
  ArrowDown: [1, -1],
  ArrowUp: [1, 1],
  Home: [0, -Infinity],
  End: [0, Infinity],
};

// The points between which keys move without an axis: those of a cloud, or of all curves at one value.
function placesAround(sheet) {
  if (sheet.kind === "cells") return [];
  if (sheet.kind === "curves") return placesOfCurves(sheet, state.place, state.place[sheet.x.axis]);
  return Array.from({ length: axes[sheet.axis].size }, (_, at) => state.place.with(sheet.axis, at));
}

// The place next to the present one along an axis or, without one, the next visible point on that side.
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

// True for a key that acts on the picture, which must have the focus, unless nothing has it. Keys still scroll
// the page while the picture is out of sight, and until a point is pinned.
function isForPicture({ key, altKey, ctrlKey, metaKey, shiftKey }) {
  if (!WAYS[key] || altKey || ctrlKey || metaKey || shiftKey) return false;
  const { top, bottom } = element("picture").getBoundingClientRect();
  if (bottom < 0 || top > window.innerHeight) return false;
  if (element("picture").contains(document.activeElement)) return true;
  const scrolls = !["ArrowLeft", "ArrowRight"].includes(key);
  return document.activeElement === document.body && (state.pinned || !scrolls);
}

// Otherwise the crosshair would stay at the mouse, away from the pin.
function hideCrosshair(sheet) {
  const crosshair = model(sheet.figure).toolbar.tools.find(({ name }) => name === "crosshair");
  crosshair?.overlay.forEach((line) => { line.location = null; });
}

function press(event) {
  if (event.key === "Escape") release();
  if (!isForPicture(event)) return;
  event.preventDefault(); // otherwise the page would scroll
  const sheet = state.view[scaleNow()];
  pin(placeBeside(sheet, WAYS[event.key]));
  hideCrosshair(sheet);
  const values = new Set([state.variable, regime]);
  const texts = [...values].map((one) => variableText(one, pointAt(state.place)));
  element("spoken").innerHTML = `${whereText(state.place)}: ${texts.join(", ")}`;
}
