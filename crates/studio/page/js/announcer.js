// Tells those who do not see the page what happens.

import { byId, setText } from "./dom.js";

/** Not more often, so that all is said, milliseconds. */
const EVERY_MS = 2500;

export class Announcer {
  constructor(store) {
    this.store = store;
    this.numTold = 0;
    this.toldAt = 0;
    store.on("past", () => { this.numTold = 0; });
    store.on("latest", () => this.follow());
  }

  follow() {
    const { events } = this.store;
    this.numTold = Math.min(this.numTold, events.length);
    const now = performance.now();
    if (events.length === this.numTold || now - this.toldAt < EVERY_MS) return;
    this.toldAt = now;
    const news = events.slice(Math.max(this.numTold, events.length - 3));
    this.numTold = events.length;
    setText(byId("announce"), news.map(({ secs, text }) => `${secs.toFixed(1)} seconds: ${text}`).join("; "));
  }
}
