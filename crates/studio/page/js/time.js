// The time that plots show, the moment that is pointed at, and the moment that is shown: one for time line, plots, image and world.

import { firstFrom } from "./store.js";

/** What is shown of a run that goes on, and the least that is shown of anything, seconds. */
const WINDOW_SECS = 30;
const LEAST_SECS = 0.5;
const secsOf = (row) => row.secs;

export class Time {
  /** `changed` has plots, time line and world drawn again. */
  constructor(store, socket, changed) {
    Object.assign(this, { store, socket, changed });
    this.forget();
    store.on("past", () => this.forget());
    store.on("scene", () => {
      if (store.scene.scene !== this.scene) this.forget();
      this.scene = store.scene.scene;
    });
  }

  forget() {
    /** Seconds that are shown, and where they end; `null`: all of a recording, or up to now. */
    this.width = null;
    this.end = null;
    this.pointAt(null);
  }

  rows() {
    return this.store.recording?.rows ?? this.store.past;
  }

  events() {
    return this.store.recording?.annotations ?? this.store.events;
  }

  /** The moment that is shown, seconds. */
  shown() {
    return this.store.state?.secs ?? 0;
  }

  isZoomed() {
    return this.width !== null;
  }

  /** First and last second of the plots. */
  range() {
    const rows = this.rows();
    if (rows.length === 0) return [0, WINDOW_SECS];
    const [first, last] = [rows[0].secs, rows[rows.length - 1].secs];
    if (this.store.recording && this.width === null) return [first, last];
    const end = this.end ?? (this.store.isBack ? Math.max(this.shown(), this.heldEnd ?? last) : last);
    return [end - (this.width ?? WINDOW_SECS), end];
  }

  /** Zooms about a moment, in by factors below 1. */
  zoom(factor, about = null) {
    const [from, to] = this.range();
    const rows = this.rows();
    if (rows.length === 0) return;
    const [first, last] = [rows[0].secs, rows[rows.length - 1].secs];
    const most = Math.max(last - first, this.store.recording ? LEAST_SECS : WINDOW_SECS);
    const width = Math.min(Math.max((to - from) * factor, LEAST_SECS), most);
    const isWhole = width >= most;
    const at = about ?? (this.store.recording || this.store.isBack ? this.shown() : to);
    const end = Math.min(at + (to - at) * width / (to - from), last);
    this.width = isWhole ? (this.store.recording ? null : most) : width;
    this.end = isWhole || (!this.store.recording && !this.store.isBack && end >= last - 1e-6) ? null : Math.max(end, first + width);
    this.changed();
  }

  showAll() {
    Object.assign(this, { width: null, end: null });
    this.changed();
  }

  /** Points at a moment, whose values are told, and whose places are marked in the world. */
  pointAt(secs) {
    const rows = this.rows();
    const row = secs === null || rows.length === 0 ? null : rows[this.indexOf(secs)];
    this.pointed = row ? row.secs : null;
    this.store.pointed = row && { truth: row.truth, lanes: row.lanes.map((lane) => lane.pose) };
    this.changed();
  }

  /** The row nearest to a moment. */
  indexOf(secs) {
    const rows = this.rows();
    const i = firstFrom(rows, secs, secsOf);
    return i > 0 && secs - rows[i - 1].secs < rows[i].secs - secs ? i - 1 : i;
  }

  /** Shows a moment everywhere. */
  goTo(secs) {
    const rows = this.rows();
    if (rows.length === 0) return;
    this.goToRow(this.indexOf(secs));
  }

  goToRow(index) {
    const rows = this.rows();
    const i = Math.min(Math.max(index, 0), rows.length - 1);
    if (this.store.recording) {
      this.socket.send("seek", { frame: i });
    } else {
      this.heldEnd = this.range()[1];
      this.store.lookBack(i === rows.length - 1 ? null : rows[i].number);
    }
    this.keepInSight(rows[i].secs);
    this.changed();
  }

  /** So many frames on from what is shown. */
  step(count) {
    if (this.store.recording) return this.goToRow(this.store.state.number + count);
    return this.goToRow(this.indexOf(this.shown()) + count);
  }

  now() {
    this.end = null;
    this.store.lookBack(null);
    this.changed();
  }

  keepInSight(secs) {
    const [from, to] = this.range();
    if (this.width === null || (secs >= from && secs <= to)) return;
    this.end = secs + (to - from) / 2;
  }
}
