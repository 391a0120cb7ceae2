// Robots on a canvas: each in a window of its own that follows it, or all in one picture.

import {
  Color, DirectionalLight, HemisphereLight, PCFShadowMap, PerspectiveCamera, Scene, Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { Ground } from "./ground.js";
import { Contacts, Torques, Trail } from "./overlays.js";
import { Robot } from "./robot.js";

const EXTRAS = { contacts: Contacts, torques: Torques, trail: Trail };

export class Stage {
  // Throws where the browser has no WebGL.
  constructor(canvas, episodes) {
    this.renderer = rendererIn(canvas);
    canvas = this.canvas = this.renderer.domElement;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = PCFShadowMap;
    this.renderer.setScissorTest(true);
    this.dark = matchMedia("(prefers-color-scheme: dark)").matches;
    this.reach = Math.max(...episodes.map((episode) => new Robot(episode).size));
    this.together = false;
    this.follow = true;
    this.seconds = 0;
    this.views = episodes.map((episode) => this.view(episode));
    this.camera = new PerspectiveCamera(32, 1, 0.02 * this.reach, 400 * this.reach);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enablePan = false;
    this.controls.minDistance = 1.2 * this.reach;
    this.controls.maxDistance = 60 * this.reach;
    this.controls.enableDamping = false;
    this.controls.addEventListener("change", () => this.draw());
    this.look();
  }

  // Returns a scene with one robot in it, and with the others too in case they run together.
  view(episode) {
    const scene = new Scene();
    scene.background = new Color(this.dark ? "#191b20" : "#f3f1ec");
    const sun = new DirectionalLight("#ffffff", 2.1);
    sun.castShadow = true;
    sun.shadow.mapSize.set(1024, 1024);
    const half = 3 * this.reach;
    Object.assign(sun.shadow.camera, { left: -half, right: half, top: half, bottom: -half,
      near: 0.1, far: 20 * this.reach });
    const robot = new Robot(episode);
    const ground = new Ground(episode.data.ground, nice(this.reach / 2), this.dark);
    scene.add(new HemisphereLight("#ffffff", this.dark ? "#4a4d55" : "#b8b2a4", 1.5));
    scene.add(sun, sun.target, ground, robot);
    return { scene, sun, robot, ground, episode, extras: {}, last: new Vector3() };
  }

  // Puts the camera where this robot shows most.
  look() {
    const [view] = this.views;
    const towards = new Vector3(...view.episode.data.view.towards);
    // Straight from the side one sees no ground.
    if (Math.abs(towards.z) < 0.9) towards.z += 0.28;
    towards.x += 0.25;
    if (Math.abs(towards.z) > 0.9) towards.y -= 0.5;
    const narrow = Math.min(1, this.aspect());
    const away = (3.9 * this.reach) / narrow ** 0.8;
    this.target = view.episode.way(this.seconds / view.episode.data.dt);
    this.controls.target.copy(this.target);
    this.camera.position.copy(this.target).addScaledVector(towards.normalize(), away);
    this.controls.update();
  }

  aspect() {
    const { width, height } = this.canvas.getBoundingClientRect();
    const columns = this.together ? 1 : this.columns(width);
    const rows = this.together ? 1 : Math.ceil(this.views.length / columns);
    return (width / columns) / Math.max(1, height / rows);
  }

  columns(width) {
    return Math.min(this.views.length, width > 560 ? 4 : this.views.length > 4 ? 2 : 1);
  }

  // Shows all robots as they are `seconds` after their starts.
  show(seconds) {
    this.seconds = seconds;
    for (const view of this.views) view.robot.pose(seconds / view.episode.data.dt);
    this.draw();
  }

  toggle(name, on) {
    for (const view of this.views) {
      view.extras[name] ??= new EXTRAS[name](view.robot);
      if (on) view.scene.add(view.extras[name]);
      else view.scene.remove(view.extras[name]);
    }
    this.draw();
  }

  // All robots in the first one's scene, in lanes, or each in its own.
  join(together) {
    this.together = together;
    const [first] = this.views;
    this.views.forEach((view, lane) => {
      for (const one of [view.robot, ...Object.values(view.extras)]) {
        if (!one.parent) continue;
        (together ? first : view).scene.add(one);
        one.position.y = together ? lane * 1.6 * this.reach : 0;
      }
    });
    this.look();
    this.draw();
  }

  draw() {
    const { width, height } = this.canvas.getBoundingClientRect();
    if (!width || !height || this.drawing) return;
    this.drawing = true; // moving the camera asks for another picture
    const ratio = this.renderer.getPixelRatio();
    if (this.canvas.width !== Math.floor(width * ratio)
      || this.canvas.height !== Math.floor(height * ratio)) {
      this.renderer.setSize(width, height, false);
    }
    const shown = this.together ? [this.leader()] : this.views;
    const columns = this.together ? 1 : this.columns(width);
    const rows = Math.ceil(shown.length / columns);
    const [wide, high] = [width / columns, height / rows];
    const offset = this.camera.position.clone().sub(this.controls.target);
    this.camera.aspect = wide / high;
    this.camera.updateProjectionMatrix();
    this.thickened = 0;
    shown.forEach((view, n) => {
      const [x, y] = [(n % columns) * wide, height - (Math.floor(n / columns) + 1) * high];
      this.renderer.setViewport(x, y, wide, high);
      this.renderer.setScissor(x, y, wide, high);
      const at = this.follow ? view.episode.way(this.seconds / view.episode.data.dt) : view.last;
      // The picture does not bob with every step.
      at.z = this.follow ? (view.calm = smooth(view, at.z)) : at.z;
      view.last = at;
      if (this.together) at.y += 0.8 * this.reach * (this.views.length - 1);
      this.controls.target.copy(at);
      this.camera.position.copy(at).add(offset);
      this.camera.lookAt(at);
      const scene = this.together ? this.views[0] : view;
      scene.sun.position.copy(at).add(new Vector3(-2, -2.5, 6).multiplyScalar(this.reach));
      scene.sun.target.position.copy(at);
      scene.ground.follow(at);
      const pixels = high / (2 * offset.length() * Math.tan((this.camera.fov * Math.PI) / 360));
      for (const one of this.together ? this.views : [view]) {
        this.thickened += one.robot.thicken(pixels);
        for (const extra of Object.values(one.extras)) {
          extra.update(Math.min(this.seconds / one.episode.data.dt, one.episode.frames - 1));
        }
      }
      this.renderer.render(scene.scene, this.camera);
    });
    this.drawing = false;
  }

  // The robot that is ahead.
  leader() {
    const ahead = (view) => view.episode.way(this.seconds / view.episode.data.dt).x;
    return this.views.reduce((best, view) => (ahead(view) > ahead(best) ? view : best));
  }

  dispose() {
    this.controls.dispose();
    for (const view of this.views) view.robot.dispose();
    idle.push(this.renderer);
  }
}

// Programs of the graphics card are slow to make, so a renderer that is done with is used again.
const idle = [];

function rendererIn(canvas) {
  const known = idle.pop();
  if (!known) return new WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
  canvas.replaceWith(known.domElement);
  return known;
}

function smooth(view, height) {
  const before = view.calm ?? height;
  return before + 0.08 * (height - before);
}

// The longest of 1, 2, 5, 10, … that is no longer than `most`.
function nice(most) {
  const power = 10 ** Math.floor(Math.log10(most));
  return [5, 2, 1].find((step) => step * power <= most * (1 + 1e-9)) * power;
}
