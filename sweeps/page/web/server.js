// Requests to the server, one at a time. The latest request that waits is sent when the previous one is answered,
// or has taken so long that nobody needs its answer any more.

const PATIENCE = 250; // milliseconds
const MOMENT = 400; // milliseconds: shorter waits are not announced
const LOADING = 2000; // milliseconds: compiled code loads in less

const tab = Array.from(crypto.getRandomValues(new Uint32Array(2))).join("-");
let asked = 0;
let next = null; // the request that waits
let flight = null; // the request that is under way

// Request the point that these parts name; `after` is called when it is shown, and `instead` if it is refused.
function ask(parts, after = () => {}, instead = showRefusal) {
  next = { parts, after, instead, since: next?.since ?? flight?.since ?? performance.now() };
  if (!Object.keys(parts).some((key) => key.startsWith("at."))) state.wanted = { ...parts };
  remember();
  send();
}

function send() {
  if (!next) return;
  const early = flight ? PATIENCE - (performance.now() - flight.begun) : 0;
  if (early > 0) {
    setTimeout(send, early);
    return;
  }
  flight?.abort.abort();
  flight = { ...next, begun: performance.now(), abort: new AbortController(), doing: "" };
  next = null;
  receive(flight);
}

async function receive(request) {
  const token = new URLSearchParams(location.search).get("token");
  const query = new URLSearchParams({ token, tab, number: asked += 1, ...request.parts });
  try {
    const response = await fetch(`orbit?${query}`, { signal: request.abort.signal });
    if (!response.ok) throw new Error(await response.text());
    for await (const answer of linesOf(response.body)) take(request, answer);
  } catch (error) {
    if (request !== flight) return; // another one was sent
    flight = null;
    complain([`The server has not answered: ${error.message}. Is \`stickslip explore\` still running?`]);
  }
  send();
}

// The lines of JSON of a body, as they arrive.
async function* linesOf(body) {
  const reader = body.pipeThrough(new TextDecoderStream()).getReader();
  let text = "";
  for (;;) {
    const { done, value } = await reader.read();
    if (done) return;
    const lines = (text + value).split("\n");
    text = lines.pop();
    for (const line of lines) yield JSON.parse(line);
  }
}

function take(request, answer) {
  if (request !== flight) return;
  if (["waiting", "compiling", "computing"].includes(answer.state)) {
    request.doing = answer.state;
    return;
  }
  flight = null;
  announce(); // else the page would go on waiting beside the answer until the next tick
  if (answer.state === "refused") request.instead(answer);
  if (answer.state !== "done") return;
  showAnswer(answer);
  request.after();
}

function unpacked(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return new Float32Array(bytes.buffer);
}

// The pin is at the open point, if this is a point of the file.
function pinOpened() {
  const at = state.opened?.at;
  state.pinned = Boolean(at);
  if (at) for (const [axis, { name }] of axes.entries()) state.place[axis] = placeAlong(axis, at[`at.${name}`]) ?? state.place[axis];
}

function showAnswer(answer) {
  const { courses, periods, kept, at, parts } = answer;
  const data = courses && Object.fromEntries(Object.entries(courses).map(([name, text]) => [name, unpacked(text)]));
  state.opened = answer;
  if (!next) { // otherwise a slider that was moved meanwhile, or the pin, would jump back
    state.wanted = { ...parts };
    showControls(answer);
    pinOpened();
  }
  element("where").textContent = answer.label;
  element("orbit-words").innerHTML = answer.summary;
  drawMotion({ data, periods, words: kept, parts: at ?? parts });
  showCopies(answer);
  if (views.length) draw();
  remember();
}

// Say what the page is waiting for, if that takes longer than a moment.
function announce() {
  const awaited = flight ?? next;
  const waited = awaited ? performance.now() - awaited.since : 0;
  const clock = `${Math.floor(waited / 60000)}:${String(Math.floor(waited / 1000) % 60).padStart(2, "0")}`;
  const words = {
    waiting: `waiting for the orbits of other tabs … ${clock}`,
    compiling: waited > LOADING ? `compiling for this processor: up to a minute, and kept for later runs (${clock})` : `computing … ${clock}`,
  };
  const text = waited > MOMENT ? (words[awaited.doing] ?? `computing … ${clock}`) : "";
  if (element("state").textContent !== text) element("state").textContent = text;
}

const beginServer = () => setInterval(announce, 200);
