// The camera by hand: image, camera and map of the moment that is shown, for a page that lays the map over the image.

import { byId } from "./dom.js";

const CIRCLE_CORNERS = 72;

/** Lines of a map through points of the world, meters: both borders of painted lines, axes of marks and goals, feet of walls, doors. */
export function mapLines(world) {
  const level = ([x0, y0, x1, y1]) => [[x0, y0, 0], [x1, y1, 0]];
  const frame = ([x0, y0, x1, y1], height) => [[x0, y0, 0], [x0, y0, height], [x1, y1, height], [x1, y1, 0]];
  if (world.kind === "office") {
    return [...world.walls.map(level), ...world.doors.map(({ ends, height_m }) => frame(ends, height_m))];
  }
  const half = world.line_width_m / 2;
  const borders = world.lines.flatMap(([x0, y0, x1, y1]) => {
    const length = Math.hypot(x1 - x0, y1 - y0), [ax, ay] = [(x1 - x0) / length * half, (y1 - y0) / length * half];
    // Outer borders of two lines that meet end in the corner that is seen.
    return [-1, 1].map((side) => (
      level([x0 - side * ay - ax, y0 + side * ax - ay, x1 - side * ay + ax, y1 + side * ax + ay])));
  });
  const circles = [-half, half].map((more) => Array.from({ length: CIRCLE_CORNERS + 1 }, (_, i) => {
    const angle = 2 * Math.PI * i / CIRCLE_CORNERS;
    return [(world.circle_radius_m + more) * Math.cos(angle), (world.circle_radius_m + more) * Math.sin(angle), 0];
  }));
  const goals = world.goals.map(({ x_m, post_y_m, height_m }) => frame([x_m, -post_y_m, x_m, post_y_m], height_m));
  return [...borders, ...circles, ...world.marks.map(level), ...goals];
}

/** Pose of the camera in the world as the page by hand takes it, for a robot at x, y, yaw. */
export function cameraPose([x, y, yaw], [ahead, left, height, heading, pitch, roll]) {
  const [cos, sin] = [Math.cos(yaw), Math.sin(yaw)];
  const deg = (yaw * 180 / Math.PI + heading + 540) % 360 - 180;
  return [x + cos * ahead - sin * left, y + sin * ahead + cos * left, height, deg, pitch, roll];
}

export class ByHand {
  constructor(store) {
    this.store = store;
    this.button = byId("by-hand");
    this.button.onclick = () => {
      this.asked = this.moment();
      // The page asks for it when it has been loaded.
      if (this.asked) open("/by-hand.html");
    };
    for (const what of ["scene", "state", "image"]) store.on(what, () => { this.button.hidden = !this.moment(); });
  }

  /** What is shown, if there is an image of a known camera on a map. */
  moment() {
    const { scene, state, image } = this.store;
    const isMap = ["field", "office"].includes(scene?.world?.kind);
    return isMap && state?.lens && image?.arrays.jpeg ? { scene, state, image } : null;
  }

  /** For the page that was opened last. */
  input() {
    const { scene, state, image } = this.asked;
    const robot = state.contenders.find(({ is_localized }) => is_localized) ?? state.contenders[0];
    return {
      name: `${scene.world.name}, ${state.secs.toFixed(2)} s`,
      image: URL.createObjectURL(new Blob([image.arrays.jpeg], { type: "image/jpeg" })),
      camera: state.lens,
      pose: cameraPose(robot?.pose ?? [0, 0, 0], state.mount),
      lines: mapLines(scene.world),
    };
  }
}
