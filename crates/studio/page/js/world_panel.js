// What people change around the robot.

import { byId, make, setText } from "./dom.js";

export class WorldPanel {
  constructor(store, socket) {
    this.store = store;
    const light = () => socket.send("light", {
      exposure_stops: Number(this.rows.exposure_stops.input.value),
      unevenness: Number(this.rows.unevenness.input.value),
    });
    this.rows = {
      exposure_stops: row("Brightness of the image", -3, 2, 0.25, (v) => `${v > 0 ? "+" : ""}${v} stops`, light),
      unevenness: row("Unevenness of the lamps", 0, 1, 0.1, (v) => `${Math.round(100 * v)} %`, light),
      odometry_factor: row("Odometry error", 0, 5, 0.25, (v) => `${v} × usual`,
        (v) => socket.send("odometry", { factor: v })),
      num_robots: row("Other robots", 0, 8, 1, (v) => String(v), (v) => socket.send("robots", { count: v })),
    };
    byId("panel-world").replaceChildren(
      make("div", { className: "column" }, ...Object.values(this.rows).map((entry) => entry.box)),
      make("p", { className: "small" }, "Usual is an odometry whose scales are off by 5 to 10 %, and whose heading drifts by a degree a meter."));
    store.on("latest", () => this.follow());
  }

  follow() {
    const controls = this.store.latest.controls;
    if (this.store.scene?.mode !== "playground" || !controls) return;
    for (const [name, entry] of Object.entries(this.rows)) {
      if (document.activeElement !== entry.input || !entry.isDown) entry.input.value = controls[name];
      setText(entry.value, entry.format(Number(entry.input.value)));
    }
  }
}

function row(label, min, max, step, format, change) {
  const input = make("input", { type: "range", min, max, step, "aria-label": label });
  const value = make("b");
  const entry = { input, value, format, isDown: false };
  input.onpointerdown = () => { entry.isDown = true; };
  input.onpointerup = () => { entry.isDown = false; };
  input.oninput = () => setText(value, format(Number(input.value)));
  // The world is built anew, so only when the slider rests.
  input.onchange = () => change(Number(input.value));
  entry.box = make("label", { className: "row" }, make("span", {}, label, value), input);
  return entry;
}
