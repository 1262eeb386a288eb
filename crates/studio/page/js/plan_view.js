// The plan of a building on a canvas: where it is looked at from, and how it is drawn.

import { apart } from "./plan.js";
import { css } from "./theme.js";

const MIN_SCALE = 4;
const MAX_SCALE = 400;
/** Corners farther apart than this are never taken for one. */
const MOST_REACH_M = 0.6;
/** What is shown of an empty plan, meters. */
const FIRST_M = [[-1, -2], [12, 6]];
/** Free space around a plan that is shown whole, pixels. */
const MARGIN_PX = 50;

export class PlanView {
  constructor(canvas) {
    this.canvas = canvas;
    this.scale = 40;
    this.center = [5, 2];
    new ResizeObserver(() => this.redraw?.()).observe(canvas);
  }

  get size() {
    return [this.canvas.clientWidth, this.canvas.clientHeight];
  }

  /** From meters, y up, to pixels of the page within the canvas, and back. */
  toPx([x, y]) {
    const [width, height] = this.size;
    return [width / 2 + (x - this.center[0]) * this.scale, height / 2 - (y - this.center[1]) * this.scale];
  }

  toPlan([px, py]) {
    const [width, height] = this.size;
    return [this.center[0] + (px - width / 2) / this.scale, this.center[1] - (py - height / 2) / this.scale];
  }

  /** What counts as near, meters: so many pixels, but from far away no whole room. */
  reach(px) {
    return Math.min(px / this.scale, MOST_REACH_M);
  }

  pan(dx, dy) {
    this.center = [this.center[0] - dx / this.scale, this.center[1] + dy / this.scale];
  }

  /** Zooms about a pixel. */
  zoom(factor, px = this.size.map((side) => side / 2)) {
    const before = this.toPlan(px);
    this.scale = Math.min(Math.max(this.scale * factor, MIN_SCALE), MAX_SCALE);
    const after = this.toPlan(px);
    this.center = this.center.map((v, i) => v + before[i] - after[i]);
  }

  /** Shows everything. */
  fit(plan) {
    const corners = plan.corners().length > 1 ? plan.corners() : FIRST_M;
    const span = [0, 1].map((axis) => {
      const values = corners.map((corner) => corner[axis]);
      return [Math.min(...values), Math.max(...values)];
    });
    this.center = span.map(([low, high]) => (low + high) / 2);
    const room = this.size.map((side) => Math.max(side - 2 * MARGIN_PX, 40));
    const scale = Math.min(...room.map((side, i) => side / Math.max(span[i][1] - span[i][0], 2)));
    this.scale = Math.min(Math.max(scale, MIN_SCALE), MAX_SCALE / 3);
  }

  /** `more` has `cursor` (where a click would count), `door` (that it would make), `part` (that it would take away), and `faults`: which
   * parts are wrong (`walls[2]`) and `looseEnds`. */
  draw(plan, more) {
    const ratio = Math.min(devicePixelRatio, 2);
    const [width, height] = this.size;
    [this.canvas.width, this.canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
    const context = this.canvas.getContext("2d");
    context.scale(ratio, ratio);
    context.lineCap = "round";
    this.grid(context, width, height);
    for (const wall of plan.segments()) {
      const isWrong = more.faults.has(`${wall.part}[${wall.index}]`);
      this.line(context, wall.from, wall.to, isWrong ? css("danger") : css("text"), 4, wall.isOpen ? [2, 8] : []);
    }
    plan.data.doors.forEach((door, index) => {
      if (more.faults.has(`doors[${index}]`)) this.line(context, door.from, door.to, css("danger"), 14);
      this.line(context, door.from, door.to, css("surface"), 10);
      this.line(context, door.from, door.to, door.color ?? "red", 7, door.is_open ? [3, 9] : []);
    });
    for (const end of more.looseEnds) this.ring(context, end, 9, css("warn"));
    if (more.part) this.line(context, more.part.from, more.part.to, css("danger"), 8);
    if (more.door) this.line(context, more.door.from, more.door.to, css("accent"), 8);
    const last = plan.chain[plan.chain.length - 1];
    if (last && more.cursor) {
      this.line(context, last, more.cursor.at, css("accent"), 3, [6, 6]);
      this.length(context, last, more.cursor.at);
    }
    if (last) this.ring(context, plan.chain[0], 8, css("accent"));
    if (more.cursor) this.cross(context, more.cursor);
  }

  grid(context, width, height) {
    const step = [0.5, 1, 2, 5, 10, 20].find((meters) => meters * this.scale >= 44) ?? 50;
    const [[left, top], [right, bottom]] = [this.toPlan([0, 0]), this.toPlan([width, height])];
    context.font = "12px system-ui, sans-serif";
    context.fillStyle = css("soft");
    const each = (from, to, draw) => {
      for (let k = Math.ceil(from / step); k * step <= to; k += 1) draw(k * step);
    };
    each(left, right, (x) => {
      this.line(context, [x, top], [x, bottom], css("line"), x === 0 ? 2 : 1);
      context.fillText(`${x}`, this.toPx([x, 0])[0] + 3, height - 5);
    });
    each(bottom, top, (y) => {
      this.line(context, [left, y], [right, y], css("line"), y === 0 ? 2 : 1);
      context.fillText(`${y}`, 4, this.toPx([0, y])[1] - 3);
    });
  }

  line(context, from, to, color, width, dash = []) {
    context.strokeStyle = color;
    context.lineWidth = width;
    context.setLineDash(dash);
    context.beginPath();
    context.moveTo(...this.toPx(from));
    context.lineTo(...this.toPx(to));
    context.stroke();
    context.setLineDash([]);
  }

  ring(context, at, radius, color) {
    context.strokeStyle = color;
    context.lineWidth = 2;
    context.beginPath();
    context.arc(...this.toPx(at), radius, 0, 2 * Math.PI);
    context.stroke();
  }

  cross(context, { at, on }) {
    const [x, y] = this.toPx(at);
    context.strokeStyle = css("accent");
    context.lineWidth = 2;
    context.beginPath();
    for (const [dx, dy] of [[9, 0], [0, 9]]) {
      context.moveTo(x - dx, y - dy);
      context.lineTo(x + dx, y + dy);
    }
    context.stroke();
    if (on !== "grid") this.ring(context, at, 6, css("accent"));
  }

  length(context, from, to) {
    const [x, y] = this.toPx([(from[0] + to[0]) / 2, (from[1] + to[1]) / 2]);
    const text = `${apart(from, to).toFixed(2)} m`;
    context.font = "600 13px system-ui, sans-serif";
    context.fillStyle = css("surface");
    const { width } = context.measureText(text);
    context.fillRect(x - width / 2 - 4, y - 22, width + 8, 18);
    context.fillStyle = css("text");
    context.fillText(text, x - width / 2, y - 8);
  }
}
