// A small line chart with axes.

import { drawn, make } from "./words.js";

const [WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM] = [360, 190, 52, 10, 10, 34];

// `lines`: [{name, kind, points: [[x, y]]}].
export function chart(lines, xName, yName) {
  const points = lines.flatMap((line) => line.points);
  if (!points.length) return null;
  const x = axis([0, ...points.map(([value]) => value)], LEFT, WIDTH - RIGHT);
  const y = axis(points.map(([, value]) => value), HEIGHT - BOTTOM, TOP);
  const svg = drawn("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, class: "figure", role: "img",
    "aria-label": `${yName} over ${xName}: ${lines.map((line) => line.name).join(", ")}` });
  for (const value of y.ticks) {
    svg.append(drawn("line", { x1: LEFT, x2: WIDTH - RIGHT, y1: y.at(value), y2: y.at(value),
      class: "grid" }), drawn("text", { x: LEFT - 5, y: y.at(value) + 4, class: "tick",
      "text-anchor": "end" }, short(value)));
  }
  for (const value of x.ticks) {
    svg.append(drawn("text", { x: x.at(value), y: HEIGHT - BOTTOM + 15, class: "tick",
      "text-anchor": "middle" }, short(value)));
  }
  svg.append(drawn("text", { x: (LEFT + WIDTH) / 2, y: HEIGHT - 3, "text-anchor": "middle" },
    xName));
  for (const { kind, points: line } of lines) {
    const path = line.map(([a, b]) => `${x.at(a).toFixed(1)} ${y.at(b).toFixed(1)}`).join("L");
    svg.append(drawn("path", { d: `M${path}`, class: `curve ${kind}` }));
  }
  const legend = make("figcaption", { class: "legend" }, ...lines.map(({ name, kind }) =>
    make("span", {}, make("i", { class: kind }), name)));
  return make("figure", {}, make("h4", {}, yName), svg, lines.length > 1 ? legend : null);
}

function axis(values, start, end) {
  let [low, high] = [Math.min(...values), Math.max(...values)];
  if (low === high) [low, high] = [low - 1, high + 1];
  const step = nice((high - low) / 4);
  const ticks = [];
  for (let n = Math.ceil(low / step - 1e-9); n <= high / step + 1e-9; n++) ticks.push(n * step);
  const air = 0.04 * (high - low);
  const at = (value) => start + ((value - low + air) / (high - low + 2 * air)) * (end - start);
  return { at, ticks };
}

function nice(least) {
  const power = 10 ** Math.floor(Math.log10(least));
  return [1, 2, 5, 10].find((step) => step * power >= least * (1 - 1e-9)) * power;
}

function short(value) {
  for (const [unit, letter] of [[1e6, "M"], [1e3, "k"]]) {
    if (Math.abs(value) >= unit) return `${Number((value / unit).toPrecision(4))}${letter}`;
  }
  return String(Number(value.toPrecision(6)));
}
