// A team on its field: where each robot is and believes to be, whom it sees, and who hears whom.

import { Actors, beside } from "./actors.js";
import { LANES } from "./lanes.js";
import { isLight, rgba } from "./theme.js";

/** The ellipse of a belief shows so many standard deviations. */
const NUM_SIGMAS = 3;
/** A robot that may be anywhere has none. */
const MAX_ELLIPSE_M = 2;
/** Hypotheses that are less probable are left out. */
const LEAST_PROBABILITY = 0.05;
/** A belief is tied to a robot that is farther off than this, meters. */
const APART_M = 0.4;
/** Whom a robot has heard of late, seconds. */
const HEARD_SECS = 1;
const RING_M = 0.2;
/** Half the height of a number, at least so large on the ground and on the screen. */
const DIGIT_M = 0.11;
const DIGIT_PX = 7;
/** Strokes of the numbers of robots, from -1 to 1 upright, half as wide. */
const STROKES = [
  [[[-0.3, 0.6], [0.05, 1], [0.05, -1]]],
  [[[-0.5, 1], [0.5, 1], [0.5, 0], [-0.5, 0], [-0.5, -1], [0.5, -1]]],
  [[[-0.5, 1], [0.5, 1], [0.5, -1], [-0.5, -1]], [[-0.3, 0], [0.5, 0]]],
  [[[-0.5, 1], [-0.5, 0], [0.5, 0]], [[0.5, 1], [0.5, -1]]],
  [[[0.5, 1], [-0.5, 1], [-0.5, 0], [0.5, 0], [0.5, -1], [-0.5, -1]]],
];

export class TeamActors extends Actors {
  /** `view` tells where up is on the screen, and how large a pixel is. */
  build(store, _ghost, view) {
    this.flat.clear();
    this.upright.clear();
    const { state } = store;
    const { robots, ball, look } = state.team;
    this.trails(store.pastUntilShown());
    this.links(robots);
    robots.forEach((robot, k) => this.seen(robot, rgba(LANES[k], 0.85)));
    robots.forEach((robot, k) => this.belief(robot, state.contenders[k], k));
    this.mates(robots[look], robots, look);
    robots.forEach((robot, k) => {
      if (!robot.truth) return;
      this.robot({ pose: robot.truth, height_m: robot.height_m }, k === look ? state.camera : null, rgba(LANES[k]));
      this.number(robot, k, view);
    });
    this.ball(ball);
    for (const [k, pose] of (store.pointed?.lanes ?? []).entries()) if (pose) this.mark(k, pose[0], pose[1], 0.014, rgba(LANES[k]));
  }

  /** Dotted lines between robots that hear each other. */
  links(robots) {
    const hears = (robot, other) => robot.mates.some(({ number, heard_secs: secs }) => number === other.number && secs < HEARD_SECS);
    const color = isLight() ? [0.1, 0.13, 0.17, 0.5] : [1, 1, 1, 0.4];
    robots.forEach((a, i) => robots.slice(i + 1).forEach((b) => {
      if (a.truth && b.truth && hears(a, b) && hears(b, a)) this.dashed(a.truth, b.truth, 0.02, 0.05, 0.15, 0.002, color);
    }));
  }

  dashed(from, to, width, line, gap, z, color) {
    const length = Math.hypot(to[0] - from[0], to[1] - from[1]);
    const at = (m) => [0, 1].map((i) => from[i] + (to[i] - from[i]) * Math.min(m / length, 1));
    for (let m = 0; m < length; m += line + gap) this.flat.strip(...at(m), ...at(m + line), width, z, color);
  }

  /** Lines to what its detector has found: robots end in a ring, balls in a dot. */
  seen({ truth, seen }, color) {
    for (const [x, y, isBall] of truth ? seen : []) {
      this.flat.strip(truth[0], truth[1], x, y, 0.014, 0.006, color);
      this.flat.ring(x, y, 0.007, isBall ? 0 : 0.07, 0.09, color, 0, 2 * Math.PI, 16);
    }
  }

