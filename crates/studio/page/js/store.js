// What the page knows: the scene, the latest state and image, and the past for trails and plots.

import { IMAGE, SCENE } from "./message.js";
import { courseOf } from "./timeline.js";

/** Frames that are kept: 100 seconds at 30 a second. */
const MAX_PAST = 3000;

export class Store {
  constructor() {
    this.scene = null;
    this.state = null;
    this.arrays = {};
    this.image = null;
    this.past = [];
    this.listeners = { scene: [], state: [], image: [], past: [] };
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
      this.image = { header, arrays };
      this.tell("image");
      return false;
    }
    this.state = header;
    this.arrays = arrays;
    this.remember(header);
    this.tell("state");
    return true;
  }

  forget() {
    this.past = [];
    this.tell("past");
  }

  remember(state) {
    const last = this.past[this.past.length - 1];
    if (last && state.number < last.number) {
      this.forget();
    } else if (last && state.number === last.number) {
      return;
    }
    this.past.push({
      number: state.number,
      secs: state.secs,
      truth: state.truth?.pose ?? null,
      isCarried: (state.truth?.height_m ?? 0) > 0,
      lanes: (state.contenders ?? []).map((contender) => ({
        name: contender.name,
        pose: contender.pose,
        error: contender.error?.[0] ?? null,
        turn: contender.error?.[1] ?? null,
        reliability: contender.reliability,
        quality: contender.quality,
        image: contender.ms.image,
        ms: contender.ms.image + contender.ms.pose,
      })),
      values: state.values ?? null,
    });
    if (this.past.length > MAX_PAST) this.past.splice(0, MAX_PAST / 10);
  }
}
