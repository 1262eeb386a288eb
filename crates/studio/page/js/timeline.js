// The course of a recording: where it is, what happened, and how to get there.

import { byId, make, setText } from "./dom.js";

const COLORS = { kidnap: "var(--warn)", lost: "var(--danger)", found: "var(--accent)", jump: "var(--c2)" };

export class Timeline {
  constructor(store, socket, time) {
    Object.assign(this, { store, socket, time });
    this.box = byId("timeline");
    this.pointer = make("i");
    store.on("scene", () => this.rebuild());
    store.on("state", () => this.follow());
    addEventListener("keydown", (event) => this.key(event));
  }

  rebuild() {
    const { recording } = this.store;
    this.box.hidden = !recording;
    if (!recording) return;
    const last = recording.rows.length - 1;
    this.slider = make("input", { type: "range", min: 0, max: last, step: 1, value: 0, "aria-label": "Frame" });
    this.slider.oninput = () => this.seek(Number(this.slider.value));
    this.slider.onpointermove = (event) => {
      const box = this.slider.getBoundingClientRect();
      const share = (event.clientX - box.left - 8) / (box.width - 16);
      this.time.pointAt(recording.rows[Math.round(Math.min(Math.max(share, 0), 1) * last)].secs);
    };
    this.slider.onpointerleave = () => this.time.pointAt(null);
    this.label = make("b", { className: "number" });
    const { annotations } = recording;
    const marks = annotations.map((annotation) => this.button(annotation, ""));
    marks.forEach((mark, i) => { mark.style.left = `${100 * annotations[i].frame / Math.max(last, 1)}%`; });
    const events = annotations.map((annotation) => (
      this.button(annotation, `${annotation.secs.toFixed(1)} s  ${annotation.text}`)));
    const none = make("span", { className: "small", textContent: "Nothing was marked: no kidnap, no loss, no jump." });
    this.box.replaceChildren(
      make("div", { className: "track" }, make("div", { className: "marks" }, ...marks, this.pointer), this.slider),
      make("div", { className: "where" }, this.label, make("div", { className: "events" }, ...(events.length ? events : [none]))));
  }

  /** The moment that is pointed at. */
  draw() {
    const { pointed } = this.time;
    const rows = this.store.recording?.rows;
    this.pointer.hidden = pointed === null || !rows;
    if (!this.pointer.hidden) this.pointer.style.left = `${100 * this.time.indexOf(pointed) / Math.max(rows.length - 1, 1)}%`;
  }

  button({ kind, frame, text }, label) {
    const button = make("button", { type: "button", textContent: label, title: text, vars: { "--mark": COLORS[kind] } });
    button.dataset.kind = kind;
    // The list below says the same.
    if (!label) Object.assign(button, { tabIndex: -1, ariaHidden: "true" });
    // A little before, so that one sees it happen.
    button.onclick = () => this.seek(Math.max(0, frame - (label ? 3 : 0)));
    return button;
  }

  seek(frame) {
    this.socket.send("seek", { frame });
  }

  follow() {
    const { recording, state } = this.store;
    if (!recording || !this.slider) return;
    if (!this.slider.matches(":active")) this.slider.value = state.number;
    this.slider.setAttribute("aria-valuetext", `${state.secs.toFixed(1)} s, frame ${state.number + 1} of ${recording.rows.length}`);
    setText(this.label, `${state.number + 1} of ${recording.rows.length}`);
  }

  key(event) {
    if (this.box.hidden || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.target.matches?.("input, select, textarea, [role=tab], [role=tabpanel]")) return;
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.code];
    if (!step) return;
    event.preventDefault();
    this.time.step(step * (event.shiftKey ? 30 : 1));
  }
}

/** The course of a recording from the arrays of its scene. */
export function courseOf({ header, arrays }) {
  const { recording, plots } = header;
  const known = (value) => (Number.isNaN(value) ? null : value);
  const pose = (values, i) => (values && !Number.isNaN(values[3 * i]) ? values.subarray(3 * i, 3 * i + 3) : null);
  const rows = Array.from(arrays.secs, (secs, i) => ({
    secs,
    truth: pose(arrays.places, i),
    isCarried: arrays.carried[i] > 0,
    lanes: recording.lanes.map((name, k) => {
      const [error, reliability, quality, image, ms] = arrays[`lane${k}`].subarray(5 * i, 5 * i + 5);
      return { name, pose: pose(arrays[`pose${k}`], i), error: known(error), reliability, quality, image, ms };
    }),
    values: plots?.map(({ series }, k) => series.map((_, s) => known(arrays[`plot${k}`]?.[series.length * i + s] ?? NaN))),
  }));
  return { rows, annotations: recording.annotations, label: recording.label };
}
