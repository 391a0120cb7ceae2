// All designs at once: a line for each, an axis for each parameter and for what was measured.

import { make, number } from "./words.js";

const [AXIS, TOP, HEIGHT, ASIDE] = [84, 46, 300, 42]; // pixels
const ANCHORS = [[38, 30, 74], [49, 94, 140], [41, 150, 130], [145, 196, 76], [252, 226, 92]];

export class Parallel {
  constructor(page, element) {
    this.lines = page.evaluations.filter((one) => one.status === "ok" && !one.cut);
    const measured = [["fitness", page.fitnessUnit], ["volume", "m³"],
      ["efficiency", page.perVolume]];
    this.axes = [
      ...page.parameters.map((parameter, n) => ({ name: parameter.name, unit: parameter.unit,
        low: parameter.low, high: parameter.high,
        of: (one) => page.morphologies[one.m][n] })),
      ...measured.map(([name, unit]) => ({ name, unit, of: (one) => one[name] })),
    ];
    for (const axis of this.axes) {
      const values = this.lines.map(axis.of);
      axis.low ??= Math.min(...values);
      axis.high ??= Math.max(...values);
      if (axis.low === axis.high) axis.high = axis.low + 1;
    }
    this.page = page;
    // The better the design, the later it is drawn.
    this.lines.sort((one, other) => one.score - other.score);
    this.canvas = make("canvas", { role: "img", "aria-label": `Parallel coordinates of `
      + `${this.lines.length} designs. The table of all evaluations holds the same numbers.` });
    this.said = make("p", { class: "said soft" }, Parallel.asks);
    element.replaceChildren(make("div", { class: "wide", tabindex: "0" }, this.canvas), this.said);
    this.canvas.onpointerdown = (event) => this.press(event);
    this.canvas.onpointermove = (event) => this.drag(event);
    this.canvas.onpointerup = () => this.release();
    this.canvas.onpointercancel = () => this.release();
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.draw());
    new ResizeObserver(() => this.draw()).observe(element);
  }

  static asks = "Bright lines are better. Drag along an axis to keep only what passes there; "
    + "tap the axis to let all through again.";

  x(n) {
    return ASIDE + (n * (this.width - 2 * ASIDE)) / (this.axes.length - 1);
  }

  y(axis, value) {
    const share = (value - axis.low) / (axis.high - axis.low);
    return TOP + HEIGHT * (1 - Math.min(1, Math.max(0, share)));
  }

  passes(one) {
    return this.axes.every((axis) => {
      if (!axis.range) return true;
      const y = this.y(axis, axis.of(one));
      return y >= axis.range[0] && y <= axis.range[1];
    });
  }

  draw() {
    const parent = this.canvas.parentElement;
    this.width = Math.max(parent.clientWidth, this.axes.length * AXIS);
    const [height, ratio] = [TOP + HEIGHT + 26, Math.min(devicePixelRatio, 2)];
    Object.assign(this.canvas, { width: this.width * ratio, height: height * ratio });
    Object.assign(this.canvas.style, { width: `${this.width}px`, height: `${height}px` });
    const style = getComputedStyle(document.body);
    const colour = (name) => style.getPropertyValue(name).trim();
    const pen = this.canvas.getContext("2d");
    pen.scale(ratio, ratio);
    const shown = this.lines.filter((one) => this.passes(one));
    const width = this.lines.length > 400 ? 0.7 : 1.2;
    const kept = new Set(shown);
    this.lines.forEach((one, rank) => {
      if (kept.has(one)) return;
      this.line(pen, one, colour("--line"), width, 0.35);
    });
    shown.forEach((one) => {
      const rank = this.lines.indexOf(one) / Math.max(1, this.lines.length - 1);
      this.line(pen, one, mixed(rank), width, 0.25 + 0.65 * rank);
    });
    const { champion, reference } = this.page;
    for (const [key, name] of [[reference, "--reference"], [champion, "--champion"]]) {
      const one = this.page.byKey.get(key);
      if (one) this.line(pen, one, colour(name), 2.6, 1);
    }
    pen.globalAlpha = 1;
    this.axes.forEach((axis, n) => this.label(pen, axis, n, colour));
    const count = this.axes.some((axis) => axis.range) ? `${shown.length} of ${this.lines.length} `
      + "designs pass. " : "";
    this.said.textContent = count + Parallel.asks;
  }

  line(pen, one, colour, width, alpha) {
    pen.beginPath();
    this.axes.forEach((axis, n) => pen[n ? "lineTo" : "moveTo"](this.x(n),
      this.y(axis, axis.of(one))));
    Object.assign(pen, { strokeStyle: colour, lineWidth: width, globalAlpha: alpha });
    pen.stroke();
  }

  label(pen, axis, n, colour) {
    const x = this.x(n);
    pen.fillStyle = colour("--soft");
    pen.fillRect(x - 0.5, TOP, 1, HEIGHT);
    Object.assign(pen, { font: "11px system-ui, sans-serif", textAlign: "center" });
    pen.fillText(number(axis.high, 3), x, TOP - 6);
    pen.fillText(number(axis.low, 3), x, TOP + HEIGHT + 15);
    pen.fillStyle = colour("--ink");
    // Names alternate between two lines, so that they do not run into each other.
    pen.fillText(axis.name.length > 15 ? `${axis.name.slice(0, 14)}…` : axis.name, x,
      n % 2 ? 12 : 26);
    if (axis.range) {
      pen.fillStyle = colour("--champion");
      pen.globalAlpha = 0.35;
      pen.fillRect(x - 6, axis.range[0], 12, axis.range[1] - axis.range[0]);
      pen.globalAlpha = 1;
    }
  }

  press(event) {
    const { left, top } = this.canvas.getBoundingClientRect();
    const [x, y] = [event.clientX - left, event.clientY - top];
    const near = this.axes.findIndex((_, n) => Math.abs(this.x(n) - x) < 14);
    if (near < 0) return;
    this.held = { axis: this.axes[near], y, top };
    this.canvas.setPointerCapture(event.pointerId);
  }

  drag(event) {
    if (!this.held) return;
    const { axis, y, top } = this.held;
    const now = Math.min(TOP + HEIGHT, Math.max(TOP, event.clientY - top));
    axis.range = Math.abs(now - y) > 4 ? [Math.min(y, now), Math.max(y, now)] : null;
    this.draw();
  }

  release() {
    if (!this.held) return;
    if (!this.held.axis.range) this.draw();
    this.held = null;
  }
}

function mixed(share) {
  const at = share * (ANCHORS.length - 1);
  const first = Math.min(Math.floor(at), ANCHORS.length - 2);
  const part = ANCHORS[first].map((value, n) =>
    Math.round(value + (ANCHORS[first + 1][n] - value) * (at - first)));
  return `rgb(${part.join(" ")})`;
}
