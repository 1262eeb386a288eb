// Driving: keys, an on-screen pad, and the head. A robot elsewhere moves only while a key or the pad is held.

import { byId, make, setText } from "./dom.js";

const PAD = [["q", "⟲", "Turn left", "KeyA"], ["w", "↑", "Ahead", "KeyW"], ["e", "⟳", "Turn right", "KeyD"],
  ["a", "←", "Left", "KeyQ"], ["s", "↓", "Back", "KeyS"], ["d", "→", "Right", "KeyE"]];
/** Shares of the greatest speeds: forward, left, turn. */
const KEYS = {
  KeyW: [1, 0, 0], ArrowUp: [1, 0, 0], KeyS: [-0.7, 0, 0], ArrowDown: [-0.7, 0, 0],
  KeyA: [0, 0, 1], ArrowLeft: [0, 0, 1], KeyD: [0, 0, -1], ArrowRight: [0, 0, -1],
  KeyQ: [0, 1, 0], KeyE: [0, -1, 0],
};

/** Why the robot stands is read for so long, milliseconds. */
const REFUSED_MS = 3000;
/** A robot elsewhere is told so often that a key is still held, milliseconds. */
const REPEAT_MS = 100;

const isEnter = ({ code }) => code === "Enter" || code === "Space";

export class DrivePanel {
  constructor(store, socket, aim) {
    Object.assign(this, { store, socket, aim });
    this.down = new Set();
    this.status = make("p", { className: "small for-away", id: "driver" });
    const buttons = PAD.map(([, text, label, code]) => this.button(text, label, code));
    this.head = this.slider("Head to the left", "°", -90, 90, 1);
    this.tilt = this.slider("Head down", "°", -20, 45, 1);
    this.auto = make("input", { type: "checkbox", checked: true });
    this.auto.onchange = () => this.sendHead();
    this.felt = make("input", { type: "checkbox", checked: true });
    this.felt.onchange = () => socket.send("felt", { is_on: this.felt.checked });
    byId("panel-drive").replaceChildren(make("div", { className: "drive" },
      make("div", { className: "pad", role: "group", "aria-label": "Drive" }, ...buttons),
      make("div", { className: "column" },
        make("label", { className: "check" }, this.auto, "Head scans by itself"), this.head.row, this.tilt.row)),
    make("label", { className: "check for-playground", title: "If not, pressure under the feet stays normal: the robot has to notice by its images" },
      this.felt, "Feet notice that the robot is carried"),
    aim.form(),
    this.status,
    make("p", { className: "small only-keys for-playground" }, "Keys: W A S D or arrows drive, Q and E go sideways, K kidnaps, X aims at a place."),
    make("p", { className: "small only-keys for-away" }, "Keys: hold W A S D or arrows to drive, Q and E to go sideways; let go and the robot stands."));
    store.on("latest", () => this.follow());
    addEventListener("blur", () => this.releaseAll());
    document.addEventListener("visibilitychange", () => this.releaseAll());
    setInterval(() => this.isAway && this.down.size > 0 && this.send(), REPEAT_MS);
  }

  /** Whether a robot elsewhere is driven. */
  get isAway() {
    return this.store.scene?.mode === "watch" && Boolean(this.store.latest?.drive);
  }

  /** Whether there is anything to drive. */
  get isUsable() {
    return this.store.scene?.mode === "playground" || this.isAway;
  }

  button(text, label, code) {
    const button = make("button", { type: "button", textContent: text, "aria-label": label, title: label });
    const press = (isDown) => {
      button.classList.toggle("is-down", isDown);
      this.press(code, isDown);
    };
    button.onpointerdown = (event) => {
      button.setPointerCapture(event.pointerId);
      press(true);
    };
    button.onpointerup = button.onpointercancel = button.onlostpointercapture = () => press(false);
    button.oncontextmenu = (event) => event.preventDefault();
    button.onkeydown = (event) => isEnter(event) && !event.repeat && press(true);
    button.onkeyup = (event) => isEnter(event) && press(false);
    return button;
  }

  slider(label, unit, min, max, step) {
    const input = make("input", { type: "range", min, max, step, value: 0, "aria-label": label });
    const value = make("b");
    input.oninput = () => {
      this.auto.checked = false;
      this.sendHead();
    };
    return { input, value, unit, row: make("label", { className: "row" }, make("span", {}, label, value), input) };
  }

  sendHead() {
    const angles = { yaw_deg: Number(this.head.input.value), pitch_deg: Number(this.tilt.input.value) };
    this.socket.send("head", this.auto.checked ? {} : angles);
  }

  /** Takes a key; tells whether it drives. */
  press(code, isDown) {
    if (!KEYS[code]) return false;
    if (isDown === this.down.has(code)) return true;
    if (isDown) this.down.add(code);
    else this.down.delete(code);
    this.send();
    return true;
  }

  /** The robot does not do it: whoever wants to go on presses again. */
  refuse(reason) {
    this.down.clear();
    setText(this.status, reason);
    this.refusedUntil = performance.now() + REFUSED_MS;
  }

  releaseAll() {
    if (this.down.size === 0) return;
    this.down.clear();
    this.send();
  }

  send() {
    const sum = [0, 0, 0];
    for (const code of this.down) KEYS[code].forEach((value, i) => { sum[i] += value; });
    const [forward, left, turn] = sum.map((value) => Math.min(Math.max(value, -1), 1));
    const drive = this.isAway && this.store.latest.drive;
    // A robot elsewhere goes by what its driver sees now.
    this.socket.send("drive", { forward, left, turn, ...(drive && { seen_secs: drive.secs }) });
  }

  follow() {
    document.body.toggleAttribute("data-away", this.isAway);
    if (this.isAway) this.followAway(this.store.latest);
    const controls = this.store.latest.controls;
    if (this.store.scene?.mode !== "playground" || !controls) return;
    this.felt.checked = controls.is_felt;
    const isActive = [this.head.input, this.tilt.input].includes(document.activeElement);
    if (!isActive) this.auto.checked = controls.head === null;
    const { camera } = this.store.latest;
    const angles = controls.head ?? [camera ? camera[0] * 180 / Math.PI : 0, Number(this.tilt.input.value)];
    [this.head, this.tilt].forEach((slider, i) => {
      if (document.activeElement !== slider.input) slider.input.value = angles[i];
      setText(slider.value, controls.head || i === 0 ? `${Math.round(angles[i])}${slider.unit}` : "by itself");
    });
  }

  followAway({ drive, is_playing: isPlaying }) {
    const isActive = [this.head.input, this.tilt.input].includes(document.activeElement);
    if (!isActive && document.activeElement !== this.auto) this.auto.checked = drive.head_deg === null;
    [this.head, this.tilt].forEach((slider, i) => {
      if (drive.head_deg && document.activeElement !== slider.input) slider.input.value = drive.head_deg[i];
      setText(slider.value, drive.head_deg ? `${Math.round(drive.head_deg[i])}${slider.unit}` : "by itself");
    });
    if (performance.now() < (this.refusedUntil ?? 0)) return;
    const limits = `at most ${drive.speed_m_per_s.toFixed(2)} m/s and ${Math.round(drive.turn_deg_per_s)}° a second`;
    const lag = drive.lag_secs === null ? "" : `, what they see is ${drive.lag_secs.toFixed(2)} s old`;
    let text = `Nobody drives: hold a key or the pad; ${limits}.`;
    if (!isPlaying) text = "Paused: the robot is driven by what is seen. Play first.";
    else if (drive.is_driven) text = `${drive.driver} drives${lag}; ${limits}.`;
    setText(this.status, text);
  }
}
