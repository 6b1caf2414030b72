// The motion that is drawn, and a kept one beneath it. A motion has the `data` of its time courses (null if it
// cannot be followed), the number of drive `periods` that they last, `words` that name it, and the `parts` of an
// address that name its point.

const COURSES = ["lower_displacement", "elastic_stress", "friction_force"];

function emptied(name) {
  const empty = new Float64Array(2); // two points, because a figure wants a range
  return Object.fromEntries(Object.keys(model(name).data).map((column) => [column, empty]));
}

function drawMotion(motion) {
  state.motion = motion;
  element("orbit-figures").hidden = !motion.data;
  model("motion").data = motion.data ?? emptied("motion");
  showBlocks();
}

function keep(motion) {
  state.kept = motion;
  model("kept motion").data = motion?.data ?? emptied("kept motion");
  element("keep").textContent = motion ? "Drop the kept orbit" : "Keep this orbit";
  element("kept").hidden = !motion;
  element("kept").innerHTML = motion?.words ?? "";
}

// Draw the orbit in the page that is nearest to a place, and of the same kind if possible.
function showOrbit(place) {
  const number = valueOf("nearest orbit", pointAt(place));
  const { point, words, drawn, periods } = orbits[number];
  const own = placeOf(point);
  const [here, there] = [point, pointAt(place)].map((one) => variableText(regime, one));
  const kinds = here === there ? " among those of its kind" : ` (${here}; there: ${there})`;
  const other = `<span>This point is the nearest to ${whereText(place)} with an orbit in this page${kinds}.</span>`;
  const head = `<strong>${whereText(own)}</strong>${point === pointAt(place) ? "" : other}`;
  element("orbit-words").innerHTML = `${head}${words}<code>${replayCommand(own)}</code>`;
  const data = drawn ? model(`orbit ${number}`).data : null;
  drawMotion({ data, periods, words: `Kept: ${whereText(own)}.`, parts: partsOfPlace(own) });
  fillReadout("orbit-numbers", own);
}
