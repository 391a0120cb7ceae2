// What is shown on demand: contact forces, torques of the motors, and the trail of the root.

import {
  BufferAttribute, BufferGeometry, CylinderGeometry, Group, Line, LineBasicMaterial, Mesh,
  MeshBasicMaterial, Quaternion, TorusGeometry, Vector3,
} from "three";

const UP = new Vector3(0, 0, 1);
const CONTACTS = 8;

// Arrows from the ground into the robot; one robot's size stands for five times its weight.
export class Contacts extends Group {
  constructor(robot) {
    super();
    this.robot = robot;
    const width = 0.016 * robot.size;
    const shaft = new CylinderGeometry(width, 2.4 * width, 1, 10).rotateX(Math.PI / 2)
      .translate(0, 0, 0.5);
    const paint = new MeshBasicMaterial({ color: "#d6336c" });
    for (let n = 0; n < CONTACTS; n++) this.add(new Mesh(shaft, paint));
  }

  update(frame) {
    const found = this.robot.episode.contacts(frame);
    this.children.forEach((arrow, n) => {
      const length = found[n]?.force.length() ?? 0;
      arrow.visible = length > 1e-3;
      if (!arrow.visible) return;
      arrow.position.copy(found[n].position);
      arrow.quaternion.setFromUnitVectors(UP, found[n].force.normalize());
      arrow.scale.z = Math.min(2, 0.1 + length / 5) * this.robot.size;
    });
  }
}

// Rings around the joints, as thick as the torque is large; the colour tells its direction.
export class Torques extends Group {
  constructor(robot) {
    super();
    this.robot = robot;
    this.paints = ["#e8590c", "#1c7ed6"].map((color) => new MeshBasicMaterial({ color }));
    const ring = new TorusGeometry(0.1 * robot.size, 0.03 * robot.size, 8, 28);
    robot.episode.data.actuators.forEach((motor, index) => {
      if (motor.body === undefined) return;
      const mesh = new Mesh(ring, this.paints[0]);
      const axis = new Vector3(...motor.axis).normalize();
      mesh.userData = { ...motor, index, turn: new Quaternion().setFromUnitVectors(UP, axis) };
      this.add(mesh);
    });
  }

  update(frame) {
    const turn = new Quaternion();
    for (const ring of this.children) {
      const { body, pos, index, turn: own } = ring.userData;
      this.robot.episode.pose(body, frame, ring.position, turn);
      ring.position.add(new Vector3(...pos).applyQuaternion(turn));
      ring.quaternion.copy(turn).multiply(own);
      const torque = this.robot.episode.torque(index, frame);
      ring.visible = Math.abs(torque) > 0.02;
      ring.material = this.paints[torque < 0 ? 1 : 0];
      ring.scale.setScalar(0.35 + 0.65 * Math.abs(torque));
    }
  }
}

// The way of the root until now.
export class Trail extends Line {
  constructor(robot) {
    const { episode } = robot;
    const points = new Float32Array(3 * episode.frames);
    const point = new Vector3();
    for (let frame = 0; frame < episode.frames; frame++) {
      episode.way(frame, point).toArray(points, 3 * frame);
    }
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(points, 3));
    super(geometry, new LineBasicMaterial({ color: "#2f9e44" }));
    this.frustumCulled = false;
  }

  update(frame) {
    this.geometry.setDrawRange(0, Math.floor(frame) + 1);
  }
}
