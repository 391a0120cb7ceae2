// The window that opens one design: robot, numbers, what changed, reward and learning curves.

import { chart } from "./chart.js";
import { embedded } from "./data.js";
import { Episode, still } from "./episode.js";
import { Player } from "./player.js";
import { differenceBlock, sourceBlock } from "./source.js";
import { facts, make, number } from "./words.js";

const COLOURS = 6; // of terms, as in the page's style
const NOTHING = 65535; // of a curve, where nothing was measured

export class DesignWindow {
  constructor(page) {
    this.page = page;
    this.dialog = document.querySelector("dialog#design");
    this.dialog.querySelector("button.close").onclick = () => this.dialog.close();
    this.dialog.onclick = (event) => event.target === this.dialog && this.dialog.close();
    this.dialog.onclose = () => {
      if (this.dialog.open) return; // the next design was opened before this was told
      this.player?.dispose();
      this.player = null;
      history.replaceState(null, "", location.pathname + location.search);
    };
  }

  async open(key) {
    const one = this.page.byKey.get(key);
    if (!one) return;
    this.player?.dispose();
    this.player = null;
    this.shown = key;
    history.replaceState(null, "", `#${key}`);
    this.dialog.querySelector("h2").textContent = one.places[0];
    const body = this.dialog.querySelector(".body");
    body.replaceChildren(this.robot(), this.summary(one), this.changes(one), this.reward(one),
      make("section", { class: "curves" }));
    if (!this.dialog.open) this.dialog.showModal();
    this.dialog.scrollTop = 0;
    await Promise.all([this.move(one), this.curves(one)]);
    this.dialog.dataset.shown = key;
  }

  robot() {
    return document.querySelector("template#player").content.cloneNode(true).firstElementChild;
  }

  async move(one) {
    const data = one.replay ? await embedded(one.key) : null;
    const capsules = this.page.stills[one.m];
    const element = this.dialog.querySelector(".player");
    if (this.shown !== one.key) return;
    if (data) {
      this.player = new Player(element, [new Episode(data)], [one.places[0]]);
    } else if (capsules) {
      const episode = still(capsules);
      episode.data.view = this.page.view;
      this.player = new Player(element, [episode], [one.places[0]]);
      element.querySelector(".state").textContent = one.kept
        ? "At rest: to keep this file small, only the best designs are recorded in motion."
        : "At rest: no trained policy was kept of it.";
    } else {
      element.replaceWith(make("p", { class: "soft" }, this.page.undrawn));
    }
  }

  summary(one) {
    const { unit } = this.page;
    const well = one.status === "ok";
    return make("section", {},
      well ? null : make("p", { class: "bad" }, `${one.status}: ${one.diagnosis}`),
      one.cut ? make("p", { class: "soft" }, "Screening cut its training short.") : null,
      facts([
        [`efficiency ${this.page.perVolume}`, well && number(one.efficiency)],
        [`fitness ${this.page.fitnessUnit}`.trim(), well && number(one.fitness)],
        ["volume m³", one.volume && number(one.volume)],
        ["energy J", one.energy && number(one.energy)],
        [unit ? `objective ${unit}` : "objective", this.page.objective !== "efficiency"
          && one.score !== null && number(one.score)],
        ["control steps", one.steps.toLocaleString("en-US")],
        ["core-seconds", number(one.seconds, 3)],
        ["training seed", one.seed],
        ["idea of the morphology", one.ideas[0]],
        ["idea of the reward", one.ideas[1]],
        ["key", one.key],
        ["also at", one.places.slice(1).join("; ")],
        ["notes", one.notes.join(" ")],
      ]),
      Object.keys(one.behaviour).length ? make("details", {},
        make("summary", {}, "How it moves"),
        facts(Object.entries(one.behaviour).map(([name, value]) =>
          [name.replaceAll("_", " "), number(value)]))) : null);
  }

  // Parameters, and what is new against the parent, or against the reference design.
  changes(one) {
    const parent = this.page.byKey.get(one.parent);
    const mine = this.page.morphologies[one.m];
    const before = parent ? this.page.morphologies[parent.m]
      : this.page.parameters.map((parameter) => parameter.reference);
    const name = parent ? "parent" : "reference";
    const rows = this.page.parameters.map((parameter, n) => {
      const changed = Math.abs(mine[n] - before[n]) > 1e-9;
      const ratio = before[n] ? mine[n] / before[n] : NaN;
      const said = changed && Number.isFinite(ratio) ? `× ${number(ratio, 3)}` : "";
      return make("tr", { class: changed ? "changed" : null },
        make("th", { scope: "row" }, `${parameter.name} ${parameter.unit}`),
        make("td", {}, number(before[n])), make("td", {}, number(mine[n])), make("td", {}, said));
    });
    return make("section", {}, make("h3", {}, parent ? "Against its parent" : "Parameters"),
      parent ? make("p", {}, this.link(parent, `Parent: ${parent.places[0]}`)) : null,
      make("div", { class: "wide", tabindex: "0" }, make("table", {},
        make("thead", {}, make("tr", {}, ...["parameter", name, "this design", "change"]
          .map((text) => make("th", { scope: "col" }, text)))),
        make("tbody", {}, ...rows))));
  }

  link(one, text) {
    const button = make("button", { type: "button", class: "link" }, text);
    button.onclick = () => this.open(one.key);
    return button;
  }

  reward(one) {
    const text = this.page.rewards[one.r];
    const parent = this.page.byKey.get(one.parent);
    const before = parent && this.page.rewards[parent.r];
    const changed = before !== undefined && before !== null && before !== text;
    return make("section", {}, make("h3", {}, "Reward"),
      text === this.page.referenceReward ? make("p", { class: "soft" }, "The reference reward.")
        : null,
      changed ? make("details", { open: true }, make("summary", {}, "Changes against its parent"),
        differenceBlock(before, text)) : null,
      changed ? make("details", {}, make("summary", {}, "The whole text"), sourceBlock(text))
        : sourceBlock(text));
  }

  async curves(one) {
    this.page.curves ??= embedded("curves");
    const curve = (await this.page.curves)?.[one.curve];
    const place = this.dialog.querySelector(".curves");
    if (!curve || this.shown !== one.key) return;
    const line = (name, label, n = 0) => ({
      name: label, kind: `term-${n % COLOURS}`,
      points: points(curve.steps, curve.series[name]),
    });
    const names = Object.keys(curve.series);
    const terms = names.filter((name) => name.startsWith("term/"));
    const charts = [
      [[line("episode_return", "return")], "episode return"],
      [terms.map((name, n) => line(name, name.slice(5), n)), "reward terms, mean of a control step"],
      [[line("episode_length", "length")], "episode length, control steps"],
      ...names.filter((name) => name.startsWith("loss/") || name === "alpha")
        .map((name) => [[line(name, name)], name.replace("loss/", "loss of the ")]),
    ].filter(([lines]) => lines.length && names.length);
    const x = "control steps of training";
    place.replaceChildren(make("h3", {}, "Learning curves"), make("div", { class: "charts" },
      ...charts.map(([lines, name]) => chart(lines.filter(({ points }) => points.length), x, name))
        .filter(Boolean)));
  }
}

function points(steps, series) {
  return [...steps].map((step, i) => [step, series?.at[i] ?? NOTHING])
    .filter(([, at]) => at !== NOTHING)
    .map(([step, at]) => [step, series.low + at * series.step]);
}
