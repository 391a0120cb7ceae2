// Brings a page to life: the report of a run, a comparison, or the live page.

import { embedded } from "./data.js";
import { DesignWindow } from "./design.js";
import { Episode } from "./episode.js";
import { wireFigures } from "./figures.js";
import { drawLineage } from "./lineage.js";
import { follow } from "./live.js";
import { Parallel } from "./parallel.js";
import { Player } from "./player.js";
import { Evaluations, wireTables } from "./tables.js";

async function players() {
  for (const element of document.querySelectorAll(".player[data-replays]")) {
    const names = JSON.parse(element.dataset.replays);
    const shown = (await Promise.all(names.map(async ([key, name]) => [name, await embedded(key)])))
      .filter(([, data]) => data);
    if (shown.length) {
      new Player(element, shown.map(([, data]) => new Episode(data)), shown.map(([name]) => name));
    }
  }
}

async function report() {
  const page = await embedded("page");
  if (!page) return;
  page.byKey = new Map(page.evaluations.map((one) => [one.key, one]));
  let shown = null;
  const open = (key) => (shown ??= new DesignWindow(page)).open(key);
  const place = (name) => document.querySelector(`[data-place="${name}"]`);
  if (place("lineage") && !drawLineage(page, place("lineage"))) {
    place("lineage").closest("section").hidden = true;
  }
  if (place("parallel")) new Parallel(page, place("parallel"));
  if (place("evaluations")) new Evaluations(page, place("evaluations"), open);
  wireFigures(open);
  document.addEventListener("click", (event) => {
    const button = event.target.closest?.("button[data-key]");
    if (button) open(button.dataset.key);
  });
  if (page.byKey.has(location.hash.slice(1))) open(location.hash.slice(1));
}

async function begin() {
  document.documentElement.classList.add("scripted");
  wireTables();
  const live = document.querySelector("[data-live]");
  if (live) {
    follow(live);
  } else {
    await Promise.all([players(), report()]);
    if (!document.querySelector('script[data-pack="page"]')) wireFigures(() => {});
  }
  document.documentElement.dataset.ready = "";
}

begin();
