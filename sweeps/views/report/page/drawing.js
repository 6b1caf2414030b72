// Figures: embedded when they are first looked at, filled by the names of their sources.

const embedded = new Map();

// The figure of a name in its place, the other figures of that place hidden.
async function figureIn(host, name) {
  const place = document.getElementById(host);
  if (!embedded.has(name)) embedded.set(name, embed(place, name));
  const drawn = await embedded.get(name);
  for (const other of place.children) other.hidden = other !== drawn.element;
  return drawn;
}

async function embed(place, name) {
  const element = document.createElement("div");
  element.id = `figure-${embedded.size}`;
  place.append(element);
  const shown = await Bokeh.embed.embed_item(data.figures[name], element.id);
  const [view] = shown.roots;
  const { model } = view;
  const named = (called) => model.document.get_model_by_name(called);
  return { element, view, model, named, pointer: pointerIn(element), ...listeners(model) };
}

// What marks the place under the mouse: above the figure, which need not be drawn anew for it.
function pointerIn(element) {
  const pointer = document.createElement("div");
  pointer.className = "pointer";
  pointer.hidden = true;
  element.append(pointer);
  return pointer;
}

// Mark a box, or a point where it has no extent, given in the units of the axes; null for nothing.
function showPointer({ view, pointer }, box) {
  pointer.hidden = box === null;
  if (box === null) return;
  const { frame } = view;
  const { left, right, top, bottom } = frame.bbox;
  const inside = (value, low, high) => Math.min(Math.max(value, low), high);
  const [x0, x1] = [box.left, box.right].map((x) => inside(frame.x_scale.compute(x), left, right));
  const [y1, y0] = [box.bottom, box.top].map((y) => inside(frame.y_scale.compute(y), top, bottom));
  pointer.classList.toggle("ring", box.left === box.right);
  Object.assign(pointer.style, { left: `${x0}px`, top: `${y0}px`, width: `${x1 - x0}px`, height: `${y1 - y0}px` });
}

function pointBox(x, y) {
  return Number.isNaN(y) ? null : { left: x, right: x, bottom: y, top: y };
}

// What a figure calls with the values that the mouse is at.
function listeners(model) {
  const heard = { move: () => {}, leave: () => {}, tap: () => {} };
  if (model.x_range) {
    model.on_event("mousemove", ({ x, y }) => heard.move(x, y));
    model.on_event("mouseleave", () => heard.leave());
    model.on_event("tap", ({ x, y }) => heard.tap(x, y));
  }
  return { heard };
}

// Fill a source, by the name that it has in a figure; columns of equal length.
function fill(drawn, name, columns) {
  const source = drawn.named(name);
  source.data = columns;
}

function setRange(range, [start, end]) {
  range.setv({ start, end, reset_start: start, reset_end: end });
}

// A little more than from the lowest to the highest value, on the scale of an axis.
function roomAround([low, high], log) {
  if (log) {
    const span = Math.max(high / low, 1.1);
    return [low * span ** -0.04, low * span ** 1.06];
  }
  const span = high - low || 1;
  return [low - 0.04 * span, low + 1.06 * span];
}

// A number between 0 and 1 for where a value lies in the range of an axis.
function shareOf(value, { start, end }, log) {
  if (log) return Math.log(value / start) / Math.log(end / start);
  return (value - start) / (end - start);
}

// The value at such a share of a range.
function valueAt([start, end], share, log) {
  return log ? start * (end / start) ** share : start + share * (end - start);
}
