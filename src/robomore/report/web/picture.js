// A standing robot as a small picture: a capsule seen along parallel rays is a thick line, and a
// box has up to three sides.

import { colour } from "./robot.js";
import { corners } from "./episode.js";
import { drawn } from "./words.js";

const THINNEST = 1.6; // pixels

// `capsules`: as `still` takes them; `view`: {right, up, towards} in the world.
export function picture(capsules, view, name, width = 240, height = 170) {
  const flat = (x, y, z) => [view.right, view.up, view.towards]
    .map(([a, b, c]) => a * x + b * y + c * z);
  const strokes = capsules.map((capsule) => {
    const [ax, ay, az, bx, by, bz, radius, depth] = capsule;
    const [a, b] = [flat(ax, ay, az), flat(bx, by, bz)];
    const box = corners(capsule).map((corner) => flat(...corner));
    return { a, b, radius, depth, box, near: a[2] + b[2] };
  }).sort((one, other) => one.near - other.near);
  const ends = (axis, sign) => strokes.flatMap(({ a, b, radius, box }) => box.length
    ? box.map((corner) => corner[axis])
    : [a[axis] + sign * radius, b[axis] + sign * radius]);
  const [left, right] = [Math.min(...ends(0, -1)), Math.max(...ends(0, 1))];
  const [low, high] = [Math.min(...ends(1, -1)), Math.max(...ends(1, 1))];
  const scale = 0.88 * Math.min(width / (right - left), height / (high - low));
  const at = ([x, y]) => [width / 2 + (x - (left + right) / 2) * scale,
    height / 2 - (y - (low + high) / 2) * scale];
  const lines = strokes.flatMap(({ a, b, radius, depth, box }) => {
    if (box.length) return sides(box).map((side) => drawn("polygon", { points: side.map(at).join(" "),
      fill: colour(depth), stroke: "#0005", "stroke-width": 0.8, "stroke-linejoin": "round" }));
    const [[x1, y1], [x2, y2]] = [at(a), at(b)];
    return drawn("line", { x1, y1, x2: x2 + 0.01, y2, stroke: colour(depth),
      "stroke-width": Math.max(THINNEST, 2 * radius * scale), "stroke-linecap": "round" });
  });
  return drawn("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": name,
    class: "robot" }, ...lines);
}

// The three sides of a box that are seen, of eight corners in the order of `corners`.
function sides(box) {
  return [4, 2, 1].map((bit) => {
    const [one, other] = [4, 2, 1].filter((rest) => rest !== bit);
    const first = box[bit][2] > box[0][2] ? bit : 0; // nearer than the side across
    return [first, first + one, first + one + other, first + other].map((n) => box[n]);
  });
}
