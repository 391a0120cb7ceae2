// A robot as three.js objects: one group for each body, and in it the solids of that body.

import {
  BoxGeometry, BufferAttribute, BufferGeometry, CapsuleGeometry, CylinderGeometry, Group, Mesh,
  MeshStandardMaterial, Quaternion, SphereGeometry, Vector3,
} from "three";

// As in `robomore.rendering.drawing`: the torso first, then by distance from it.
const PALETTE = ["#d9822b", "#3f7fbf", "#4a9e6b", "#8a63b5", "#c2554d", "#6b7f8c"];
const THINNEST = 1.3; // pixels; what is thinner is drawn this thick, or it would not be seen

export class Robot extends Group {
  constructor(episode) {
    super();
    this.episode = episode;
    this.bodies = Array.from({ length: episode.bodies }, () => new Group());
    this.fixed = new Group();
    this.add(this.fixed, ...this.bodies);
    const meshes = episode.data.meshes.map(triangles);
    this.solids = episode.data.geoms.map((geom) => {
      const mesh = new Mesh(meshes[geom.mesh] ?? shape(geom), paint(geom.depth));
      mesh.position.set(...geom.pos);
      const [w, x, y, z] = geom.quat;
      mesh.quaternion.set(x, y, z, w);
      if (geom.kind === "ellipsoid") mesh.scale.set(...geom.size);
      mesh.castShadow = true;
      mesh.userData = { ...geom, whole: mesh.scale.clone() };
      (geom.body < 0 ? this.fixed : this.bodies[geom.body]).add(mesh);
      return mesh;
    });
    this.size = size(this);
  }

  // Moves every body to where it is at a frame.
  pose(frame) {
    this.bodies.forEach((body, n) => this.episode.pose(n, frame, body.position, body.quaternion));
  }

  // Draws thin parts thick enough to be seen; returns how many that are.
  // `pixels`: of a metre at the robot's distance.
  thicken(pixels) {
    let thick = 0;
    for (const mesh of this.solids) {
      const { kind, size: [radius], whole } = mesh.userData;
      if (kind === "mesh" || kind === "box" || kind === "ellipsoid") continue;
      const factor = Math.max(1, THINNEST / (radius * pixels));
      thick += factor > 1;
      const along = kind === "sphere" ? factor : 1;
      mesh.scale.set(whole.x * factor, whole.y * factor, whole.z * along);
    }
    return thick;
  }

  dispose() {
    for (const mesh of this.solids) {
      mesh.geometry.dispose();
    }
  }
}

export function colour(depth) {
  return PALETTE[Math.max(0, Math.min(depth, PALETTE.length) - 1)];
}

const paints = new Map(); // shared by all robots, so that their programs are made once

function paint(depth) {
  const color = colour(depth);
  if (!paints.has(color)) {
    paints.set(color, new MeshStandardMaterial({ color, roughness: 0.55, metalness: 0.05 }));
  }
  return paints.get(color);
}

// MuJoCo's solids stand along z, those of three.js along y.
function shape({ kind, size: [a, b, c] }) {
  switch (kind) {
    case "sphere": return new SphereGeometry(a, 24, 16);
    case "ellipsoid": return new SphereGeometry(1, 24, 16);
    case "box": return new BoxGeometry(2 * a, 2 * b, 2 * c);
    case "cylinder": return new CylinderGeometry(a, a, 2 * b, 28).rotateX(Math.PI / 2);
    default: return new CapsuleGeometry(a, 2 * b, 8, 20).rotateX(Math.PI / 2);
  }
}

function triangles({ vertices, faces }) {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(vertices, 3));
  geometry.setIndex(new BufferAttribute(faces, 1));
  geometry.computeVertexNormals();
  return geometry;
}

// How far the robot reaches from its root in its first pose, in m.
function size(robot) {
  const [position, turn] = [new Vector3(), new Quaternion()];
  const root = robot.episode.way(0);
  let reach = 0.05;
  for (const mesh of robot.solids) {
    const { body } = mesh.userData;
    if (body < 0) continue;
    mesh.geometry.computeBoundingSphere();
    robot.episode.pose(body, 0, position, turn);
    const middle = mesh.position.clone().applyQuaternion(turn).add(position);
    const { radius } = mesh.geometry.boundingSphere;
    reach = Math.max(reach, middle.distanceTo(root) + radius);
  }
  return reach;
}
