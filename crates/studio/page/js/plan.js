// A building as it is drawn: walls and doors, what a click on the plan means, and a way back. Lengths in meters; `data` is what map files
// of buildings hold.

/** Points that are near nothing lie on this grid, and doors along their walls as well. */
const GRID_M = 0.1;
/** A wall that is so nearly along an axis is along it. */
const STRAIGHT_RAD = 0.14;
const MAX_STEPS_BACK = 200;

const rounded = (value) => Math.round(value * 1000) / 1000;
const onGrid = (value) => rounded(Math.round(value / GRID_M) * GRID_M);
export const apart = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);
const same = (a, b) => apart(a, b) < 1e-6;

const empty = () => ({ kind: "office", name: "my building", corridors: [], walls: [], doors: [] });

/** Nearest point of a segment, how far along it that is, and its distance. */
export function nearestOn({ from, to }, point) {
  const length = apart(from, to);
  const along = length === 0 ? 0 : ((point[0] - from[0]) * (to[0] - from[0]) + (point[1] - from[1]) * (to[1] - from[1])) / length;
  const clamped = Math.min(Math.max(along, 0), length);
  const at = length === 0 ? from : from.map((v, i) => v + (to[i] - v) * clamped / length);
  return { at, along: clamped, length, distance: apart(at, point) };
}

/** The entry for which `distanceOf` is least, if it is at most `most`. */
function nearest(entries, distanceOf, most) {
  let [best, least] = [null, most];
  for (const entry of entries) {
    const distance = distanceOf(entry);
    if (distance <= least) [best, least] = [entry, distance];
  }
  return best;
}

export class Plan {
  constructor(data) {
    this.data = { ...empty(), ...data };
    this.back = [];
    this.forth = [];
    /** Corners of the walls that are being drawn. */
    this.chain = [];
  }

  get isEmpty() {
    const { corridors, walls, doors } = this.data;
    return corridors.length + walls.length + doors.length === 0;
  }

  /** All walls as segments, each with what it is part of. */
  segments() {
    const sides = this.data.corridors.flatMap(({ outline, open_sides: open = [] }, corridor) => outline.map((from, side) => (
      { from, to: outline[(side + 1) % outline.length], part: "corridors", index: corridor, side, isOpen: open.includes(side) })));
    return [...sides, ...this.data.walls.map(({ from, to }, index) => ({ from, to, part: "walls", index }))];
  }

  corners() {
    return [...this.segments().flatMap(({ from, to }) => [from, to]), ...this.chain];
  }

  /** Where a click counts: at a corner that is near, else straight on from the last corner of the chain, in line with other corners, on a
   * wall, or on the grid. `reach` is what counts as near. */
  snap(point, reach) {
    const corner = nearest(this.corners(), (at) => apart(at, point), reach);
    if (corner) return { at: corner, on: "corner" };
    const last = this.chain[this.chain.length - 1];
    const inLine = (axis) => {
      const other = nearest(this.corners().map((at) => at[axis]), (value) => Math.abs(value - point[axis]), reach / 2);
      return other ?? onGrid(point[axis]);
    };
    const at = [inLine(0), inLine(1)];
    if (last && !same(last, point)) {
      const [dx, dy] = [Math.abs(point[0] - last[0]), Math.abs(point[1] - last[1])];
      if (Math.atan2(dy, dx) < STRAIGHT_RAD) at[1] = last[1];
      if (Math.atan2(dx, dy) < STRAIGHT_RAD) at[0] = last[0];
    }
    const wall = nearest(this.segments(), (segment) => nearestOn(segment, at).distance, reach / 2);
    if (wall) return { at: nearestOn(wall, at).at.map(rounded), on: "wall" };
    return { at, on: "grid" };
  }

  /** A door of a width where somebody points: on the nearest wall, within it and apart from other doors; `null` if there is none. */
  doorAt(point, width, reach) {
    const walls = this.segments().filter(({ isOpen }) => !isOpen);
    const wall = nearest(walls, (segment) => nearestOn(segment, point).distance, reach);
    if (!wall) return null;
    const { along, length } = nearestOn(wall, point);
    if (length < width) return null;
    const start = Math.min(Math.max(onGrid(along - width / 2), 0), length - width);
    const at = (m) => wall.from.map((v, i) => rounded(v + (wall.to[i] - v) * m / length));
    const taken = this.data.doors.some((door) => {
      const ends = [door.from, door.to].map((end) => nearestOn(wall, end));
      if (ends.some(({ distance }) => distance > 0.05)) return false;
      const [low, high] = ends.map((end) => end.along).sort((a, b) => a - b);
      return low < start + width - 1e-6 && start < high - 1e-6;
    });
    return taken ? null : { from: at(start), to: at(start + width) };
  }

  /** What somebody points at: a door before a wall. */
  partAt(point, reach) {
    const doors = this.data.doors.map(({ from, to }, index) => ({ from, to, part: "doors", index }));
    const distance = (segment) => nearestOn(segment, point).distance;
    return nearest(doors, distance, reach) ?? nearest(this.segments(), distance, reach);
  }

  /** Goes on with the chain of walls; tells whether it has ended there: at its first corner, or where it was. */
  corner(at) {
    const last = this.chain[this.chain.length - 1];
    if (!last) {
      this.chain = [at];
      return false;
    }
    if (same(last, at)) return this.end();
    const isClosed = this.chain.length > 2 && same(this.chain[0], at);
    this.change(() => this.data.walls.push({ from: last, to: at }), true);
    this.chain.push(at);
    return isClosed && this.end();
  }

  /** Ends the chain; tells whether there was one. */
  end() {
    const { length } = this.chain;
    this.chain = [];
    return length > 0;
  }

  addDoor(door, color) {
    this.change(() => this.data.doors.push({ ...door, color }));
  }

  /** Takes a part away; a wall with the doors that are on it. */
  remove({ part, index }) {
    this.change(() => {
      this.data[part].splice(index, 1);
      const walls = this.segments();
      const isOnWall = (at) => walls.some((wall) => nearestOn(wall, at).distance <= 0.05);
      this.data.doors = this.data.doors.filter(({ from, to }) => isOnWall(from) && isOnWall(to));
    });
  }

  replace(data) {
    this.change(() => { this.data = { ...empty(), ...data }; });
  }

  /** Changes something, with a way back. */
  change(act, isInChain = false) {
    this.back.push(this.snapshot());
    if (this.back.length > MAX_STEPS_BACK) this.back.shift();
    this.forth = [];
    if (!isInChain) this.end();
    act();
  }

  snapshot() {
    return JSON.stringify({ data: this.data, chain: this.chain });
  }

  /** One step back, or forth again; tells whether there was one. A chain without a wall is a step, too. */
  step(isBack) {
    if (isBack && this.chain.length === 1) return this.end();
    const [from, to] = isBack ? [this.back, this.forth] : [this.forth, this.back];
    if (from.length === 0) return false;
    to.push(this.snapshot());
    Object.assign(this, JSON.parse(from.pop()));
    return true;
  }
}
