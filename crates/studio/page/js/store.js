// What the page knows: the scene, the latest state and image, and the past for trails, plots and looks back.

import { IMAGE, SCENE } from "./message.js";
import { courseOf } from "./timeline.js";

/** Frames that are kept as numbers: 100 seconds at 30 a second. */
const MAX_PAST = 3000;
/** So much of the past can be looked at again in full, bytes. */
const MAX_HISTORY_BYTES = 48 << 20;
const MAX_EVENTS = 300;

const sizeOf = (arrays) => Object.values(arrays).reduce((sum, { byteLength }) => sum + byteLength, 0);

export class Store {
  constructor() {
    this.scene = null;
    /** The newest state; `state`, `arrays` and `image` are what is shown, which may be of the past. */
    this.latest = null;
    this.state = null;
    this.arrays = {};
    this.image = null;
    this.past = [];
    this.events = [];
    this.history = [];
    this.historyBytes = 0;
    this.isBack = false;
    this.listeners = { scene: [], latest: [], state: [], image: [], past: [] };
  }

  on(what, listener) {
    this.listeners[what].push(listener);
  }

  tell(what) {
    for (const listener of this.listeners[what]) listener(this);
  }

  /** Takes in a message; tells whether it was a state. */
  take({ kind, header, arrays }) {
    if (kind === SCENE) {
      const isOther = this.scene?.scene !== header.scene || this.scene?.seed !== header.seed;
      this.scene = header;
      this.recording = header.recording ? courseOf({ header, arrays }) : null;
      if (isOther) this.forget();
      this.tell("scene");
      return false;
    }
    if (kind === IMAGE) {
      this.newImage = { header, arrays };
      if (!this.isBack) this.show({ image: this.newImage });
      return false;
    }
    this.latest = header;
    this.newArrays = arrays;
    this.remember(header, arrays);
    if (!this.isBack) this.show({ state: header, arrays });
    this.tell("latest");
    return true;
  }

  show({ state, arrays, image }) {
    if (image && image !== this.image) {
      this.image = image;
      this.tell("image");
    }
    if (!state) return;
    this.state = state;
    this.arrays = arrays;
    this.tell("state");
  }

  /** Shows a moment of the past again, or what is now (`null`). */
  lookBack(number) {
    const moment = number === null ? null : this.history[firstFrom(this.history, number, ({ state }) => state.number)];
    this.isBack = Boolean(moment) && moment !== this.history[this.history.length - 1];
    document.body.toggleAttribute("data-back", this.isBack);
    if (this.isBack) this.show(moment);
    else if (this.latest) this.show({ state: this.latest, arrays: this.newArrays, image: this.newImage });
  }

  /** Frames up to the one that is shown. */
  pastUntilShown() {
    if (!this.isBack) return this.past;
    return this.past.slice(0, firstFrom(this.past, this.state.number, (row) => row.number) + 1);
  }

  forget() {
    this.past = [];
    this.events = [];
    this.history = [];
    this.historyBytes = 0;
    this.lookBack(null);
    this.tell("past");
  }

  remember(state, arrays) {
    const last = this.past[this.past.length - 1];
    if (last && state.number < last.number) this.forget();
    else if (last && state.number === last.number) return;
    const row = rowOf(state);
    if (last) this.events.push(...eventsBetween(last, row));
    if (this.events.length > MAX_EVENTS) this.events.splice(0, MAX_EVENTS / 10);
    this.past.push(row);
    if (this.past.length > MAX_PAST) this.past.splice(0, MAX_PAST / 10);
    if (!this.recording) this.keep({ state, arrays, image: this.newImage });
  }

  keep(moment) {
    const bytes = sizeOf(moment.arrays) + (moment.image ? sizeOf(moment.image.arrays) : 0) + 4096;
    this.history.push({ ...moment, bytes });
    this.historyBytes += bytes;
    let num = 0;
    while (this.historyBytes > MAX_HISTORY_BYTES && num + 1 < this.history.length) {
      this.historyBytes -= this.history[num].bytes;
      num += 1;
    }
    // Many at once, since the rest moves.
    if (num > 0) this.history.splice(0, num);
  }
}

function rowOf(state) {
  return {
    number: state.number,
    secs: state.secs,
    truth: state.truth?.pose ?? null,
    /** Of all robots, where several are. */
    truths: state.team?.robots.map(({ truth }) => truth) ?? [state.truth?.pose],
    isCarried: (state.truth?.height_m ?? 0) > 0,
    isLost: Boolean(state.is_lost),
    lanes: (state.contenders ?? []).map((contender) => ({
      name: contender.name,
      pose: contender.pose,
      isLocalized: contender.is_localized,
      error: contender.error?.[0] ?? null,
      turn: contender.error?.[1] ?? null,
      reliability: contender.reliability,
      quality: contender.quality,
      image: contender.ms.image,
      ms: contender.ms.image + contender.ms.pose,
    })),
    values: state.values ?? null,
  };
}

/** What has happened from one frame to the next. */
function eventsBetween(before, row) {
  const events = [];
  const add = (kind, text) => events.push({ kind, text, secs: row.secs, frame: row.number });
  if (row.isCarried && !before.isCarried) add("kidnap", "taken up");
  if (!row.isCarried && before.isCarried) add("kidnap", "put down");
  if (row.isLost !== before.isLost) add(row.isLost ? "lost" : "found", row.isLost ? "lost" : "found again");
  row.lanes.forEach((lane, k) => {
    const was = before.lanes[k];
    if (was?.name !== lane.name || was.isLocalized === lane.isLocalized) return;
    add(lane.isLocalized ? "found" : "lost", `${lane.name} ${lane.isLocalized ? "localized" : "lost"}`);
  });
  return events;
}

/** The first entry whose key is at least so large; the last one if there is none. */
export function firstFrom(entries, key, keyOf) {
  let [low, high] = [0, Math.max(0, entries.length - 1)];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (keyOf(entries[middle]) < key) low = middle + 1;
    else high = middle;
  }
  return low;
}
