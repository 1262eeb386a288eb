// The course of a recording: where it is, what happened, and how to get there.

import { byId, make, setText } from "./dom.js";

const COLORS = { kidnap: "var(--warn)", lost: "var(--danger)", found: "var(--accent)", jump: "var(--c2)" };

export class Timeline {
  constructor(store, socket) {
    Object.assign(this, { store, socket });
    this.box = byId("timeline");
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
    this.label = make("b", { className: "number" });
    const { annotations } = recording;
    const marks = annotations.map((annotation) => this.button(annotation, ""));
    marks.forEach((mark, i) => { mark.style.left = `${100 * annotations[i].frame / Math.max(last, 1)}%`; });
    const events = annotations.map((annotation) => (
      this.button(annotation, `${annotation.secs.toFixed(1)} s  ${annotation.text}`)));
    const none = make("span", { className: "small", textContent: "Nothing was marked: no kidnap, no loss, no jump." });
    this.box.replaceChildren(
      make("div", { className: "track" }, make("div", { className: "marks" }, ...marks), this.slider),
      make("div", { className: "events" }, this.label, ...(events.length ? events : [none])));
  }

  button({ kind, frame, text }, label) {
    const button = make("button", { type: "button", textContent: label, title: text, vars: { "--mark": COLORS[kind] } });
    button.dataset.kind = kind;
    if (!label) button.setAttribute("aria-label", text);
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
    recording.secs = state.secs;
    if (!this.slider.matches(":active")) this.slider.value = state.number;
    setText(this.label, `${state.number + 1} of ${recording.rows.length}`);
  }

  key(event) {
    if (this.box.hidden || event.target.matches?.("input, select, textarea, [role=tab]")) return;
    const step = { ArrowLeft: -1, ArrowRight: 1, Comma: -1 }[event.code];
    if (!step) return;
    event.preventDefault();
    this.seek(Math.max(0, this.store.state.number + step * (event.shiftKey ? 30 : 1)));
  }
}

/** The course of a recording from the arrays of its scene. */
export function courseOf({ header, arrays }) {
  const { recording, plots } = header;
  const known = (value) => (Number.isNaN(value) ? null : value);
  const rows = Array.from(arrays.secs, (secs, i) => ({
    secs,
    isCarried: arrays.carried[i] > 0,
    lanes: recording.lanes.map((name, k) => {
      const [error, reliability, quality, image, ms] = arrays[`lane${k}`].subarray(5 * i, 5 * i + 5);
      return { name, error: known(error), reliability, quality, image, ms };
    }),
    values: plots?.map(({ series }, k) => series.map((_, s) => known(arrays[`plot${k}`]?.[series.length * i + s] ?? NaN))),
  }));
  return { rows, annotations: recording.annotations, label: recording.label, secs: 0 };
}
