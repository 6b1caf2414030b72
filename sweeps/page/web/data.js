// The data of the page, and the names by which the modules find them. Figures, colours and words come from
// Python (sweeps/page).

const page = JSON.parse(document.getElementById("data").textContent);
const { axes, parameters, variables, views, orbits } = page;
const live = page.live ?? null; // only on a page served by a process that computes

// What the page shows: `motion` and `kept` are motions (motion.js), `opened` is the answer about the open point
// (server.js), `zoom` has the chosen ranges of the picture.
const state = {
  view: views[0], variable: variables[0], log: false, place: page.start, pinned: false, zoom: null,
  motion: null, kept: null, opened: null,
};

const element = (id) => document.getElementById(id);
const inputs = [...element("sliders").querySelectorAll("input")];
const regime = variables.find(({ name }) => name === "regime") ?? variables[0];

// A place has one number for each axis. Points are numbered in the order of the arrays: the last axis runs fastest.
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
