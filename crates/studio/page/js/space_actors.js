// What a camera without a map has found: landmarks, candidates, keyframes and its way.

import { Mesh } from "./mesh.js";
import { isLight, rgba } from "./theme.js";

export class SpaceActors {
  constructor() {
    this.flat = new Mesh();
    this.upright = new Mesh();
    this.points = new Mesh();
    this.segments = new Mesh();
  }

  get layers() {
    const size = 2.2 * Math.min(devicePixelRatio, 2);
    return [{ mesh: this.segments, kind: "lines", isFlat: true }, { mesh: this.points, kind: "points", size }];
  }

  build({ arrays, state }) {
    for (const mesh of [this.flat, this.upright, this.points, this.segments]) mesh.clear();
    if (!state || !arrays.landmarks) return;
    const color = isLight() ? [0.13, 0.17, 0.22, 0.85] : [0.82, 0.88, 0.94, 0.9];
    const { landmarks, candidates, keyframes, links, trajectory, truth, recorded } = arrays;
    for (let i = 0; i + 2 < landmarks.length; i += 3) {
      this.points.vertex(landmarks[i], landmarks[i + 1], landmarks[i + 2], color);
    }
    this.pairs(candidates, 3, rgba("c0", isLight() ? 0.3 : 0.22));
    this.pairs(links, 3, rgba("c2", 0.35));
    this.path(recorded, 0.014, rgba("c3", 0.9), 3);
    this.path(trajectory, 0.02, rgba("c1"));
    // Dashed and thicker, so that it is seen on both.
    this.path(truth, 0.026, rgba("accent", 0.9), 2);
    for (let i = 0; i + 11 < keyframes.length; i += 12) this.frustum(keyframes.subarray(i, i + 12), 0.09, rgba("c2", 0.8));
    if (arrays.camera?.length === 12) this.frustum(arrays.camera, 0.2, rgba("c1"));
  }

  pairs(values, size, color) {
    for (let i = 0; values && i + 2 * size - 1 < values.length; i += 2 * size) {
      this.segments.line(values.subarray(i, i + 3), values.subarray(i + size, i + size + 3), color);
    }
  }

  /** A way through space; of `dash` groups of pieces one is left out. */
  path(values, radius, color, dash = Infinity) {
    if (!values) return;
    const step = Math.max(1, Math.floor(values.length / 3 / 700));
    for (let i = 0, k = 0; i + 3 * step + 2 < values.length; i += 3 * step, k += 1) {
      if (Math.floor(k / 6) % dash === dash - 1) continue;
      const [a, b] = [values.subarray(i, i + 3), values.subarray(i + 3 * step, i + 3 * step + 3)];
      if (Number.isNaN(a[0] + b[0])) continue;
      this.ribbon(a, b, radius, color);
    }
  }

  /** Two crossed strips: looks like a thin tube from everywhere. */
  ribbon(a, b, r, color) {
    this.upright.quad([a[0], a[1], a[2] - r], [b[0], b[1], b[2] - r], [b[0], b[1], b[2] + r], [a[0], a[1], a[2] + r], color);
    const [dx, dy] = [b[0] - a[0], b[1] - a[1]];
    const length = Math.hypot(dx, dy) || 1;
    const [nx, ny] = [-dy / length * r, dx / length * r];
    this.upright.quad([a[0] + nx, a[1] + ny, a[2]], [b[0] + nx, b[1] + ny, b[2]], [b[0] - nx, b[1] - ny, b[2]],
      [a[0] - nx, a[1] - ny, a[2]], color);
  }

  /** A camera: its place, and unit vectors to the right, down and ahead. */
  frustum(v, size, color) {
    const at = (x, y, z) => [0, 1, 2].map((i) => v[i] + size * (v[3 + i] * x + v[6 + i] * y + v[9 + i] * z));
    const corners = [at(-0.8, -0.6, 1), at(0.8, -0.6, 1), at(0.8, 0.6, 1), at(-0.8, 0.6, 1)];
    corners.forEach((corner, i) => {
      this.segments.line(v, corner, color);
      this.segments.line(corner, corners[(i + 1) % 4], color);
    });
  }
}
