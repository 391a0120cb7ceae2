// The controls of a stage: play, pause, scrub, speed, follow, and what is shown on demand.

import { Vector3 } from "three";
import { Stage } from "./stage.js";
import { number, tenths } from "./words.js";

const LOOP_PAUSE = 1; // seconds in the last pose before it begins again
const calm = matchMedia("(prefers-reduced-motion: reduce)");

export class Player {
  // `element` holds the markup of player.html; `names` stand over the windows.
  constructor(element, episodes, names) {
    this.element = element;
    this.episodes = episodes;
    this.canvas = element.querySelector("canvas");
    this.labels = element.querySelector(".names");
    this.length = Math.max(...episodes.map((episode) => episode.seconds));
    this.seconds = 0;
    this.speed = 1;
    this.playing = false;
    this.names = names;
    try {
      this.stage = new Stage(this.canvas, episodes);
      this.canvas = this.stage.canvas;
    } catch (error) {
      this.fail("This browser shows no 3D (WebGL is off), so the robots stand still here.");
      return;
    }
    this.wire();
    this.label();
    this.show();
    element.dataset.ready = "";
    if (this.length && !calm.matches) this.play();
  }

  fail(said) {
    this.element.dataset.failed = "";
    this.element.querySelector(".state").textContent = said;
  }

  wire() {
    const field = (name) => this.element.querySelector(`[name="${name}"]`);
    this.button = field("play");
    this.slider = field("time");
    this.clock = this.element.querySelector("output");
    this.slider.max = this.length;
    this.slider.step = "any";
    for (const control of this.element.querySelectorAll("button, input, select")) {
      control.disabled = false;
    }
    const still = !this.length;
    this.element.classList.toggle("still", still);
    this.button.onclick = () => (this.playing ? this.pause() : this.play());
    this.slider.oninput = () => {
      this.pause();
      this.seconds = Number(this.slider.value);
      this.show();
    };
    field("speed").onchange = (event) => (this.speed = Number(event.target.value));
    field("follow").onchange = (event) => {
      this.stage.follow = event.target.checked;
      this.stage.draw();
    };
    for (const name of ["contacts", "torques", "trail"]) {
      field(name).onchange = (event) => this.stage.toggle(name, event.target.checked);
    }
    const together = field("together");
    together.closest("label").hidden = this.episodes.length < 2;
    together.onchange = () => {
      this.stage.join(together.checked);
      this.label();
    };
    field("reset").onclick = () => {
      this.stage.look();
      this.show();
    };
    field("picture").onclick = () => this.save();
    this.canvas.tabIndex = 0;
    this.canvas.onkeydown = (event) => this.key(event);
    // Nothing is drawn that nobody sees.
    this.seen = new IntersectionObserver(([entry]) => (this.visible = entry.isIntersecting));
    this.seen.observe(this.canvas);
    this.resized = new ResizeObserver(() => {
      this.label();
      this.stage.draw();
    });
    this.resized.observe(this.canvas);
  }

  play() {
    if (this.seconds >= this.length) this.seconds = 0;
    this.playing = true;
    this.last = performance.now();
    this.button.textContent = "Pause";
    this.tick();
  }

  pause() {
    this.playing = false;
    this.button.textContent = "Play";
    cancelAnimationFrame(this.asked);
  }

  tick() {
    this.asked = requestAnimationFrame((now) => {
      if (!this.playing) return;
      // A frame may have begun before it was asked for.
      const passed = Math.min(0.2, Math.max(0, now - this.last) / 1000) * this.speed;
      this.last = now;
      if (this.visible !== false) {
        this.seconds += passed;
        if (this.seconds > this.length + LOOP_PAUSE * this.speed) this.seconds = 0;
        this.show();
      }
      this.tick();
    });
  }

  show() {
    const seconds = Math.min(this.seconds, this.length);
    this.slider.value = seconds;
    this.clock.textContent = `${seconds.toFixed(1)} s of ${this.length.toFixed(1)} s`;
    this.slider.setAttribute("aria-valuetext", this.clock.textContent);
    this.stage.show(seconds);
    this.episodes.forEach((episode, n) => {
      if (episode.data.still) return;
      const frame = Math.min(seconds / episode.data.dt, episode.frames - 1);
      const way = episode.way(frame).x - episode.way(0).x;
      const over = seconds > episode.seconds + 1e-6;
      this.lines[n].textContent = over && episode.data.fell ? `fell after ${number(way, 3)} m`
        : `${tenths(way)} m · ${tenths(episode.speed(frame))} m/s`;
    });
    this.element.querySelector(".state").textContent = this.stage.thickened
      ? "Parts too thin to be seen are drawn thicker." : "";
  }

  // Puts the names over the windows.
  label() {
    const width = this.canvas.clientWidth;
    const columns = this.stage.together ? 1 : this.stage.columns(width);
    this.labels.style.gridTemplateColumns = `repeat(${columns}, 1fr)`;
    this.labels.classList.toggle("together", this.stage.together);
    this.lines ??= this.names.map(() => document.createElement("span"));
    this.labels.replaceChildren(...this.names.map((name, n) => {
      const box = document.createElement("div");
      const strong = document.createElement("b");
      strong.textContent = name;
      box.append(strong, this.lines[n]);
      return box;
    }));
    this.canvas.setAttribute("aria-label",
      `3D view of ${this.names.join(" and ")}. Drag, or use the arrow keys, to look around; `
      + "plus and minus to come nearer; space to play.");
  }

  key(event) {
    const offset = this.stage.camera.position.clone().sub(this.stage.controls.target);
    const aside = new Vector3(0, 0, 1).cross(offset).normalize();
    const moves = {
      ArrowLeft: () => offset.applyAxisAngle(new Vector3(0, 0, 1), -0.12),
      ArrowRight: () => offset.applyAxisAngle(new Vector3(0, 0, 1), 0.12),
      ArrowUp: () => offset.applyAxisAngle(aside, -0.08),
      ArrowDown: () => offset.applyAxisAngle(aside, 0.08),
      "+": () => offset.multiplyScalar(0.85),
      "-": () => offset.multiplyScalar(1 / 0.85),
      " ": () => this.button.click(),
    };
    if (!moves[event.key]) return;
    event.preventDefault();
    moves[event.key]();
    this.stage.camera.position.copy(this.stage.controls.target).add(offset);
    this.stage.draw();
  }

  save() {
    this.stage.draw();
    const link = document.createElement("a");
    link.download = "robomore.png";
    link.href = this.canvas.toDataURL("image/png");
    link.click();
  }

  dispose() {
    this.playing = false;
    cancelAnimationFrame(this.asked);
    this.seen?.disconnect();
    this.resized?.disconnect();
    this.stage?.dispose();
  }
}
