// What moves in the world of a robot: the robot itself, what algorithms believe, other robots.

import { LANES, markOf } from "./lanes.js";
import { Mesh } from "./mesh.js";
import { isLight, rgba } from "./theme.js";

/** Length of a robot's arrow, meters: its tip is the handle to turn it. */
export const ARROW_M = 0.42;
const BODY_M = 0.13;
const TRAIL_FRAMES = 450;
const TRAIL_SECS = 15;
/** Frames of a piece of a trail. */
const PIECE_FRAMES = 4;
/** Which pieces of a trail are drawn, for each lane over and over: its dash. */
const TRAIL_DASHES = [[1], [1, 1, 0], [1, 0], [1, 1, 1, 0, 1, 0], [1, 1, 1, 1, 0]];
const TRUTH_DASH = [1, 1, 0, 0];

/** Hypotheses of another place than the believed one. */
export function beside({ pose, hypotheses }, least) {
  return hypotheses.filter(([x, y, , probability]) => probability >= least && Math.hypot(x - pose[0], y - pose[1]) > BODY_M);
}

export class Actors {
  constructor() {
    this.flat = new Mesh();
    this.upright = new Mesh();
  }

  /** Builds everything for the latest state. `ghost` is where somebody holds the robot with the mouse. */
  build(store, ghost) {
    this.flat.clear();
    this.upright.clear();
    const { state, arrays } = store;
    if (!state?.contenders) return;
    this.likelihood(arrays.likelihood);
    this.trails(store.pastUntilShown());
    state.contenders.forEach((_, i) => this.individuals(arrays[`individuals${i}`], rgba(LANES[i])));
    state.contenders.forEach((contender, i) => this.estimate(contender, rgba(LANES[i]), i));
    state.contenders.forEach((contender, i) => this.estimateMark(contender, i));
    const truth = ghost ? { pose: ghost, height_m: 0.35 } : state.truth;
    if (truth) this.robot(truth, state.camera);
    for (const pose of state.others ?? []) this.body(pose, 0, [0.45, 0.48, 0.52, 1]);
    const target = state.controls?.target;
    if (target) this.target(target);
    if (store.aim) this.aim(store.aim);
    for (const [k, pose] of (store.pointed?.lanes ?? []).entries()) if (pose) this.mark(k, pose[0], pose[1], 0.014, rgba(LANES[k]));
    if (store.pointed?.truth) this.target(store.pointed.truth);
  }

  /** How well every place explains the image: the better, the brighter. */
  likelihood(values) {
    if (!values) return;
    const [x0, y0, pitch, columns, rows] = values;
    const cells = values.subarray(5);
    const most = cells.reduce((a, b) => Math.max(a, b), 1e-6);
    for (let row = 0; row < rows; row += 1) {
      for (let column = 0; column < columns; column += 1) {
        const share = (cells[row * columns + column] / most) ** 3;
        if (share < 0.02) continue;
        const color = [1, 0.35 + 0.6 * share, 0.15 + 0.3 * share, 0.62 * share];
        const [x, y] = [x0 + column * pitch, y0 + row * pitch];
        this.flat.fan([[x, y], [x + pitch, y], [x + pitch, y + pitch], [x, y + pitch]], 0.003, color);
      }
    }
  }

  trails(past) {
    const recent = past.slice(-TRAIL_FRAMES).filter(({ secs }) => secs > past[past.length - 1].secs - TRAIL_SECS);
    // Pieces begin at the same frames as the time goes on, so that dashes stay where they are.
    const first = recent.length ? (PIECE_FRAMES - recent[0].number % PIECE_FRAMES) % PIECE_FRAMES : 0;
    const pieces = [];
    for (let i = first + PIECE_FRAMES; i < recent.length; i += PIECE_FRAMES) pieces.push([recent[i - PIECE_FRAMES], recent[i]]);
    const isDrawn = (dash, { number }) => dash[Math.floor(number / PIECE_FRAMES) % dash.length] === 1;
    for (const [a, b] of pieces) {
      b.lanes.forEach((lane, k) => {
        const before = a.lanes[k];
        if (!lane.pose || before?.name !== lane.name || lane.reliability < 0.3 || before.reliability < 0.3) return;
        if (isDrawn(TRAIL_DASHES[k], b)) this.piece(before.pose, lane.pose, 0.018, 0.004, rgba(LANES[k], 0.7));
      });
    }
    // The truth lies dashed above the estimates, which hide it otherwise.
    const truth = rgba("truth", isLight() ? 0.8 : 0.65);
    for (const [a, b] of pieces) {
      if (a.isCarried || b.isCarried || !isDrawn(TRUTH_DASH, b)) continue;
      a.truths.forEach((pose, k) => pose && b.truths[k] && this.piece(pose, b.truths[k], 0.014, 0.005, truth));
    }
  }

  piece(a, b, width, z, color) {
    const length = Math.hypot(b[0] - a[0], b[1] - a[1]);
    if (length > 0.002 && length < 0.5) this.flat.strip(a[0], a[1], b[0], b[1], width, z, color);
  }

  /** Particles as small arrows; brighter where the image fits better. */
  individuals(values, color) {
    if (!values) return;
    const c = [...color];
    for (let i = 0; i + 4 < values.length; i += 5) {
      const [x, y, yaw, likelihood, population] = values.subarray(i, i + 5);
      const [ca, sa] = [Math.cos(yaw), Math.sin(yaw)];
      c[3] = 0.3 + 0.5 * likelihood;
      const size = population > 0 ? 0.05 : 0.04;
      this.flat.triangle(
        [x + 1.5 * size * ca, y + 1.5 * size * sa, 0.006],
        [x - size * ca - 0.6 * size * sa, y - size * sa + 0.6 * size * ca, 0.006],
        [x - size * ca + 0.6 * size * sa, y - size * sa - 0.6 * size * ca, 0.006], c);
    }
  }

