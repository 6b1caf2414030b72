// The end of the address says what the page shows, so that a link opens the same view. `view`, `variable`,
// `scale` and `zoom` choose the picture; `at.NAME` is a place in the file, and `pinned` pins the point there. On
// a served page, parameters and settings name a point as `--set` does. The keys of a kept orbit begin with
// `kept.`.

// The values along an axis in the file.
function valuesAlong(axis) {
  const { name, keys } = parameters.find((one) => one.name === axes[axis].name);
  return keys ?? model(`values of ${name}`).data.values;
}

// The same, from the lowest to the highest; points with names, and cases, may lie in another order.
const rising = new Map();
function risingAlong(axis) {
  const values = valuesAlong(axis);
  if (typeof values[0] === "string") return values;
  if (!rising.has(axis)) rising.set(axis, Float64Array.from(values).sort());
  return rising.get(axis);
}

// A value with as few digits as distinguish it from the others in the file.
function valueText(axis, at) {
  const value = valuesAlong(axis)[at];
  if (typeof value === "string") return value;
  for (let digits = page.fewestDigits; digits < 17; digits++) {
    const text = String(Number(value.toPrecision(digits)));
    if (placeAlong(axis, text) === at) return text;
  }
  return String(value);
}

// The place of a value of the address on an axis: the nearest point, unless it is more than a step away.
function placeAlong(axis, text) {
  const values = valuesAlong(axis);
  if (values.includes(text)) return values.indexOf(text);
  if (typeof values[0] === "string") return undefined; // names may look like numbers
  const ordered = risingAlong(axis);
  const [wanted, low, high] = [text.trim() ? Number(text) : NaN, ordered[0], ordered.at(-1)];
  if (!(wanted >= low - (ordered[1] - low) && wanted <= high + (high - ordered.at(-2)))) return undefined;
  return indexOfLeast(Array.from(values, (value) => Math.abs(value - wanted)));
}

const partsOfPlace = (place) =>
  Object.fromEntries(axes.map(({ name }, axis) => [`at.${name}`, valueText(axis, place[axis])]));

// The parameters that name the open point, if it is not a point of the file.
const ownParts = () => (live && state.opened && !state.opened.at ? state.opened.parts : {});

function address() {
  const kept = Object.entries(state.kept?.parts ?? {}).map(([key, text]) => [`kept.${key}`, text]);
  const chosen = views.length ? [["view", element("view").value], ["variable", state.variable.name]] : [];
  return new URLSearchParams([
    ...chosen,
    ...(state.log ? [["scale", "log"]] : []),
    ...(state.zoom ? [["zoom", state.zoom.map((end) => String(Number(end.toPrecision(6)))).join(",")]] : []),
    ...Object.entries(partsOfPlace(state.place)),
    ...(state.pinned ? [["pinned", "yes"]] : []),
    ...Object.entries(ownParts()),
    ...kept,
  ]);
}

// Browsers limit how often an address changes, and dragging a slider changes it often.
let waiting;
function remember() {
  clearTimeout(waiting);
  waiting = setTimeout(() => history.replaceState(null, "", `#${address()}`), 200);
}

function zoomOf(text) {
  const ends = text.split(",").map(Number);
  return ends.length === 4 && ends.every(Number.isFinite) ? ends : undefined;
}

// What the address may choose besides points.
const CHOICES = new Map([
  ["view", (text) => views[[...element("view").options].findIndex(({ value }) => value === text)]],
  ["variable", (text) => variables.find(({ called }) => called.includes(text))],
  ["scale", (text) => ["linear", "log"].find((one) => one === text)],
  ["zoom", zoomOf],
  ["pinned", (text) => ["no", "yes"].find((one) => one === text)],
]);

