// The ground: a grid that goes on with the robot, or the height field that it runs on.

import {
  BufferAttribute, BufferGeometry, Color, DoubleSide, Group, LineBasicMaterial, LineSegments, Mesh,
  MeshStandardMaterial, PlaneGeometry, ShadowMaterial,
} from "three";

const LINES = 40; // to each side

export class Ground extends Group {
  constructor(ground, spacing, dark) {
    super();
    this.spacing = spacing;
    const level = ground.planes.length ? Math.max(...ground.planes) : 0;
    if (ground.field) this.add(...tiles(ground.field, dark));
    this.grid = grid(spacing, dark);
    this.grid.position.z = level + 1e-4;
    this.grid.visible = !ground.field;
    this.shadow = new Mesh(new PlaneGeometry(1, 1), new ShadowMaterial({ opacity: 0.22 }));
    this.shadow.scale.setScalar(2 * LINES * spacing);
    this.shadow.position.z = level;
    this.shadow.receiveShadow = true;
    this.shadow.visible = !ground.field;
    this.add(this.grid, this.shadow);
  }

  // Brings the grid to where the robot is; a line stands at every multiple of the spacing.
  follow({ x, y }) {
    const near = (value) => Math.round(value / (10 * this.spacing)) * 10 * this.spacing;
    this.grid.position.x = this.shadow.position.x = near(x);
    this.grid.position.y = this.shadow.position.y = near(y);
  }
}

function grid(spacing, dark) {
  const reach = LINES * spacing;
  const points = [];
  const colours = [];
  const [paper, thin, thick] = (dark ? ["#191b20", "#30343d", "#4b515d"]
    : ["#f3f1ec", "#dcd8ce", "#b9b4a7"]).map((text) => new Color(text));
  for (let n = -LINES; n <= LINES; n++) {
    const strong = n % 10 === 0 ? thick : thin;
    for (const [ax, ay, bx, by] of [[n * spacing, -reach, n * spacing, reach],
      [-reach, n * spacing, reach, n * spacing]]) {
      // From the middle outwards, so that lines fade into the paper.
      points.push(ax, ay, 0, (ax + bx) / 2, (ay + by) / 2, 0, (ax + bx) / 2, (ay + by) / 2, 0,
        bx, by, 0);
      const middle = paper.clone().lerp(strong, Math.max(0, 1 - Math.abs(n) / LINES));
      for (const colour of [paper, middle, middle, paper]) colours.push(...colour.toArray());
    }
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(points), 3));
  geometry.setAttribute("color", new BufferAttribute(new Float32Array(colours), 3));
  const lines = new LineSegments(geometry, new LineBasicMaterial({ vertexColors: true }));
  lines.frustumCulled = false;
  return lines;
}

// One mesh for each place of the height field; they share their triangles.
function tiles({ rows, columns, size: [halfX, halfY, height], heights, at }, dark) {
  const points = new Float32Array(3 * rows * columns);
  const faces = [];
  for (let i = 0; i < rows; i++) {
    for (let j = 0; j < columns; j++) {
      const n = i * columns + j;
      points[3 * n] = -halfX + (2 * halfX * j) / (columns - 1);
      points[3 * n + 1] = -halfY + (2 * halfY * i) / (rows - 1);
      points[3 * n + 2] = (height * heights[n]) / 65535;
      if (i && j) faces.push(n - columns - 1, n - columns, n, n - columns - 1, n, n - 1);
    }
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(points, 3));
  geometry.setIndex(faces);
  geometry.computeVertexNormals();
  const paint = new MeshStandardMaterial({ color: dark ? "#5b5346" : "#d8c9a8", roughness: 1,
    flatShading: true, side: DoubleSide });
  return at.map(([x, y, z]) => {
    const mesh = new Mesh(geometry, paint);
    mesh.position.set(x, y, z);
    mesh.receiveShadow = true;
    return mesh;
  });
}
