// A place on the ground without a mouse: by a cross that keys move, or by numbers.

import { byId, make, setText } from "./dom.js";

const STEP_M = 0.1;
const FAR_M = 0.5;
const TURN_RAD = Math.PI / 18;
/** Along the view: ahead and to the right. */
const KEYS = { ArrowUp: [1, 0], ArrowDown: [-1, 0], ArrowRight: [0, 1], ArrowLeft: [0, -1] };
const degrees = (rad) => Math.round(rad * 180 / Math.PI);

export class Aim {
  constructor(store, socket) {
    Object.assign(this, { store, socket });
    const input = (label, step) => make("input", { type: "number", step, value: 0, "aria-label": label, oninput: () => this.typed() });
    this.inputs = [input("x, meters", 0.1), input("y, meters", 0.1), input("heading, degrees", 5)];
  }

  /** Inputs and buttons for a panel. */
  form() {
    const labels = ["x, m", "y, m", "heading, °"];
    const button = (id, textContent, title, onclick) => make("button", { type: "button", id, textContent, title, onclick });
    const fields = this.inputs.map((input, i) => make("label", {}, labels[i], input));
    return make("fieldset", { className: "place for-playground" }, make("legend", { textContent: "A place" }), ...fields,
      button("walk-there", "Walk there", "The robot walks to this place", () => this.walk()),
      button("carry-there", "Carry there", "The robot is carried to this place", () => this.carry()));
  }

  get place() {
    const [x, y, heading] = this.inputs.map(({ value }) => Number(value) || 0);
    return [x, y, heading * Math.PI / 180];
  }

  show([x, y, yaw]) {
    const values = [x.toFixed(2), y.toFixed(2), degrees(Math.atan2(Math.sin(yaw), Math.cos(yaw)))];
    this.inputs.forEach((input, i) => { input.value = values[i]; });
    this.store.aim = this.place;
    this.store.tell("state");
    setText(byId("announce"), `x ${values[0]} m, y ${values[1]} m, heading ${values[2]} degrees`);
  }

  typed() {
    this.store.aim = this.place;
    this.store.tell("state");
  }

  end() {
    this.store.aim = null;
    if (this.store.state) this.store.tell("state");
  }

  walk() {
    const [x_m, y_m] = this.place;
    this.socket.send("walk_to", { x_m, y_m });
    this.end();
  }

  carry() {
    const [x_m, y_m, yaw_rad] = this.place;
    this.socket.send("kidnap", { x_m, y_m, yaw_rad });
    this.end();
  }

  /** Takes a key; tells whether it was one for the cross. `azimuth` is where the view looks from, radians. */
  key(event, azimuth) {
    if (this.store.scene?.mode !== "playground") return false;
    if (event.code === "KeyX") {
      if (this.store.aim) this.end();
      else this.show(this.store.latest.truth.pose);
      return true;
    }
    if (!this.store.aim) return false;
    if (event.code === "Escape") this.end();
    else if (event.code === "Enter") (event.shiftKey ? this.carry() : this.walk());
    else return this.move(event, azimuth);
    return true;
  }

  move(event, azimuth) {
    const [x, y, yaw] = this.store.aim;
    const turn = { KeyQ: TURN_RAD, KeyE: -TURN_RAD }[event.code];
    if (turn) {
      this.show([x, y, yaw + turn]);
      return true;
    }
    if (!KEYS[event.code]) return false;
    const [ahead, right] = KEYS[event.code].map((share) => share * (event.shiftKey ? FAR_M : STEP_M));
    const [c, s] = [Math.cos(azimuth), Math.sin(azimuth)];
    this.show([x - c * ahead - s * right, y - s * ahead + c * right, yaw]);
    return true;
  }
}
