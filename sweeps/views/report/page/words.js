// What is said of a point: its parameters, all its variables, and how it is computed again.

// A symbol with its lower part lowered: σ_el is σ with a small el.
function symbolElement(symbol) {
  const element = document.createElement("span");
  const [first, ...lowered] = symbol.split("_");
  element.append(first);
  for (const part of lowered) {
    const [, low, rest] = part.match(/^([\p{L}\p{N},]*)(.*)$/u);
    const small = document.createElement("sub");
    small.textContent = low;
    element.append(small, rest);
  }
  return element;
}

// Everything that the file says of a point, into a table.
function fillReadout(id, place) {
  const point = pointAt(place);
  const varied = parameters.filter(({ axis }) => axis !== null);
  const rows = [
    ...varied.map((parameter) => parameterRow(parameter, place)),
    ...variables.map((variable) => variableRow(variable, point)),
  ];
  document.getElementById(id).replaceChildren(...rows);
}

function parameterRow(parameter, place) {
  const value = parameterText(parameter, place).split(" = ").at(-1);
  const words = parameter.name.replaceAll("_", " ");
  const symbol = parameter.symbol && parameter.symbol !== words ? [" ", symbolElement(parameter.symbol)] : [];
  return row([words, ...symbol], value, "parameter");
}

function variableRow(variable, point) {
  const made = row([variable.name.replaceAll("_", " ")], valueText(variable, point), "");
  const sentence = kindOf(variable, valuesOf(variable)[point])?.sentence;
  made.title = sentence ? `${variable.meaning}: ${sentence}` : variable.meaning;
  return made;
}

function row(head, value, className) {
  const made = document.createElement("tr");
  const cells = [document.createElement("th"), document.createElement("td")];
  cells[0].append(...head);
  cells[1].textContent = value;
  made.className = className;
  made.append(...cells);
  return made;
}

// What happened at a point that has no result, or no ordinary one; empty for the others.
function statusSentence(point) {
  const status = variableCalled("status");
  const kind = status && kindOf(status, valuesOf(status)[point]);
  return kind && kind.name !== "ok" ? `${kind.name}: ${kind.sentence}` : "";
}
