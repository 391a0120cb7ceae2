// Numbers as people read them, and elements made of text that stays text.

// As `robomore.runs.words.number`: so many significant digits, thousands apart.
export function number(value, digits = 4) {
  if (value === null || value === undefined) return "-";
  const size = Math.abs(value);
  if (size && (size < 1e-3 || size >= 1e7)) return value.toExponential(digits - 1);
  return value.toLocaleString("en-US", { maximumSignificantDigits: Math.max(digits,
    size >= 1 ? Math.floor(Math.log10(size)) + 1 : 0) });
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
