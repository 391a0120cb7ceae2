// Numbers as people read them, and elements made of text that stays text.

// As `robomore.runs.words.number`, digit for digit: so many significant digits, thousands apart.
export function number(value, digits = 4) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "-";
  if (value === 0) return "0";
  const text = rounded(value, digits);
  const places = digits - 1 - Number(value.toExponential().split("e")[1]);
  if (places > 8 || places < digits - 12) return text.replace(/e([+-])(\d)$/, "e$10$2");
  const shown = Math.max(0, places);
  return Number(text).toLocaleString("en-US", { minimumFractionDigits: shown, maximumFractionDigits: shown });
}

// Returns `1.234e+5`. What lies half between two numbers becomes the even one, as in Python.
function rounded(value, digits) {
  const [exact, exponent] = value.toExponential(100).split("e");
  const kept = exact.slice(0, exact.indexOf(".") + digits);
  const half = /^50*$/.test(exact.slice(kept.length));
  return half && "02468".includes(kept.at(-1)) ? `${kept}e${exponent}` : value.toExponential(digits - 1);
}

// With one digit after the point, and no sign before a zero.
export function tenths(value) {
  return (Math.round(value * 10) / 10 + 0).toFixed(1);
}

// Returns an element; strings among `content` become text, never markup.
export function make(name, attributes = {}, ...content) {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (value !== null && value !== undefined && value !== false) {
      element.setAttribute(key, value === true ? "" : value);
    }
  }
  element.append(...content.filter((one) => one !== null && one !== undefined && one !== ""));
  return element;
}

export function drawn(name, attributes = {}, ...content) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  element.append(...content);
  return element;
}

// A list of names and values.
export function facts(pairs) {
  return make("dl", {}, ...pairs.filter(([, value]) => value !== null && value !== undefined
    && value !== false && value !== "").flatMap(([name, value]) => [make("dt", {}, name), make("dd", {}, value)]));
}
