// Puts the figures into the page, and reacts to the mouse, the keys and the address.

function listen() {
  element("controls").addEventListener("input", read);
  element("release").addEventListener("click", release);
  document.addEventListener("keydown", press);
  document.querySelectorAll("[data-point]").forEach((button) => button.addEventListener("click", () => {
    pin(placeOf(Number(button.dataset.point)));
    element("look").scrollIntoView();
  }));
  for (const sheet of views.flatMap((scales) => Object.values(scales))) {
    const figure = model(sheet.figure);
    figure.on_event("tap", ({ x, y }) => pin(placeAt(sheet, x, y)));
    figure.on_event("rangesupdate", ({ x0, x1, y0, y1 }) => { if (isPicture(figure)) zoomed([x0, x1, y0, y1]); });
    figure.on_event("reset", () => zoomed(null));
    figure.on_event("mouseleave", () => look(state.place));
    figure.on_event("mousemove", ({ x, y }) => {
      const place = placeAt(sheet, x, y);
      if (!state.pinned && !live) state.place = place;
      look(place);
    });
  }
}

const isPicture = (figure) => model(state.view[scaleNow()].figure) === figure;

function zoomed(ends) {
  state.zoom = ends;
  remember();
}

function* everything(root) {
  for (const one of root.querySelectorAll("*")) {
    yield one;
    if (one.shadowRoot) yield* everything(one.shadowRoot);
  }
}

// Bokeh makes its figures stops of the Tab key, although no key does anything there.
function skipFigures() {
  for (const one of everything(document)) if (one.matches(".bk-events")) one.tabIndex = -1;
}

// A thumb also scrolls the page over figures. In a narrow window the figures are lower, and legends of narrow
// figures have one column.
function fit() {
  const [isTouched, isNarrow] = ["(pointer: coarse)", "(max-width: 600px)"].map((query) => matchMedia(query).matches);
  const isColumn = element("picture").clientWidth < 600;
  for (const figure of Bokeh.documents[0].all_models) {
    if (figure.type !== "Figure") continue;
    if (isTouched) figure.toolbar.active_drag = null;
    if (isNarrow) figure.height = Math.min(figure.height, 400);
    for (const part of figure.above) if (isColumn && part.orientation === "vertical") part.ncols = 1;
  }
}

async function start() {
  const ids = page.hosts.map((_, at) => page.document.roots[at].id);
  const roots = Object.fromEntries(ids.map((id, at) => [id, page.hosts[at]]));
  await Bokeh.embed.embed_items({ page: page.document }, [{ docid: "page", root_ids: ids, roots }]);
  fit();
  skipFigures();
  beginBlocks();
  if (live) {
    beginControls();
    beginServer();
  }
  if (views.length) listen();
  element("keep").addEventListener("click", () => {
    keep(state.kept ? null : state.motion);
    remember();
  });
  // The address that was typed, even if the page has written another one meanwhile.
  window.addEventListener("hashchange", ({ newURL }) => recall(new URL(newURL).hash.slice(1)));
  recall();
  document.body.dataset.ready = "yes";
}

start();
