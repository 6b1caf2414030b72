// The orbits of chosen points: which one is nearest to a click, and its pictures.

const chosen = data.orbits.map((orbit) => ({ ...orbit, place: placeOf(orbit.point) }));

const SLIDER_WEIGHT = 2; // how much farther a point of another slice is

// For each axis how far along it a place is, from 0 to 1; for cases in no order each parameter counts.
const measures = axes.map(({ name, size }, axis) => {
  const linked = parameters.filter((parameter) => parameter.axis === axis && parameter.values && parameter.name !== name);
  if (name !== "case" || !linked.length) return [(place) => place[axis] / Math.max(size - 1, 1)];
  return linked.map((parameter) => {
    const values = valuesOf(parameter);
    const [low, high] = extent([...values]);
    const log = low > 0 && high > 20 * low;
    return (place) => shareOf(values[place[axis]], { start: low, end: high === low ? low + 1 : high }, log);
  });
});

function distance(place, other, sliders) {
  return measures.reduce((sum, along, axis) => {
    const squares = along.reduce((all, measure) => all + (measure(place) - measure(other)) ** 2, 0);
    return sum + squares * (sliders.includes(axis) ? SLIDER_WEIGHT ** 2 : 1);
  }, 0);
}

function nearestOrbit(place, sliders) {
  const far = chosen.map((orbit) => distance(place, orbit.place, sliders));
  return chosen[far.indexOf(Math.min(...far))];
}

// The chosen points that are in the picture.
function orbitsBeside(place, sliders) {
  const places = chosen.map((orbit) => orbit.place);
  return places.filter((other) => sliders.every((axis) => other[axis] === place[axis]));
}

// Show the orbit of a chosen point; `asked` is the place that it stands in for.
async function showOrbit(orbit, asked) {
  describeOrbit(orbit, asked);
  const figures = document.getElementById("orbit-figures");
  figures.hidden = Boolean(orbit.obstacle);
  if (orbit.obstacle) return;
  const names = Object.keys(orbit.columns);
  const columns = Object.fromEntries(names.map((name) => [name, unpack(orbit.columns[name])]));
  const [portrait, courses] = await Promise.all([figureIn("portrait", "portrait"), figureIn("courses", "courses")]);
  const [time, x, v, stress, force] = names.map((name) => columns[name]);
  const ranges = { x: around(x), v: around(v), stress: around(stress, LEAST_STRESS), force: around(force) };
  fill(portrait, "orbit", columns);
  fill(courses, "orbit", columns);
  setRange(portrait.model.x_range, ranges.x);
  setRange(portrait.model.y_range, ranges.v);
  const figuresBelow = courses.model.children;
  setRange(figuresBelow[0].x_range, [time[0], time.at(-1)]);
  [ranges.x, ranges.stress, ranges.force].forEach((range, i) => setRange(figuresBelow[i].y_range, range));
}

const LEAST_STRESS = 1e-6; // MPa: a stress below a pascal, of a liquid film, is none

function around(values, least = 0) {
  const [low, high] = extent([...values]);
  if (high - low < least) return [low - least, high + least];
  const room = 0.06 * (high - low || Math.abs(high) || 1);
  return [low - room, high + room];
}

function describeOrbit(orbit, asked) {
  const lines = [];
  lines.push(["strong", whereText(orbit.place)]);
  if (asked && orbit.point !== pointAt(asked)) lines.push(["span", otherSentence(orbit, asked)]);
  lines.push(["span", motionSentence(orbit)]);
  const status = statusSentence(orbit.point);
  if (status && !status.endsWith(orbit.obstacle)) lines.push(["em", status]);
  lines.push(["code", replayCommand(orbit.place)]);
  const elements = lines.map(([tag, text]) => {
    const element = document.createElement(tag);
    element.textContent = text;
    return element;
  });
  document.getElementById("orbit-words").replaceChildren(...elements);
  fillReadout("orbit-numbers", orbit.place);
}

// That this is not the point that was asked for, and whether the motion there is of another kind.
function otherSentence(orbit, asked) {
  const regime = variableCalled("regime");
  const [here, there] = [orbit.point, pointAt(asked)].map((point) => (regime ? valueText(regime, point) : ""));
  const kinds = here === there ? "" : ` (${here}; there: ${there})`;
  return `The point with an orbit in this page that is nearest to ${whereText(asked)}${kinds}.`;
}

function motionSentence({ obstacle, settled, closed, periods }) {
  const count = periods === 1 ? "1 drive period" : `${periods} drive periods`;
  if (obstacle) return `The motion cannot be followed: ${obstacle}`;
  if (!settled) return `There is no stationary orbit: ${count} from the initial state are drawn.`;
  return closed ? `The stationary orbit, which closes after ${count}.` : `The orbit does not close: ${count} of it are drawn.`;
}
