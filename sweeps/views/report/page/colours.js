// What the colours stand for: kinds by name, or a scale of values.

const MISSING = colourOf(data.missing);
const SCALE = data.palette.map(colourOf);

// A colour for a style sheet, and as four bytes of an image.
function colourOf(css) {
  const [red, green, blue] = [1, 3, 5].map((at) => parseInt(css.slice(at, at + 2), 16));
  return { css, bytes: ((255 << 24) | (blue << 16) | (green << 8) | red) >>> 0 };
}

function isOfKinds(variable) {
  return variable.kinds.length > 0;
}

// The range of the colours of a variable, or of its heights.
function rangeOf(variable, log) {
  return log ? variable.log_range : variable.range;
}

// A function from a value of a variable to its colour.
function painter(variable, log) {
  if (isOfKinds(variable)) {
    const colours = new Map(variable.kinds.map(({ code, colour }) => [code, colourOf(colour)]));
    return (value) => colours.get(value) ?? MISSING;
  }
  const scale = log ? Math.log : (value) => value;
  const [low, high] = rangeOf(variable, log).map(scale);
  const steps = SCALE.length / (high - low || 1);
  return (value) => {
    const at = Math.floor((scale(value) - low) * steps);
    return Number.isNaN(at) || at === -Infinity ? MISSING : SCALE[Math.min(Math.max(at, 0), SCALE.length - 1)];
  };
}

// Squares with names and numbers of points, of a slice; and how many of it have no value.
function fillLegend(variable, points, withKinds = true) {
  const values = valuesOf(variable);
  const counts = new Map();
  let missing = 0;
  for (const point of points) {
    const value = values[point];
    if (Number.isNaN(value)) missing++;
    else counts.set(value, (counts.get(value) ?? 0) + 1);
  }
  const entries = variable.kinds
    .filter(({ code }) => withKinds && counts.has(code))
    .map(({ code, colour, name, sentence }) => [colour, `${name} (${counts.get(code)})`, sentence]);
  if (missing) entries.push([data.missing, `no value (${missing})`, "These points have no result, or this variable is not defined there."]);
  const title = document.createElement("strong");
  title.append(symbolElement(variable.label));
  title.title = variable.meaning;
  document.getElementById("legend").replaceChildren(title, ...entries.map((entry) => legendEntry(...entry)));
}

function legendEntry(colour, text, title) {
  const entry = document.createElement("span");
  const square = document.createElement("i");
  square.style.background = colour;
  entry.append(square, text);
  entry.title = title;
  return entry;
}
