// The result: its axes, its points by number and by place, and what there is to say of a point.

const data = JSON.parse(document.getElementById("payload").textContent);
const { axes, parameters, variables, views } = data;

// A place is one number for each axis; points are numbered as in the arrays, the last axis first.
const strides = axes.map((_, axis) => axes.slice(axis + 1).reduce((all, { size }) => all * size, 1));
const pointCount = axes.reduce((all, { size }) => all * size, 1);

const unpacked = new Map();

// The numbers of a variable or a parameter; NaN where a point has none.
function valuesOf(quantity) {
  if (!unpacked.has(quantity)) unpacked.set(quantity, unpack(quantity.values));
  return unpacked.get(quantity);
}

function pointAt(place) {
  return place.reduce((point, at, axis) => point + at * strides[axis], 0);
}

function placeOf(point) {
  return axes.map(({ size }, axis) => Math.floor(point / strides[axis]) % size);
}

function axisCalled(name) {
  return axes.findIndex((axis) => axis.name === name);
}

function variableCalled(name) {
  return variables.find((variable) => variable.name === name);
}

// The points of a line along an axis, through a place.
function lineThrough(place, axis) {
  const first = pointAt(place) - place[axis] * strides[axis];
  return Array.from({ length: axes[axis].size }, (_, at) => first + at * strides[axis]);
}

function parameterText(parameter, place) {
  const at = parameter.axis === null ? 0 : place[parameter.axis];
  if (parameter.texts) return parameter.texts[at];
  const shown = valuesOf(parameter)[at] * parameter.factor;
  return `${parameter.symbol} = ${numberText(shown, parameter.units)}`;
}

// The values of the parameters that vary along some axes, or along all of them.
function whereText(place, along = axes.map((_, axis) => axis)) {
  const varied = parameters.filter(({ axis }) => axis !== null && along.includes(axis));
  return varied.map((parameter) => parameterText(parameter, place)).join(", ") || "the only point";
}

// The kind of a code, such as a regime; a code that has none is unknown.
function kindOf(variable, code) {
  return variable.kinds.find((kind) => kind.code === code);
}

function valueText(variable, point) {
  const value = valuesOf(variable)[point];
  if (variable.named) return kindOf(variable, value)?.name ?? "none";
  return numberText(value, variable.units);
}

// The command that computes a point again; values are those of the file, to the last digit.
function replayCommand(place) {
  const own = parameters.filter(({ axis, name }) => axis !== null && axes[axis].name === name);
  const texts = own.map((parameter) => {
    const at = place[parameter.axis];
    return `${parameter.name}=${parameter.keys?.[at] ?? valuesOf(parameter)[at]}`;
  });
  const chosen = [...data.at, ...texts].map((text) => ` --at ${quoted(text)}`);
  return `stickslip replay ${quoted(data.file)}${chosen.join("")}`;
}

// A word for a shell, which takes it as it is.
function quoted(word) {
  return /^[\w@%+=:,./-]+$/.test(word) ? word : `'${word.replaceAll("'", `'\\''`)}'`;
}
