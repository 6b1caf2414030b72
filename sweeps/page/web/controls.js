// The controls of a served page: a slider and a box for every parameter, settings, copies, Reset.

const DIGITS = 4; // of the values of a logarithmic slider

const byName = (kind, name) => element(`${kind}-${name}`);

// The position of a slider is a value or its logarithm.
const positionOf = ({ log }, value) => (log ? Math.log10(value) : value);

// The value at a position, as round as its distance to the next one allows.
function valueOfSlider({ low, high, log, step }, position) {
  if (position <= positionOf({ log }, low)) return low;
  if (position >= positionOf({ log }, high)) return high;
  if (log) return Number((10 ** position).toPrecision(DIGITS));
  const decimals = Math.max(0, -Math.floor(Math.log10(step)));
  return Number((Math.round(position / step) * step).toFixed(decimals));
}

// A slider becomes longer if a value lies beyond its end.
function placeSlider(name, value) {
  const scale = live.scales[name];
  if (!scale.log || value > 0) {
    scale.low = Math.min(scale.low, value);
    scale.high = Math.max(scale.high, value);
  }
  const slider = byName("slider", name);
  const [low, high] = [scale.low, scale.high].map((end) => positionOf(scale, end));
  Object.assign(slider, { min: low, max: high });
  slider.value = scale.log && value <= 0 ? low : positionOf(scale, value);
  slider.ariaValueText = byName("box", name).value;
}

// Why the texts in some boxes are refused, by the names of the parameters.
const refusals = new Map();

function markBox(name) {
  const box = byName("box", name);
  box.classList.toggle("refused", refusals.has(name));
  box.ariaInvalid = refusals.has(name);
}

function showRefusals() {
  Object.keys(live.scales).forEach(markBox);
  const shown = (name) => `${(state.opened ?? live.first).texts[name]} ${plainOf(live.units[name])}`.trim();
  complain([...refusals].map(([name, why]) => `${why}. The page shows ${shown(name)}.`));
}

// The controls follow a point. A refused text stays in its box until the user chooses a point of the file.
function showControls({ texts, values, settings, at }) {
  if (at) refusals.clear();
  for (const [name, text] of Object.entries(texts)) {
    const box = byName("box", name);
    const isEdited = box === document.activeElement && box.value !== box.dataset.shown;
    if (refusals.has(name) || isEdited) continue;
    box.value = box.dataset.shown = text;
    placeSlider(name, values[name]);
  }
  for (const menu of document.querySelectorAll("[data-setting]")) {
    const text = settings[menu.dataset.setting];
    if (![...menu.options].some(({ value }) => value === text)) menu.add(new Option(text));
    menu.value = text;
  }
  showRefusals();
}

function showCopies({ config, command }) {
  for (const [id, text] of Object.entries({ config, command })) element(`copy-${id}`).value = text;
  for (const button of document.querySelectorAll("[data-copy]")) button.textContent = "Copy";
}

function complain(sentences) {
  const lines = sentences.map((sentence) => {
    const line = document.createElement("p");
    line.textContent = sentence;
    return line;
  });
  element("refusals").replaceChildren(...lines);
}

// The computed point keeps its previous values; other values that were wanted with them are requested again.
function showRefusal({ refused, sentence, parts }) {
  const shown = (state.opened ?? live.first).parts;
  if (!next) state.wanted = { ...parts };
  for (const [name, why] of Object.entries(refused)) {
    refusals.set(name, why);
    if (shown[name]) state.wanted[name] = shown[name];
    else delete state.wanted[name];
  }
  showRefusals();
  if (!refusals.size) complain([`This point cannot be shown: ${sentence}.`]);
  else if (!next && Object.entries(state.wanted).some(([key, text]) => shown[key] !== text)) ask(state.wanted);
  goOn();
}

// After a refusal the open point stays as it is, unless another one was requested.
function goOn() {
  if (next || flight) return;
  pinOpened();
  if (views.length) draw();
  remember();
}

// An address that is refused changes nothing; a page that it was to open opens as without an address.
function showRefusedAddress({ refused, sentence }) {
  const words = Object.values(refused).join("; ") || sentence;
  const { hidden, textContent } = element("strange");
  element("strange").textContent = `${hidden ? "" : `${textContent} `}This page cannot show the address: ${words}.`;
  element("strange").hidden = false;
  if (state.opened) {
    state.wanted = { ...state.opened.parts };
    goOn();
  }
}

// The text of a unit, which is HTML.
const plainOf = (html) => new DOMParser().parseFromString(html, "text/html").body.textContent;

// Request the open point with some parts changed; a point of the file becomes its parameters.
function askFor(changes) {
  state.pinned = false;
  element("strange").hidden = true;
  for (const name of Object.keys(changes)) refusals.delete(name);
  ask({ ...state.wanted, ...changes });
}

// Choose a setting; other settings of the noise, and the identity of a law, may not fit it.
function choose(key, text) {
  const unfit = { "noise.treatment": "noise.", "film.friction": "film.law" }[key];
  const others = Object.keys(state.wanted).filter((one) => unfit && one.startsWith(unfit));
  for (const other of others) delete state.wanted[other];
  askFor({ [key]: text, ...(key === "integrator.rtol" && { "stationary.rtol": text }) });
}

const firstParts = () => live.first.at ?? live.first.parts;

function reset() {
  refusals.clear();
  history.replaceState(null, "", location.pathname + location.search);
  recall();
}

async function copy({ target }) {
  await navigator.clipboard.writeText(element(target.dataset.copy).value);
  target.textContent = "Copied";
}

function beginControls() {
  state.wanted = { ...live.first.parts };
  for (const name of Object.keys(live.scales)) {
    const [slider, box] = ["slider", "box"].map((kind) => byName(kind, name));
    slider.addEventListener("input", () => {
      box.value = String(valueOfSlider(live.scales[name], Number(slider.value))).replace("e+", "e");
      slider.ariaValueText = box.value;
      askFor({ [name]: box.value });
    });
    box.addEventListener("change", () => {
      box.dataset.shown = box.value;
      askFor({ [name]: box.value });
    });
  }
  showControls(live.first);
  for (const menu of document.querySelectorAll("[data-setting]")) {
    menu.addEventListener("change", () => choose(menu.dataset.setting, menu.value));
  }
  for (const button of document.querySelectorAll("[data-copy]")) button.addEventListener("click", copy);
  element("reset").addEventListener("click", reset);
}
