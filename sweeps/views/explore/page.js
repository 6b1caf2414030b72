// What the page does in the browser: the two blocks move, arrow keys step through the chart, the
// address tells what is shown. Everything else is computed in Python, sweeps/views/explore.

const page = (() => {
"use strict";

const element = (id) => document.getElementById(id);

// --- the address ---

function keepAddress(state) {
  const ask = () => { state.asked = location.hash.slice(1); };
  let waiting; // browsers limit how often an address changes, and a slider changes it often
  state.properties.address.change.connect(() => {
    clearTimeout(waiting);
    waiting = setTimeout(() => history.replaceState(null, "", `#${state.address}`), 200);
  });
  addEventListener("hashchange", ask);
  if (location.hash.length > 1) ask();
}

// --- the keyboard ---

function hearArrows(state) {
  const chart = element("chart");
  let strokes = 0;
  chart?.addEventListener("keydown", (event) => {
    const busy = event.composedPath()[0].matches("input, select, button, [role=slider]");
    if (busy || event.altKey || event.ctrlKey || event.metaKey || !event.key.startsWith("Arrow")) return;
    event.preventDefault(); // the page would scroll
    state.key = `${event.key} ${strokes += 1}`;
  });
}

function* everything(root) {
  for (const one of root.querySelectorAll("*")) {
    yield one;
    if (one.shadowRoot) yield* everything(one.shadowRoot);
  }
}

// Bokeh's sliders have no name for those who hear the page, and its figures stop the tabulator
// where no key does anything.
function nameParts() {
  for (const one of everything(document)) {
    if (one.matches(".bk-events")) one.tabIndex = -1;
    const label = one.matches(".noUi-handle") && one.getRootNode().host.dataset.label;
    if (label) one.setAttribute("aria-label", label);
  }
}

// --- the blocks ---

const SECONDS = 5; // that a period of the drive takes on the screen
const STEPS = 1000;
// Of the drawing: its middle, how far a block moves, the walls, the film and its layers.
const [MIDDLE, REACH, LEFT, RIGHT] = [190, 55, 8, 372];
const [HALF, TOP, BOTTOM, SLANT, LAYERS] = [50, 34, 54, 10, 12];

function zigzag(from, to) {
  const turns = 10;
  const points = Array.from({ length: turns + 1 }, (_, at) =>
    [from + ((to - from) * at) / turns, 76 + (at === 0 || at === turns ? 0 : at % 2 ? 7 : -7)]);
  return `M${points.map((point) => point.join(" ")).join("L")}`;
}

const largest = (values) => values.reduce((most, value) => Math.max(most, Math.abs(value)), 0);

// From the liquid's colour, at 0, to that of the most solid film of the motion.
function colourOf(part) {
  const ends = [[214, 234, 246], [0, 90, 150]];
  return `rgb(${ends[0].map((low, at) => Math.round(low + part * (ends[1][at] - low)))})`;
}

// A mark over a figure, which need not be drawn anew for it to move.
function markOver(figure, look) {
  const { frame, shadow_el } = Bokeh.index.find_one_by_id(figure.id);
  const mark = document.createElement("div");
  mark.style.cssText = `position: absolute; pointer-events: none; ${look}`;
  mark.hidden = true;
  shadow_el.append(mark);
  return (x, y) => {
    const { left, right, top, bottom, height } = frame.bbox;
    const [across, up] = [frame.x_scale.compute(x), y === undefined ? top : frame.y_scale.compute(y)];
    mark.hidden = !(across >= left && across <= right && up >= top && up <= bottom);
    mark.style.left = `${across}px`;
    mark.style.top = `${up}px`;
    if (y === undefined) mark.style.height = `${height}px`;
  };
}

function player({ state, motion, portrait, courses }) {
  const moments = courses.map((course) => markOver(course, "border-left: 1px solid #444"));
  const spot = markOver(portrait, "width: 9px; height: 9px; margin: -6px; border: 2px solid #000; border-radius: 50%; background: #fff");
  let moved = false;
  let [part, playing, before] = [0, false, 0];
  let most = {};

  const valueAt = (name) => {
    const values = motion.data[name] ?? [0];
    return values[Math.round(part * (values.length - 1))];
  };

  function measure() {
    const { upper_displacement: X, lower_displacement: x, elastic_stress, friction_force, order_parameter } = motion.data;
    most = {
      displacement: Math.max(largest(X), largest(x)),
      stress: largest(elastic_stress),
      force: largest(friction_force),
      order: Math.max(largest(order_parameter ?? [0]), 0.01), // a liquid film has some noise
    };
  }

  function drawBlocks() {
    const place = (name) => MIDDLE + (REACH * valueAt(name)) / (most.displacement || 1);
    const [upper, lower] = [place("upper_displacement"), place("lower_displacement")];
    const order = valueAt("order_parameter");
    const slant = (SLANT * valueAt("elastic_stress")) / (most.stress || 1);
    const force = (40 * valueAt("friction_force")) / (most.force || 1);
    element("upper").setAttribute("transform", `translate(${upper})`);
    element("lower").setAttribute("transform", `translate(${lower})`);
    element("film").setAttribute("x", lower - HALF);
    element("film").setAttribute("fill", colourOf(order / most.order));
    element("springs").setAttribute("d", zigzag(LEFT, lower - HALF) + zigzag(lower + HALF, RIGHT));
    const layers = Array.from({ length: LAYERS }, (_, at) => lower - HALF + 6 + (at * (2 * HALF - 12)) / (LAYERS - 1));
    element("layers").setAttribute("d", layers.map((x) => `M${x} ${BOTTOM}L${x + slant} ${TOP}`).join(""));
    element("layers").setAttribute("stroke", `rgba(255, 255, 255, ${order / most.order})`);
    const head = Math.sign(force) * 6;
    element("force").setAttribute("d", Math.abs(force) < 1 ? "" :
      `M${lower} 65h${force}m${-head} -5l${head} 5l${-head} 5`);
    const time = valueAt("elapsed_time");
    element("clock").textContent = `t = ${time.toFixed(4)} s, φ = ${order.toFixed(3)}`;
  }

  function moveMarks() {
    const [time, x, v] = ["elapsed_time", "lower_displacement", "lower_velocity"].map(valueAt);
    moments.forEach((moment) => moment(time));
    spot(x, v);
  }

  function show(next) {
    part = next - Math.floor(next);
    element("time").value = Math.round(part * STEPS);
    moved = true;
    drawBlocks();
    moveMarks();
  }

  function frame(now) {
    if (!playing) return;
    show(part + (now - before) / (1000 * SECONDS * state.periods));
    before = now;
    requestAnimationFrame(frame);
  }

  function play(wanted) {
    playing = wanted;
    element("play").textContent = playing ? "Pause" : "Play";
    before = performance.now();
    if (playing) requestAnimationFrame(frame);
  }

  function step(parts) {
    play(false);
    show(part + parts / STEPS / state.periods);
  }

  element("play").addEventListener("click", () => play(!playing));
  element("back").addEventListener("click", () => step(-10));
  element("forward").addEventListener("click", () => step(10));
  element("time").addEventListener("input", ({ target }) => { play(false); show(Math.min(target.value / STEPS, 0.9999)); });
  motion.properties.data.change.connect(() => { measure(); drawBlocks(); });
  // What was moved or zoomed has other places for the marks, as soon as it is drawn.
  const after = () => moved && requestAnimationFrame(moveMarks);
  for (const { x_range, y_range } of [portrait, courses[0]]) {
    x_range.change.connect(after);
    y_range.change.connect(after);
  }
  measure();
  drawBlocks();
}

function begin(models) {
  keepAddress(models.state);
  hearArrows(models.state);
  nameParts();
  player(models);
  document.body.dataset.ready = "yes";
}

return { begin };
})();
