// Tables that sort by a column, and the long table of all evaluations, a page at a time.

import { make, number } from "./words.js";

const PAGE = 25; // rows

// How the tables of a live page are sorted, by the part of the page that is renewed again and again.
const chosen = new Map();

// Lets the headings of a table with the class `sortable` sort it. Cells may carry `data-value`.
export function wireTables(root = document) {
  for (const table of root.querySelectorAll("table.sortable")) {
    const part = table.closest("[data-part-of]")?.dataset.partOf;
    const headings = [...table.querySelectorAll("thead th")];
    if (headings.some((heading) => heading.querySelector("button"))) continue;
    const sort = (column, upwards) => {
      mark(headings, headings[column], upwards);
      if (part) chosen.set(part, [column, upwards]);
      const rows = [...table.tBodies[0].rows];
      rows.sort((one, other) => compared(value(one.cells[column]), value(other.cells[column]),
        upwards));
      table.tBodies[0].append(...rows);
    };
    headings.forEach((heading, column) => {
      const button = make("button", { type: "button" }, ...heading.childNodes);
      heading.replaceChildren(button);
      button.onclick = () => sort(column, heading.getAttribute("aria-sort") === "descending");
    });
    if (chosen.has(part)) sort(...chosen.get(part));
  }
}

function value(cell) {
  if (cell.dataset.value === undefined) return cell.textContent.trim();
  return cell.dataset.value === "" ? null : Number(cell.dataset.value);
}

function mark(headings, heading, upwards) {
  headings.forEach((other) => other.removeAttribute("aria-sort"));
  heading.setAttribute("aria-sort", upwards ? "ascending" : "descending");
}

// What is missing stands last, whichever way.
function compared(one, other, upwards) {
  const missing = (found) => found === null || found === undefined || Number.isNaN(found);
  if (missing(one) || missing(other)) return missing(one) - missing(other);
  const order = typeof one === "string" ? String(one).localeCompare(String(other), undefined,
    { numeric: true }) : one - other;
  return upwards ? order : -order;
}

export class Evaluations {
  constructor(page, element, open) {
    Object.assign(this, { page, element, open, first: 0, upwards: false });
    const text = (get) => ({ get, say: (one) => get(one) });
    const figure = (get) => ({ get, say: (one) => number(get(one)) });
    this.columns = {
      place: text((one) => one.places[0]),
      status: text((one) => one.status),
      [`efficiency ${page.perVolume}`]: figure((one) => one.efficiency),
      [`fitness ${page.fitnessUnit}`.trim()]: figure((one) => one.fitness),
      "volume m³": figure((one) => one.volume),
      "energy J": figure((one) => one.energy),
      steps: { get: (one) => one.steps, say: (one) => one.steps.toLocaleString("en-US") },
      replay: text((one) => (one.replay ? "moves" : "")),
    };
    this.sorted = [...page.evaluations];
    this.headings = Object.keys(this.columns).map((name) => {
      const button = make("button", { type: "button" }, name);
      button.onclick = () => this.sort(name);
      return make("th", { scope: "col" }, button);
    });
    this.body = make("tbody");
    this.filter = make("input", { type: "search", "aria-label": "Filter the evaluations",
      placeholder: "Filter: stage, status, idea, key …" });
    this.filter.oninput = () => this.show(0);
    this.before = make("button", { type: "button" }, "Back");
    this.after = make("button", { type: "button" }, "Next");
    this.before.onclick = () => this.show(this.first - PAGE);
    this.after.onclick = () => this.show(this.first + PAGE);
    this.said = make("span", { class: "soft", role: "status" });
    element.replaceChildren(make("div", { class: "bar" }, this.filter, this.before, this.after,
      this.said), make("div", { class: "wide", tabindex: "0" }, make("table", { class: "all" },
      make("thead", {}, make("tr", {}, ...this.headings)), this.body)));
    this.show(0);
  }

  sort(name) {
    this.upwards = name === this.by && !this.upwards;
    this.by = name;
    const { get } = this.columns[name];
    this.sorted.sort((one, other) => compared(get(one), get(other), this.upwards));
    mark(this.headings, this.headings[Object.keys(this.columns).indexOf(name)], this.upwards);
    this.show(0);
  }

  show(first) {
    const wanted = this.filter.value.trim().toLowerCase();
    const found = wanted ? this.sorted.filter((one) => [...one.places, one.status, one.key,
      ...one.ideas].join(" ").toLowerCase().includes(wanted)) : this.sorted;
    this.first = Math.max(0, Math.min(first, Math.floor(Math.max(0, found.length - 1) / PAGE)
      * PAGE));
    const rows = found.slice(this.first, this.first + PAGE);
    this.before.disabled = !this.first;
    this.after.disabled = this.first + PAGE >= found.length;
    this.said.textContent = found.length
      ? `${this.first + 1}–${this.first + rows.length} of ${found.length}` : "none";
    this.body.replaceChildren(...rows.map((one) => {
      const cells = Object.values(this.columns).map(({ say }) => make("td", {}, say(one)));
      const button = make("button", { type: "button", class: "link" }, cells[0].textContent);
      button.onclick = () => this.open(one.key);
      cells[0].replaceChildren(button);
      return make("tr", { class: one.status === "ok" ? null : "failed" }, ...cells);
    }));
  }
}
