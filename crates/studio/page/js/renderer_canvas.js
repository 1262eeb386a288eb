// Draws the same layers on a 2D canvas, where there is no WebGL: in the order in which they come.

import { STRIDE } from "./mesh.js";

const NEAR = 0.05;
/** Colors that are kept as text. */
const MAX_STYLES = 4096;

export class CanvasRenderer {
  constructor(canvas) {
    this.name = "2D";
    this.canvas = canvas;
    this.context = canvas.getContext("2d", { alpha: false });
    this.points = new Float32Array(1024);
    this.styles = new Map();
  }

  draw(clipFromWorld, background, layers) {
    const { context, canvas } = this;
    context.fillStyle = style(background[0], background[1], background[2], 1);
    context.fillRect(0, 0, canvas.width, canvas.height);
    for (const layer of layers) {
      if (layer.mesh.count === 0) continue;
      this.project(clipFromWorld, layer.mesh);
      const kind = layer.kind ?? "triangles";
      if (kind === "triangles") this.triangles(layer.mesh);
      else if (kind === "lines") this.lines(layer.mesh);
      else this.dots(layer.mesh, layer.size ?? 1);
    }
  }

  /** Pixels of all vertices; NaN for those behind the eye. */
  project(m, mesh) {
    if (this.points.length < 2 * mesh.count) this.points = new Float32Array(3 * mesh.count);
    const { width, height } = this.canvas;
    const d = mesh.data;
    for (let i = 0; i < mesh.count; i += 1) {
      const j = i * STRIDE;
      const [x, y, z] = [d[j], d[j + 1], d[j + 2]];
      const w = m[3] * x + m[7] * y + m[11] * z + m[15];
      const isAhead = w > NEAR;
      this.points[2 * i] = isAhead ? ((m[0] * x + m[4] * y + m[8] * z + m[12]) / w + 1) * width / 2 : NaN;
      this.points[2 * i + 1] = isAhead ? (1 - (m[1] * x + m[5] * y + m[9] * z + m[13]) / w) * height / 2 : NaN;
    }
  }

  /** The color of a vertex; writing colors down takes longer than drawing what has them, so each is written once. */
  fill(mesh, i) {
    const j = i * STRIDE + 3;
    const d = mesh.data;
    const key = ((d[j] * 255 | 0) << 16 | (d[j + 1] * 255 | 0) << 8 | (d[j + 2] * 255 | 0)) * 128 + (d[j + 3] * 100 | 0);
    let text = this.styles.get(key);
    if (!text) {
      if (this.styles.size >= MAX_STYLES) this.styles.clear();
      text = style(d[j], d[j + 1], d[j + 2], d[j + 3]);
      this.styles.set(key, text);
    }
    return text;
  }

  triangles(mesh) {
    const { context, points: p } = this;
    for (let i = 0; i + 2 < mesh.count; i += 3) {
      const j = 2 * i;
      if (Number.isNaN(p[j] + p[j + 2] + p[j + 4])) continue;
      context.beginPath();
      context.moveTo(p[j], p[j + 1]);
      context.lineTo(p[j + 2], p[j + 3]);
      context.lineTo(p[j + 4], p[j + 5]);
      context.closePath();
      context.fillStyle = this.fill(mesh, i);
      context.fill();
      // Neighbors would leave a seam.
      if (mesh.data[i * STRIDE + 6] === 1) {
        context.strokeStyle = context.fillStyle;
        context.lineWidth = 0.7;
        context.stroke();
      }
    }
  }

  lines(mesh) {
    const { context, points: p } = this;
    context.lineWidth = 1;
    for (let i = 0; i + 1 < mesh.count; i += 2) {
      if (Number.isNaN(p[2 * i] + p[2 * i + 2])) continue;
      context.beginPath();
      context.moveTo(p[2 * i], p[2 * i + 1]);
      context.lineTo(p[2 * i + 2], p[2 * i + 3]);
      context.strokeStyle = this.fill(mesh, i);
      context.stroke();
    }
  }

  dots(mesh, size) {
    const { context, points: p } = this;
    for (let i = 0; i < mesh.count; i += 1) {
      if (Number.isNaN(p[2 * i])) continue;
      context.fillStyle = this.fill(mesh, i);
      context.fillRect(p[2 * i] - size / 2, p[2 * i + 1] - size / 2, size, size);
    }
  }
}

function style(r, g, b, a) {
  return `rgba(${r * 255 | 0},${g * 255 | 0},${b * 255 | 0},${a.toFixed(2)})`;
}
