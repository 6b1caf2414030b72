// Words and numbers. Python has escaped all text from the file.

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

// A word of a command, as HTML; names of results in a stack may be any text.
const ESCAPED = { "&": "&amp;", "<": "&lt;", ">": "&gt;" };
function quoted(word) {
  const whole = /^[\w=.+-]+$/.test(word) ? word : `'${word.replaceAll("'", `'"'"'`)}'`;
  return whole.replace(/[&<>]/g, (letter) => ESCAPED[letter]);
}

// The command that computes a point again; it selects the nearest point.
function replayCommand(place) {
  const own = parameters.filter(({ name, axis }) => axes[axis].name === name);
  const words = own.map(({ name, axis }) => `--at ${quoted(`${name}=${valueText(axis, place[axis])}`)}`);
  return [page.replay, ...words].join(" ");
}
