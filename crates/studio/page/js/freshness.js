// Whether what is shown is true now. A program that does not answer is stale, and the page says so within 1.5 s; a paused one and a
// source that has nothing new are not.

import { byId, setText } from "./dom.js";

/** What has not answered for so long is stale, seconds; as in pulse.rs. */
const STALE_SECS = 1;
/** From this time on the page says that there is no new image, seconds. */
const QUIET_SECS = 2;
const CHECK_MS = 200;

/** What the page says of its link, as state and text; all times in seconds. `sinceHeard`: since anything came; `busy`: how long the
 * engine had answered nobody then; `sinceState`: since the last state came. */
export function freshness(state, { sinceHeard, busy, sinceState }) {
  const whole = (secs) => `${Math.floor(secs)} s`;
  const stale = sinceHeard + busy;
  if (stale > STALE_SECS) return { state: "stale", text: `stale for ${whole(stale)}`, secs: stale, who: "The program" };
  if (state?.is_stale) {
    const secs = (state.stale_secs ?? 0) + (state.stale_secs ? sinceState : 0);
    const text = state.stale_secs ? `stale for ${whole(secs)}` : "robot out of reach";
    return { state: "stale", text, secs, who: "The robot" };
  }
  if (state && !state.is_playing) return { state: "open", text: "paused" };
  if (state && sinceState > QUIET_SECS) return { state: "open", text: `no new image for ${whole(sinceState)}` };
  return { state: "open", text: "live" };
}

export class Freshness {
  constructor(store) {
    this.store = store;
    this.isOpen = false;
    this.hear(0);
    this.stateAt = this.heardAt;
    store.on("latest", () => {
      this.stateAt = performance.now();
      this.show();
    });
    setInterval(() => this.show(), CHECK_MS);
  }

  /** Something has come from the program, whose engine had answered nobody for so long, seconds. */
  hear(busySecs) {
    this.heardAt = performance.now();
    this.busySecs = busySecs;
  }

  /** The connection is open, or not any more: then others say so. */
  setOpen(isOpen) {
    this.isOpen = isOpen;
    this.hear(0);
    this.stateAt = this.heardAt;
    this.show();
  }

  show() {
    const now = performance.now();
    const since = (at) => (now - at) / 1000;
    const times = { sinceHeard: since(this.heardAt), busy: this.busySecs, sinceState: since(this.stateAt) };
    const is = this.isOpen && this.store.latest ? freshness(this.store.latest, times) : null;
    const isStale = is?.state === "stale";
    document.body.toggleAttribute("data-stale", isStale);
    const box = byId("stale");
    box.hidden = !isStale;
    if (!is) return;
    const link = byId("link");
    link.dataset.state = is.state;
    setText(link, is.text);
    if (isStale) {
      const age = is.secs >= 1 ? ` for ${Math.floor(is.secs)} s` : "";
      setText(box, `Stale: ${is.who.toLowerCase()} has not answered${age}. What is shown is from before.`);
    }
  }
}
