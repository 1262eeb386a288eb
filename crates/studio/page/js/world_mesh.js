// The world as meshes: what lies on the ground, and what stands on it.

import { Mesh } from "./mesh.js";
import { fromHex, isLight } from "./theme.js";

const LINE = [0.93, 0.95, 0.94, 1];

/** `{ground, upright}` of a map's geometry. */
export function worldMeshes(world) {
  const meshes = { ground: new Mesh(), upright: new Mesh() };
  if (world?.kind === "field") field(world, meshes);
  else if (world?.kind === "office") office(world, meshes);
  else if (world?.kind === "space") space(world, meshes);
  return meshes;
}

function field(world, { ground, upright }) {
  const [x0, y0, x1, y1] = world.bounds_m;
  const carpet = isLight() ? ["#5f9d78", "#68a681"] : ["#23503a", "#275840"];
  // Mown stripes give the eye a scale.
  const stripes = 2 * Math.round((x1 - x0) / 2 / 0.5);
  for (let i = 0; i < stripes; i += 1) {
    const [a, b] = [i, i + 1].map((k) => x0 + (x1 - x0) * k / stripes);
    ground.fan([[a, y0], [b, y0], [b, y1], [a, y1]], 0, fromHex(carpet[i % 2]));
  }
  const width = world.line_width_m;
  for (const [a, b, c, d] of [...world.lines, ...world.marks]) {
    // Ends reach to the borders of the lines that they meet.
    const length = Math.hypot(c - a, d - b) || 1;
    const [ex, ey] = [(c - a) / length * width / 2, (d - b) / length * width / 2];
    ground.strip(a - ex, b - ey, c + ex, d + ey, width, 0.002, LINE);
  }
  const r = world.circle_radius_m;
  ground.ring(0, 0, 0.002, r - width / 2, r + width / 2, LINE, 0, 2 * Math.PI, 72);
  for (const goal of world.goals) {
    const color = fromHex(goal.color);
    const { x_m: x, post_y_m: y, radius_m: radius, height_m: height } = goal;
    for (const side of [-y, y]) upright.stump(x, side, 0, height, radius, radius, color);
    upright.bar([x, -y, height], [x, y, height], radius, color);
    const back = x + Math.sign(x) * 0.4;
    const net = [...color.slice(0, 3), 1];
    for (const side of [-y, y]) {
      upright.bar([x, side, height], [back, side, 0.02], radius * 0.35, net);
      upright.bar([x, side, 0.02], [back, side, 0.02], radius * 0.35, net);
    }
    upright.bar([back, -y, 0.02], [back, y, 0.02], radius * 0.35, net);
  }
}

function office(world, { ground, upright }) {
  const floor = isLight() ? "#d9d2b4" : "#3a3a35";
  for (const outline of world.floors) triangulate(outline).forEach((t) => ground.fan(t, 0, fromHex(floor)));
  const wall = isLight() ? fromHex("#8c97a3") : fromHex("#a4afbb");
  // Low walls: one looks into the rooms.
  const height = 0.35;
  for (const [x0, y0, x1, y1] of world.walls) {
    upright.wall(x0, y0, x1, y1, 0, height, wall);
    ground.strip(x0, y0, x1, y1, 0.05, 0.004, wall);
  }
  for (const door of world.doors) {
    const [x0, y0, x1, y1] = door.ends;
    const length = Math.hypot(x1 - x0, y1 - y0) || 1;
    // A little in front of the wall, on the side from which it is seen.
    const [nx, ny] = [(y1 - y0) / length * 0.015, -(x1 - x0) / length * 0.015];
    const color = fromHex(door.is_open ? "#20252b" : door.color ?? "#b03030");
    upright.wall(x0 + nx, y0 + ny, x1 + nx, y1 + ny, 0, height * 1.25, color);
    ground.strip(x0 + nx, y0 + ny, x1 + nx, y1 + ny, 0.09, 0.006, color);
  }
}

/** A grid around what a camera without a map has seen. */
function space(world, { ground }) {
  const [x0, y0, x1, y1] = world.bounds_m;
  const color = isLight() ? fromHex("#c5ced8") : fromHex("#242d38");
  const z = world.floor_m ?? 0;
  const step = Math.max(0.5, Math.ceil((x1 - x0) / 24 * 2) / 2);
  for (let x = Math.ceil(x0 / step) * step; x <= x1; x += step) ground.strip(x, y0, x, y1, step * 0.02, z, color);
  for (let y = Math.ceil(y0 / step) * step; y <= y1; y += step) ground.strip(x0, y, x1, y, step * 0.02, z, color);
}

/** Triangles of a simple polygon, by cutting off ears. */
function triangulate(outline) {
  let rest = outline.map((point) => [point[0], point[1]]);
  const area = rest.reduce((sum, p, i) => {
    const q = rest[(i + 1) % rest.length];
    return sum + p[0] * q[1] - q[0] * p[1];
  }, 0);
  if (area < 0) rest = rest.reverse();
  const triangles = [];
  for (let guard = 0; rest.length > 3 && guard < 2000; guard += 1) {
    const i = rest.findIndex((_, k) => isEar(rest, k));
    if (i < 0) break;
    const [a, b, c] = corners(rest, i);
    triangles.push([a, b, c]);
    rest.splice(i, 1);
  }
  triangles.push(rest.slice(0, 3));
  return triangles;
}

const corners = (p, i) => [p[(i + p.length - 1) % p.length], p[i], p[(i + 1) % p.length]];
const turn = (a, b, c) => (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);

function isEar(polygon, i) {
  const [a, b, c] = corners(polygon, i);
  if (turn(a, b, c) <= 1e-12) return false;
  return polygon.every((p) => p === a || p === b || p === c
    || turn(a, b, p) < 0 || turn(b, c, p) < 0 || turn(c, a, p) < 0);
}
