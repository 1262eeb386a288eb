// A camera that circles around a point of the world.

const FIELD_OF_VIEW = 38 * Math.PI / 180;
const ELEVATIONS = { slant: 48, top: 89.9, follow: 32 };
const LOWEST = 4 * Math.PI / 180;

export class OrbitCamera {
  constructor() {
    this.target = [0, 0, 0];
    this.distance = 10;
    this.azimuth = -Math.PI / 2;
    this.elevation = ELEVATIONS.slant * Math.PI / 180;
    this.aspect = 1.5;
  }

  /** Shows a rectangle of the world in one of the views. */
  fit([minX, minY, maxX, maxY], view = "slant") {
    this.target = [(minX + maxX) / 2, (minY + maxY) / 2, 0];
    this.azimuth = -Math.PI / 2;
    this.elevation = ELEVATIONS[view] * Math.PI / 180;
    const half = Math.tan(FIELD_OF_VIEW / 2);
    const wide = (maxX - minX) / 2 / half / this.aspect;
    const deep = (maxY - minY) / 2 / half;
    // Room for the buttons over the lower border.
    this.target[1] -= 0.05 * (maxY - minY);
    this.distance = 1.12 * (view === "top" ? Math.max(wide, deep) : Math.max(wide + 0.3 * deep, deep));
  }

  orbit(dx, dy) {
    this.azimuth -= dx * 0.006;
    this.elevation = Math.min(Math.max(this.elevation + dy * 0.006, LOWEST), ELEVATIONS.top * Math.PI / 180);
  }

  /** Size of a pixel at the distance of the target, for a canvas of this height. */
  metersPerPixel(height) {
    return 2 * this.distance * Math.tan(FIELD_OF_VIEW / 2) / height;
  }

  /** Moves over the ground by pixels of a canvas of this height. */
  pan(dx, dy, height) {
    const scale = this.metersPerPixel(height);
    const [c, s] = [Math.cos(this.azimuth), Math.sin(this.azimuth)];
    const ahead = dy * scale / Math.max(Math.sin(this.elevation), 0.3);
    this.target[0] += s * dx * scale - c * ahead;
    this.target[1] += -c * dx * scale - s * ahead;
  }

  zoom(factor) {
    this.distance = Math.min(Math.max(this.distance * factor, 0.4), 400);
  }

  /** Where the eye is, and unit vectors ahead, to the right and up. */
  axes() {
    const [ce, se] = [Math.cos(this.elevation), Math.sin(this.elevation)];
    const [ca, sa] = [Math.cos(this.azimuth), Math.sin(this.azimuth)];
    const ahead = [-ce * ca, -ce * sa, -se];
    const right = [-sa, ca, 0];
    const up = [-se * ca, -se * sa, ce];
    const eye = this.target.map((value, i) => value - ahead[i] * this.distance);
    return { eye, ahead, right, up };
  }

  /** The matrix for the renderers, column by column. */
  clipFromWorld() {
    const { eye, ahead, right, up } = this.axes();
    const f = 1 / Math.tan(FIELD_OF_VIEW / 2);
    const near = this.distance * 0.02;
    const far = this.distance * 8 + 60;
    const rows = [
      scaled(right, f / this.aspect),
      scaled(up, f),
      scaled(ahead, (far + near) / (far - near)),
      ahead,
    ];
    const offsets = rows.map((row) => -dot(row, eye));
    offsets[2] -= 2 * far * near / (far - near);
    const m = new Float32Array(16);
    for (let row = 0; row < 4; row += 1) {
      for (let column = 0; column < 3; column += 1) m[4 * column + row] = rows[row][column];
      m[12 + row] = offsets[row];
    }
    return m;
  }

  /** The point of the ground under a place of the canvas (-1 to 1, y up); null in the sky. */
  ground(x, y, height = 0) {
    const { eye, ahead, right, up } = this.axes();
    const half = Math.tan(FIELD_OF_VIEW / 2);
    const ray = ahead.map((value, i) => value + right[i] * x * half * this.aspect + up[i] * y * half);
    if (ray[2] > -1e-6) return null;
    const t = (height - eye[2]) / ray[2];
    return [eye[0] + t * ray[0], eye[1] + t * ray[1]];
  }
}

const scaled = (v, factor) => v.map((value) => value * factor);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