  /** The winning pose as a ring that shrinks as the reliability grows, and faint ones for the others. */
  estimate(contender, color, lane) {
    const z = 0.008 + 0.001 * lane;
    this.hypotheses(contender, color, z);
    // Each a little larger than the one before, so that none hides another.
    this.ring(contender, color, z, 0.17 + 0.05 * lane + 0.6 * (1 - contender.reliability));
  }

  /** Hypotheses beside the believed pose that are at least so probable, faint. */
  hypotheses(contender, color, z, least = 0) {
    for (const [x, y, yaw, probability] of beside(contender, least)) {
      const faint = [...color.slice(0, 3), 0.15 + 0.6 * probability];
      this.flat.ring(x, y, z, 0.14, 0.165, faint, 0, 2 * Math.PI, 24);
      this.flat.strip(x, y, x + 0.22 * Math.cos(yaw), y + 0.22 * Math.sin(yaw), 0.02, z, faint);
    }
  }

  /** A ring with an arrow at the believed pose, dashed if it is not to be relied on. */
  ring(contender, color, z, radius) {
    const [x, y, yaw] = contender.pose;
    const solid = [...color.slice(0, 3), contender.is_localized ? 1 : 0.65];
    this.flat.ring(x, y, z, 0, radius, [...color.slice(0, 3), 0.12]);
    if (contender.is_localized) {
      this.flat.ring(x, y, z, radius, radius + 0.035, solid, 0, 2 * Math.PI, 48);
    } else {
      for (let k = 0; k < 16; k += 1) {
        this.flat.ring(x, y, z, radius, radius + 0.03, solid, k * Math.PI / 8, (k + 0.55) * Math.PI / 8);
      }
    }
    this.arrow(x, y, yaw, radius + 0.02, radius + 0.17, 0.075, z, solid);
  }

  /** The mark of an estimate, at the back of its ring, each a little further around. */
  estimateMark({ pose: [x, y, yaw], reliability }, lane) {
    const distance = 0.29 + 0.05 * lane + 0.6 * (1 - reliability);
    const bearing = yaw + Math.PI + 0.55 * (lane - 1);
    this.mark(lane, x + distance * Math.cos(bearing), y + distance * Math.sin(bearing), 0.013, rgba(LANES[lane]));
  }

  /** The mark of a lane. */
  mark(lane, x, y, z, color) {
    this.flat.fan(markOf(lane).map(([dx, dy]) => [x + 0.07 * dx, y - 0.07 * dy]), z, color);
  }

  /** A pointer at the border of a circle. */
  arrow(x, y, yaw, from, to, half, z, color) {
    const [c, s] = [Math.cos(yaw), Math.sin(yaw)];
    this.flat.triangle([x + to * c, y + to * s, z], [x + from * c - half * s, y + from * s + half * c, z],
      [x + from * c + half * s, y + from * s - half * c, z], color);
  }

  /** The robot with the wedge of what its camera sees, and the arrow by which it can be turned. */
  robot(truth, camera, color = rgba("truth")) {
    const [x, y, yaw] = truth.pose;
    const z = truth.height_m;
    if (camera) {
      const [heading, width] = [yaw + camera[0], camera[1]];
      this.flat.ring(x, y, 0.003, 0, 1.6, rgba("truth", isLight() ? 0.1 : 0.07), heading - width / 2, heading + width / 2);
    }
    this.flat.ring(x, y, 0.005, 0, 0.17, [0, 0, 0, 0.35], 0, 2 * Math.PI, 24);
    this.arrow(x, y, yaw, 0.2, ARROW_M, 0.085, 0.012, color);
    this.body(truth.pose, z, color);
  }

  body([x, y, yaw], z, color) {
    this.upright.stump(x, y, z + 0.01, z + 0.34, BODY_M * 0.8, BODY_M, color);
    this.upright.stump(x, y, z + 0.36, z + 0.47, BODY_M * 0.62, BODY_M * 0.5, color);
    const [c, s] = [Math.cos(yaw), Math.sin(yaw)];
    const dark = isLight() ? [0.92, 0.95, 0.97, 1] : [0.1, 0.13, 0.17, 1];
    this.upright.bar([x + 0.055 * c, y + 0.055 * s, z + 0.43], [x + 0.1 * c, y + 0.1 * s, z + 0.43], 0.024, dark);
  }

  /** The cross by which keys choose a place. */
  aim([x, y, yaw]) {
    const color = rgba("danger");
    this.flat.ring(x, y, 0.015, 0.2, 0.23, color, 0, 2 * Math.PI, 32);
    for (const [dx, dy] of [[1, 0], [0, 1]]) {
      this.flat.strip(x - 0.3 * dx, y - 0.3 * dy, x + 0.3 * dx, y + 0.3 * dy, 0.025, 0.015, color);
    }
    this.arrow(x, y, yaw, 0.25, 0.45, 0.09, 0.015, color);
  }

  target([x, y]) {
    const color = rgba("truth", 0.8);
    this.flat.ring(x, y, 0.011, 0.05, 0.075, color, 0, 2 * Math.PI, 24);
    this.flat.ring(x, y, 0.011, 0, 0.02, color, 0, 2 * Math.PI, 12);
  }
}