  /** Ring and ellipse where it believes to be, faint rings for the other hypotheses, and a line from where it is if that is elsewhere. */
  belief({ truth, covariance, knows }, contender, lane) {
    const color = rgba(LANES[lane], knows === "lost" ? 0.5 : 1);
    const [x, y] = contender.pose;
    if (truth && Math.hypot(x - truth[0], y - truth[1]) > APART_M) this.dashed(truth, contender.pose, 0.02, 0.15, 0.1, 0.004, [...color.slice(0, 3), 0.45]);
    this.hypotheses(contender, color, 0.008, LEAST_PROBABILITY);
    const faint = [...color.slice(0, 3), 0.6];
    for (const [hx, hy] of beside(contender, LEAST_PROBABILITY)) this.mark(lane, hx, hy, 0.008, faint);
    this.ellipse(x, y, covariance, [...color.slice(0, 3), 0.35]);
    this.ring(contender, color, 0.009, RING_M);
    const back = contender.pose[2] + Math.PI;
    this.mark(lane, x + 0.32 * Math.cos(back), y + 0.32 * Math.sin(back), 0.013, color);
  }

  ellipse(x, y, [xx, xy, yy], color) {
    const [middle, half] = [(xx + yy) / 2, Math.hypot((xx - yy) / 2, xy)];
    const angle = Math.atan2(2 * xy, xx - yy) / 2;
    const [a, b] = [middle + half, middle - half].map((variance) => NUM_SIGMAS * Math.sqrt(Math.max(variance, 0)));
    if (a > MAX_ELLIPSE_M) return;
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    const corners = Array.from({ length: 28 }, (_, i) => [a * Math.cos(Math.PI * i / 14), b * Math.sin(Math.PI * i / 14)]);
    this.flat.fan(corners.map(([u, v]) => [x + u * c - v * s, y + u * s + v * c]), 0.01, color);
  }

  /** Where the robot that is looked at believes its mates to be: their marks in a ring of its color, the fainter the less it trusts them. */
  mates({ mates }, robots, look) {
    for (const { number, pose, trust } of mates) {
      const lane = robots.findIndex((robot) => robot.number === number);
      if (!pose || lane < 0) continue;
      const alpha = 0.35 + 0.65 * trust;
      this.flat.ring(pose[0], pose[1], 0.011, 0.1, 0.12, rgba(LANES[look], alpha), 0, 2 * Math.PI, 24);
      this.mark(lane, pose[0], pose[1], 0.012, rgba(LANES[lane], alpha));
    }
  }

  /** The number on a plate before the robot, upright on the screen. */
  number({ truth, number }, lane, { azimuth, metersPerPixel }) {
    const size = Math.max(DIGIT_M, DIGIT_PX * metersPerPixel);
    const [up, right] = [[-Math.cos(azimuth), -Math.sin(azimuth)], [-Math.sin(azimuth), Math.cos(azimuth)]];
    const [x, y] = [truth[0] - 0.2 * up[0] - 1.6 * size * up[0], truth[1] - 0.2 * up[1] - 1.6 * size * up[1]];
    this.flat.ring(x, y, 0.016, 0, 1.7 * size, rgba("surface"), 0, 2 * Math.PI, 28);
    this.flat.ring(x, y, 0.017, 1.5 * size, 1.75 * size, rgba(LANES[lane]), 0, 2 * Math.PI, 28);
    const at = ([u, v]) => [x + size * (u * right[0] + v * up[0]), y + size * (u * right[1] + v * up[1])];
    for (const stroke of STROKES[number - 1] ?? []) {
      stroke.slice(1).forEach((to, i) => this.flat.strip(...at(stroke[i]), ...at(to), 0.3 * size, 0.018, rgba("text")));
    }
  }

  ball([x, y]) {
    this.flat.ring(x, y, 0.005, 0, 0.09, [0, 0, 0, 0.35], 0, 2 * Math.PI, 20);
    this.upright.stump(x, y, 0.01, 0.06, 0.04, 0.055, [0.96, 0.96, 0.96, 1]);
    this.upright.stump(x, y, 0.06, 0.11, 0.055, 0.03, [0.75, 0.75, 0.75, 1]);
  }
}
