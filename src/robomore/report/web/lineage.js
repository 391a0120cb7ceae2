// Which design was made from which: a tree from left to right, the champion's way with pictures.

import { picture } from "./picture.js";
import { drawn, number } from "./words.js";

const [STEP, ROW, WIDE, HIGH] = [150, 78, 104, 58];
const MOST = 160; // designs; of more, only those around the champion's way are drawn

export function drawLineage(page, element) {
  const children = new Map();
  const known = page.evaluations.filter((one) => !one.final);
  const keys = new Set(known.map((one) => one.key));
  for (const one of known) {
    if (keys.has(one.parent)) {
      children.set(one.parent, [...(children.get(one.parent) ?? []), one]);
    }
  }
  const way = new Set(page.lineage);
  const large = [...children.values()].flat().length > MOST;
  const below = (one) => (children.get(one.key) ?? [])
    .filter((child) => !large || way.has(child.key) || way.has(one.key));
  const roots = known.filter((one) => !keys.has(one.parent)
    && (way.has(one.key) || (!large && children.has(one.key))));
  let row = 0;
  let depth = 0;
  const nodes = [];
  const seen = new Set(); // a ledger of somebody else's may go round in circles
  const place = (one, level) => {
    if (seen.has(one.key)) return null;
    seen.add(one.key);
    depth = Math.max(depth, level);
    const node = { one, level, children: [], parent: null };
    nodes.push(node);
    for (const child of below(one)) {
      const found = place(child, level + 1);
      if (found) {
        found.parent = node;
        node.children.push(found);
      }
    }
    node.row = node.children.length
      ? (node.children[0].row + node.children.at(-1).row) / 2 : row++;
    return node;
  };
  roots.forEach((one) => place(one, 0));
  if (nodes.length < 2) return false;
  const [width, height] = [(depth + 1) * STEP, row * ROW + 8];
  const svg = drawn("svg", { viewBox: `0 0 ${width} ${height}`, width, height, role: "group",
    class: "figure marked tree", "aria-label": "Which design was made from which" });
  const corner = (node) => [node.level * STEP + 4, node.row * ROW + 4];
  for (const node of nodes.filter(({ parent }) => parent)) {
    const [x, y] = corner(node);
    const [px, py] = corner(node.parent);
    const middle = (px + WIDE + x) / 2;
    const [from, to] = [py + HIGH / 2, y + HIGH / 2];
    svg.append(drawn("path", {
      d: `M${px + WIDE} ${from}C${middle} ${from} ${middle} ${to} ${x} ${to}`,
      class: way.has(node.one.key) ? "edge way" : "edge" }));
  }
  for (const node of nodes) svg.append(mark(page, node.one, corner(node), way));
  element.replaceChildren(svg);
  return true;
}

function mark(page, one, [x, y], way) {
  const well = one.status === "ok";
  const score = well ? number(one.score, 3) : one.status;
  const changed = one.changed ? `, new ${one.changed}` : "";
  const group = drawn("g", { class: `tip node${way.has(one.key) ? " way" : ""}`,
    transform: `translate(${x} ${y})`, role: "button", tabindex: "-1", "data-key": one.key,
    "aria-label": `${one.places[0]}${changed}: ${well ? `${score} ${page.unit}` : score}` });
  group.append(drawn("rect", { width: WIDE, height: HIGH, rx: 6 }));
  const capsules = page.stills[one.m];
  if (capsules) {
    const small = picture(capsules, page.view, "", WIDE - 8, HIGH - 20);
    for (const [name, value] of Object.entries({ x: 4, y: 3, width: WIDE - 8,
      height: HIGH - 20, "aria-hidden": "true" })) small.setAttribute(name, value);
    small.removeAttribute("role");
    group.append(small);
  }
  group.append(drawn("text", { x: WIDE / 2, y: HIGH - 6, "text-anchor": "middle",
    class: well ? "" : "bad" }, score));
  return group;
}