// What the address says of one point: its place, if it is in the file; its parameters and settings, if the page
// is served; and the parts that the page does not have.
function readPoint(entries, start) {
  const [place, parts, strange] = [[...start], {}, []];
  for (const [key, text] of entries) {
    const at = key.startsWith("at.");
    const name = at ? key.slice(3) : key;
    const axis = at || !live ? axes.findIndex(({ called }) => called.includes(name)) : -1;
    const index = axes[axis] && placeAlong(axis, text);
    if (index !== undefined) place[axis] = index;
    else if (live && !at) parts[key] = text; // the server judges it
    else strange.push(axes[axis] ? `${key}=${text}` : key);
  }
  return { place, parts, strange };
}

// The axes, for readers whose address had another value or name; in the units of the file, like addresses.
const axesInWords = () => {
  const ranges = axes.map(({ name }, axis) => {
    const [values, ordered] = [valuesAlong(axis), risingAlong(axis)];
    const [low, high] = [ordered[0], ordered.at(-1)].map((end) => valueText(axis, values.indexOf(end)));
    return `${name} from ${low} to ${high}`;
  });
  return ranges.length ? ` It has ${ranges.join(", ")}.` : "";
};

// Where a page opens without an address; a served page opens at its first point.
const startPlace = () =>
  axes.map(({ name }, axis) => placeAlong(axis, live?.first.at?.[`at.${name}`] ?? "") ?? page.start[axis]);

// What the address chooses, and what it says of the open point and the kept one. It may also name a part of the
// page.
function readAddress(hash) {
  const entries = [...new URLSearchParams(element(hash) ? "" : hash)];
  const [chosen, strange] = [{}, []];
  for (const [key, text] of entries.filter(([one]) => CHOICES.has(one))) {
    const found = CHOICES.get(key)(text);
    if (found === undefined) strange.push(`${key}=${text}`);
    else chosen[key] = found;
  }
  const ofPoint = entries.filter(([key]) => !CHOICES.has(key) && !key.startsWith("kept."));
  const ofKept = entries.filter(([key]) => key.startsWith("kept.")).map(([key, text]) => [key.slice(5), text]);
  const point = readPoint(ofPoint, startPlace());
  const kept = ofKept.length ? readPoint(ofKept, startPlace()) : null;
  strange.push(...point.strange, ...(kept?.strange ?? []));
  const order = (words) => entries.findIndex(([key, text]) => [key, `${key}=${text}`].includes(words));
  return { chosen, point, kept, strange: strange.sort((one, other) => order(one) - order(other)) };
}

// Show what an address says; everything else is as on a page without an address.
function recall(hash = location.hash.slice(1)) {
  clearTimeout(waiting);
  const { chosen, point, kept, strange } = readAddress(hash);
  const { view = views[0], variable = variables[0], scale, zoom = null, pinned } = chosen;
  // Otherwise the pin would be at another point.
  const isPinned = pinned === "yes" && !point.strange.length && axes.length > 0;
  const log = scale === "log" && !variable?.names;
  Object.assign(state, { view, variable, place: point.place, log, zoom, pinned: isPinned });
  element("strange").textContent = strange.length ? `The address names ${strange.join(", ")}, which this page does not have.${axesInWords()}` : "";
  element("strange").hidden = !strange.length;
  if (views.length) draw();
  open(point, kept);
}

// Open the point of an address, after the one to keep.
function open(point, kept) {
  if (live) {
    const isNamed = state.pinned || (!point.strange.length && String(point.place) !== String(startPlace()));
    const wanted = Object.keys(point.parts).length ? point.parts : isNamed ? partsOfPlace(point.place) : firstParts();
    const own = kept && (Object.keys(kept.parts).length ? kept.parts : partsOfPlace(kept.place));
    const begin = () => ask(wanted, undefined, (answer) => {
      showRefusedAddress(answer);
      if (!state.opened) ask(firstParts());
    });
    keep(null);
    if (own) ask(own, () => { keep(state.motion); begin(); }, (answer) => { showRefusedAddress(answer); begin(); });
    else begin();
  } else if (orbits.length) {
    keep(null);
    if (kept) {
      showOrbit(kept.place);
      keep(state.motion);
    }
    showOrbit(point.place);
  } else if (!views.length) look(state.place);
}
