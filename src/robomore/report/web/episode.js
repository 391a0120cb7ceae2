// An episode: where every body is at any time, between two frames too.

import { Quaternion, Vector3 } from "three";
import { summed } from "./data.js";

export class Episode {
  constructor(data) {
    this.data = data;
    this.frames = data.frames;
    this.seconds = (data.frames - 1) * data.dt;
    this.bodies = data.turns.length / (4 * data.frames);
    this.root = summed(data.root, data.frames);
    this.positions = summed(data.positions, data.frames);
    this.turns = summed(data.turns, data.frames);
    this.contactStart = new Uint32Array(data.frames + 1);
    data.contacts.forEach((count, frame) => {
      this.contactStart[frame + 1] = this.contactStart[frame] + count;
    });
  }

  // Sets `position` to where the root is at a frame, which need not be whole.
  way(frame, position = new Vector3()) {
    const [first, second, share] = this.between(frame);
    const at = (axis, n) => this.root[axis * this.frames + n] * this.data.way;
    const mixed = [0, 1, 2].map((axis) => at(axis, first) * (1 - share) + at(axis, second) * share);
    return position.set(...mixed);
  }

  // Sets the position and turn of a body at a frame.
  pose(body, frame, position, turn) {
    const [first, second, share] = this.between(frame);
    const within = (axis, n) => this.positions[(body * 3 + axis) * this.frames + n];
    const mixed = [0, 1, 2].map((axis) =>
      (within(axis, first) * (1 - share) + within(axis, second) * share) * this.data.reach);
    this.way(frame, position);
    position.x += mixed[0];
    position.y += mixed[1];
    position.z += mixed[2];
    turn.copy(this.turn(body, first)).slerp(this.turn(body, second), share);
  }

  turn(body, frame) {
    const [w, x, y, z] = [0, 1, 2, 3].map((n) => this.turns[(body * 4 + n) * this.frames + frame]);
    return new Quaternion(x, y, z, w).normalize();
  }

  // Returns [{position, force}] of a frame, the force as a share of the robot's weight.
  contacts(frame) {
    const at = Math.round(frame);
    const { contact_points: points, contact_forces: forces } = this.data;
    const root = this.way(at);
    const found = [];
    for (let n = this.contactStart[at]; n < this.contactStart[at + 1]; n++) {
      const vector = (array, scale) =>
        new Vector3(array[3 * n], array[3 * n + 1], array[3 * n + 2]).multiplyScalar(scale);
      found.push({
        position: vector(points, this.data.contact_spread).add(root),
        force: vector(forces, this.data.most_force / Math.max(this.data.weight, 1e-9)),
      });
    }
    return found;
  }

  // Returns a motor's torque at a frame, from -1 to 1 of the largest in the episode.
  torque(motor, frame) {
    return this.data.torques[motor * this.frames + Math.round(frame)] / 127;
  }

  // Returns the forward speed around a frame, in m/s.
  speed(frame) {
    const half = Math.max(1, Math.round(0.25 / this.data.dt));
    const first = Math.max(0, Math.round(frame) - half);
    const second = Math.min(this.frames - 1, first + 2 * half);
    if (second <= first) return 0;
    const moved = (this.root[second] - this.root[first]) * this.data.way;
    return moved / ((second - first) * this.data.dt);
  }

  between(frame) {
    const held = Math.min(Math.max(frame, 0), this.frames - 1);
    const first = Math.floor(held);
    return [first, Math.min(first + 1, this.frames - 1), held - first];
  }
}

// The corners of a box among the capsules of `still`, none of a capsule. The corner n lies on the
// side of the first axis that bit 4 of n tells, of the second that bit 2 tells, of the third bit 1.
export function corners([ax, ay, az, bx, by, bz, , , ...box]) {
  if (!box.length) return [];
  const [half, [w, x, y, z]] = [box.slice(0, 3), box.slice(3)];
  const turn = new Quaternion(x, y, z, w);
  const middle = new Vector3(ax + bx, ay + by, az + bz).multiplyScalar(0.5);
  return [0, 1, 2, 3, 4, 5, 6, 7].map((n) => new Vector3(
    ...half.map((size, axis) => (n & (4 >> axis) ? size : -size)),
  ).applyQuaternion(turn).add(middle).toArray());
}

// An episode of one frame: a robot that stands, made of capsules [x, y, z, x, y, z, radius, depth],
// and boxes, which have seven numbers more: half of each side, and a quaternion (w, x, y, z).
export function still(capsules) {
  const geoms = capsules.map(([ax, ay, az, bx, by, bz, radius, depth, ...box]) => {
    const a = new Vector3(ax, ay, az);
    const b = new Vector3(bx, by, bz);
    if (box.length) {
      return { kind: "box", size: box.slice(0, 3), body: 0, depth,
        pos: a.add(b).multiplyScalar(0.5).toArray(), quat: box.slice(3) };
    }
    const along = b.clone().sub(a);
    const turn = new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1),
      along.lengthSq() ? along.clone().normalize() : new Vector3(0, 0, 1));
    return { kind: "capsule", size: [radius, along.length() / 2], body: 0, depth,
      pos: a.add(b).multiplyScalar(0.5).toArray(), quat: [turn.w, turn.x, turn.y, turn.z] };
  });
  return new Episode({
    title: "", still: true, dt: 1, frames: 1, geoms, meshes: [], ground: { planes: [0] },
    view: { towards: [0, -1, 0], up: [0, 0, 1] }, way: 1, reach: 1,
    root: new Int32Array(3), positions: new Int16Array(3), turns: new Int16Array([30000, 0, 0, 0]),
    actuators: [], torques: new Int8Array(0), most_torque: 1, contacts: new Uint8Array(1),
    contact_points: new Int16Array(0), contact_spread: 1, contact_forces: new Int16Array(0),
    most_force: 1, weight: 1,
  });
}
