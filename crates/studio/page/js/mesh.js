// Triangles, lines and points with colors, as the renderers take them: x, y, z, red, green, blue, alpha.

export const STRIDE = 7;

export class Mesh {
  constructor() {
    this.data = new Float32Array(STRIDE * 1536);
    this.count = 0;
    this.version = 0;
  }

  clear() {
    this.count = 0;
    this.version += 1;
  }

  vertex(x, y, z, c) {
    if ((this.count + 1) * STRIDE > this.data.length) {
      const larger = new Float32Array(this.data.length * 2);
      larger.set(this.data);
      this.data = larger;
    }
    const i = this.count * STRIDE;
    const d = this.data;
    d[i] = x; d[i + 1] = y; d[i + 2] = z;
    d[i + 3] = c[0]; d[i + 4] = c[1]; d[i + 5] = c[2]; d[i + 6] = c[3];
    this.count += 1;
  }

  triangle(a, b, c, color) {
    this.vertex(a[0], a[1], a[2], color);
    this.vertex(b[0], b[1], b[2], color);
    this.vertex(c[0], c[1], c[2], color);
  }

  quad(a, b, c, d, color) {
    this.triangle(a, b, c, color);
    this.triangle(a, c, d, color);
  }

  line(a, b, color) {
    this.vertex(a[0], a[1], a[2], color);
    this.vertex(b[0], b[1], b[2], color);
  }

  /** A rectangle along a way over the ground. */
  strip(x0, y0, x1, y1, width, z, color) {
    const length = Math.hypot(x1 - x0, y1 - y0) || 1;
    const nx = -(y1 - y0) / length * width / 2;
    const ny = (x1 - x0) / length * width / 2;
    this.quad([x0 + nx, y0 + ny, z], [x1 + nx, y1 + ny, z], [x1 - nx, y1 - ny, z], [x0 - nx, y0 - ny, z], color);
  }

  /** A part of a ring on the ground. */
  ring(x, y, z, inner, outer, color, from = 0, to = 2 * Math.PI, corners = 40) {
    const steps = Math.max(2, Math.ceil(corners * (to - from) / (2 * Math.PI)));
    for (let i = 0; i < steps; i += 1) {
      const a = from + (to - from) * i / steps;
      const b = from + (to - from) * (i + 1) / steps;
      const [ca, sa, cb, sb] = [Math.cos(a), Math.sin(a), Math.cos(b), Math.sin(b)];
      if (inner > 0) {
        this.quad([x + inner * ca, y + inner * sa, z], [x + outer * ca, y + outer * sa, z],
          [x + outer * cb, y + outer * sb, z], [x + inner * cb, y + inner * sb, z], color);
      } else {
        this.triangle([x, y, z], [x + outer * ca, y + outer * sa, z], [x + outer * cb, y + outer * sb, z], color);
      }
    }
  }

  /** A filled outline on the ground, star-shaped around its first corner. */
  fan(points, z, color) {
    for (let i = 1; i + 1 < points.length; i += 1) {
      this.triangle([...points[0], z], [...points[i], z], [...points[i + 1], z], color);
    }
  }

  /** An upright wall from the ground. */
  wall(x0, y0, x1, y1, z0, z1, color) {
    const c = shaded(color, [-(y1 - y0), x1 - x0]);
    this.quad([x0, y0, z0], [x1, y1, z0], [x1, y1, z1], [x0, y0, z1], c);
  }

  /** An upright cone stump, closed at the top. */
  stump(x, y, z0, z1, r0, r1, color, corners = 14) {
    for (let i = 0; i < corners; i += 1) {
      const a = 2 * Math.PI * i / corners;
      const b = 2 * Math.PI * (i + 1) / corners;
      const [ca, sa, cb, sb] = [Math.cos(a), Math.sin(a), Math.cos(b), Math.sin(b)];
      const side = shaded(color, [ca + cb, sa + sb]);
      this.quad([x + r0 * ca, y + r0 * sa, z0], [x + r0 * cb, y + r0 * sb, z0],
        [x + r1 * cb, y + r1 * sb, z1], [x + r1 * ca, y + r1 * sa, z1], side);
      this.triangle([x, y, z1], [x + r1 * ca, y + r1 * sa, z1], [x + r1 * cb, y + r1 * sb, z1], color);
    }
  }

  /** A bar between two points in space. */
  bar(a, b, radius, color) {
    const along = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
    const length = Math.hypot(...along) || 1;
    const u = Math.abs(along[2]) > 0.9 * length ? [1, 0, 0] : [along[1] / length, -along[0] / length, 0];
    const v = [along[1] * u[2] - along[2] * u[1], along[2] * u[0] - along[0] * u[2], along[0] * u[1] - along[1] * u[0]]
      .map((value) => value / length);
    const at = (p, angle) => {
      const [c, s] = [Math.cos(angle) * radius, Math.sin(angle) * radius];
      return [p[0] + u[0] * c + v[0] * s, p[1] + u[1] * c + v[1] * s, p[2] + u[2] * c + v[2] * s];
    };
    for (let i = 0; i < 8; i += 1) {
      const [s, t] = [Math.PI * i / 4, Math.PI * (i + 1) / 4];
      const light = 0.72 + 0.28 * Math.sin(s + 0.6);
      this.quad(at(a, s), at(b, s), at(b, t), at(a, t), [color[0] * light, color[1] * light, color[2] * light, color[3]]);
    }
  }
}

/** A color in the light that falls from one side. */
function shaded(color, normal) {
  const length = Math.hypot(...normal) || 1;
  const light = 0.8 + 0.2 * (0.55 * normal[0] - 0.83 * normal[1]) / length;
  return [color[0] * light, color[1] * light, color[2] * light, color[3]];
}
