// The blocks in motion: springs, film, friction force, and the marks that move along in the figures.

// The index of the last of the rising values that does not exceed the wanted one.
function indexBefore(values, wanted) {
  let [low, high] = [0, values.length - 1];
  while (low < high) {
    const middle = Math.ceil((low + high) / 2);
    if (values[middle] <= wanted) low = middle;
    else high = middle - 1;
  }
  return low;
}

const SECONDS = 5; // on the screen, for a period of the drive
const STEPS = 1000;
// The drawing: its middle, how far a block moves, the walls, the film and its layers.
const [MIDDLE, REACH, LEFT, RIGHT] = [190, 55, 8, 372];
const [HALF, TOP, BOTTOM, SLANT, LAYERS] = [50, 34, 54, 10, 12];

function zigzag(from, to) {
  const turns = 10;
  const points = Array.from({ length: turns + 1 }, (_, at) =>
    [from + ((to - from) * at) / turns, 76 + (at === 0 || at === turns ? 0 : at % 2 ? 7 : -7)]);
  return `M${points.map((point) => point.join(" ")).join("L")}`;
}

const largest = (values) => values.reduce((most, value) => Math.max(most, Math.abs(value)), 0);

// A colour between that of the liquid, at 0, and that of the most solid film of the motion.
function colourOf(part) {
  const ends = [[214, 234, 246], [0, 90, 150]];
  return `rgb(${ends[0].map((low, at) => Math.round(low + part * (ends[1][at] - low)))})`;
}

// A mark over a figure, which moves without the figure being drawn again.
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

// The blocks at a part of the motion. The samples are closer together where more happens.
function player() {
  const [portrait, ...courses] = ["portrait", ...COURSES].map(model);
  const moments = courses.map((course) => markOver(course, "border-left: 1px solid #444"));
  const spot = markOver(portrait, "width: 9px; height: 9px; margin: -6px; border: 2px solid #000; border-radius: 50%; background: #fff");
  let moved = false;
  let [part, playing, before] = [0, false, 0];
  let most = {};
  let data = null;
  let [at, beyond] = [0, 0]; // the sample before the present time, and the part of the way to the next one

  const valueAt = (name) => data[name][at] + beyond * (data[name][at + 1] - data[name][at]);

  function measure() {
    const { upper_displacement: X, lower_displacement: x, elastic_stress, friction_force, order_parameter } = data;
    most = {
      displacement: Math.max(largest(X), largest(x)),
      stress: largest(elastic_stress),
      force: largest(friction_force),
      order: Math.max(largest(order_parameter), 0.01), // a liquid film has some noise
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

  function locate() {
    const times = data.elapsed_time;
    const time = times[0] + part * (times.at(-1) - times[0]);
    at = Math.min(indexBefore(times, time), times.length - 2);
    beyond = (time - times[at]) / (times[at + 1] - times[at] || 1);
  }

  function show(next) {
    part = next - Math.floor(next);
    locate();
    element("time").value = Math.round(part * STEPS);
    moved = true;
    drawBlocks();
    moveMarks();
  }

  function frame(now) {
    if (!playing) return;
    show(part + (now - before) / (1000 * SECONDS * state.motion.periods));
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
    show(part + parts / STEPS / state.motion.periods);
  }

  element("play").addEventListener("click", () => play(!playing));
  element("back").addEventListener("click", () => step(-10));
  element("forward").addEventListener("click", () => step(10));
  element("time").addEventListener("input", ({ target }) => { play(false); show(Math.min(target.value / STEPS, 0.9999)); });
  // The marks move when a figure that was moved or zoomed is drawn.
  const after = () => moved && requestAnimationFrame(moveMarks);
  for (const { x_range, y_range } of [portrait, courses[0]]) {
    x_range.change.connect(after);
    y_range.change.connect(after);
  }
  return (motion) => {
    data = motion;
    measure();
    locate();
    drawBlocks();
    if (moved) moveMarks();
  };
}

let showThem = () => {};

// Draw the blocks of the motion that is drawn.
function showBlocks() {
  element("blocks").hidden = !state.motion?.data;
  if (state.motion?.data) showThem(state.motion.data);
}

function beginBlocks() {
  if (element("player").closest(".absent")) return;
  showThem = player();
  showBlocks();
}
