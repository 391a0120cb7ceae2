// The live page: what the server says changed is fetched, and put in the place of what was there.

import { unpack } from "./data.js";
import { Episode } from "./episode.js";
import { wireFigures } from "./figures.js";
import { Player } from "./player.js";
import { wireTables } from "./tables.js";

let player = null;
let moving = "";

// `element` holds what is renewed, and the address that tells of changes (`data-live`).
export function follow(element) {
  const state = document.querySelector("[data-connection]");
  renewed(element);
  const source = new EventSource(element.dataset.live);
  source.onopen = () => (state.textContent = "live");
  source.onerror = () => (state.textContent = "not connected; trying again …");
  source.addEventListener("changed", () => renew(element, element.dataset.part));
  // How far it is changes every second; then nothing else is asked for.
  source.addEventListener("progress", () =>
    renew(element, element.dataset.progress ?? element.dataset.part));
}

async function renew(element, address) {
  const answer = await fetch(address).catch(() => null);
  if (!answer?.ok) return;
  const chosen = document.activeElement?.id;
  const next = new DOMParser().parseFromString(await answer.text(), "text/html");
  for (const old of element.querySelectorAll("[data-part-of]")) {
    const fresh = next.querySelector(`[data-part-of="${CSS.escape(old.dataset.partOf)}"]`);
    if (fresh && fresh.outerHTML !== old.outerHTML) old.replaceWith(document.adoptNode(fresh));
  }
  if (chosen) document.getElementById(chosen)?.focus({ preventScroll: true });
  renewed(element);
}

// Says why nothing moves, as long as nothing does.
function say(words) {
  const waiting = document.querySelector(".player.live .waiting");
  if (waiting) waiting.textContent = words;
}

// Wires what is new, and shows another robot where another one is the best now.
async function renewed(element) {
  wireTables(element);
  // The whole report opens with the design that was chosen.
  wireFigures((key) => {
    const report = element.querySelector('a[href^="/run/report"]');
    if (report) location.href = `${report.href}#${key}`;
  }, element);
  const wanted = element.querySelector("[data-moving]");
  if (!wanted || !wanted.dataset.moving || wanted.dataset.moving === moving) return;
  moving = wanted.dataset.moving;
  const shown = JSON.parse(moving);
  // The first to look at a design waits while its episode is simulated.
  say(shown.length ? "The robot is being recorded …" : "No policy has been kept yet.");
  if (!shown.length) return;
  const found = (await Promise.all(shown.map(async ([address, name]) => {
    const answer = await fetch(address).catch(() => null);
    return answer?.ok ? [name, await unpack(await answer.arrayBuffer())] : null;
  }))).filter(Boolean);
  if (moving !== wanted.dataset.moving) return;
  if (!found.length) return say("There is no policy that can be shown.");
  player?.dispose();
  const place = document.querySelector(".player.live");
  const fresh = document.querySelector("template#player").content.cloneNode(true).firstElementChild;
  fresh.classList.add("live");
  place.replaceWith(fresh);
  player = new Player(fresh, found.map(([, data]) => new Episode(data)),
    found.map(([name]) => name));
}
