// Numbers as they are read: packed ones unpacked, plain ones written with six digits.

const RAISED = { "-": "⁻", 0: "⁰", 1: "¹", 2: "²", 3: "³", 4: "⁴", 5: "⁵", 6: "⁶", 7: "⁷", 8: "⁸", 9: "⁹" };
const LARGEST_DENOMINATOR = 12;

function unpack(packed) {
  if ("all" in packed) {
    return new Float64Array(packed.size).fill(packed.all === null ? NaN : packed.all);
  }
  const bytes = Uint8Array.from(atob(packed.base64), (letter) => letter.charCodeAt(0));
  return packed.dtype === "f8" ? new Float64Array(bytes.buffer) : new Float32Array(bytes.buffer);
}

// The text of a number; one without a unit may be a fraction, such as the rheological index.
function numberText(value, units = "") {
  if (!Number.isFinite(value)) return "none";
  const fraction = units ? "" : fractionText(value);
  const text = fraction || decimalText(value);
  return text.replace("-", "−") + (units ? ` ${units}` : "");
}

function decimalText(value) {
  const [mantissa, exponent] = value.toExponential(5).split("e");
  if (Number(exponent) >= -4 && Number(exponent) < 6) return String(Number(value.toPrecision(6)));
  const raised = [...String(Number(exponent))].map((letter) => RAISED[letter]).join("");
  return `${Number(mantissa)}×10${raised}`;
}

function fractionText(value) {
  for (let below = 2; below <= LARGEST_DENOMINATOR; below++) {
    const above = Math.round(value * below);
    const near = Math.abs(above / below - value) <= 1e-9 * Math.abs(value);
    const isShort = Math.abs(Number(value.toPrecision(6)) - value) <= 1e-12 * Math.abs(value);
    if (near && !isShort) return `${above}/${below}`;
  }
  return "";
}

// Where a value lies in rising numbers: the number of the gap between two of them, kept inside.
function gapOf(rising, value) {
  let low = 0;
  let high = rising.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (rising[middle] <= value) low = middle;
    else high = middle;
  }
  return low;
}
