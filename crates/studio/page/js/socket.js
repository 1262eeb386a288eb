// The connection to the server. A broken one is opened again.

import { decode, isPacked, unpacked } from "./message.js";

const FIRST_WAIT_MS = 400;
const MAX_WAIT_MS = 5000;


export class Socket {
  /** `on` has `message(message)`, `pulse(busySecs)` (what the program says in between: how long its engine has answered nobody; 0 with
   * every message), `refused(reason)` (what this page asked for is not done) and `status(state, text)`; states: connecting, open, closed, refused. */
  constructor(on) {
    this.on = on;
    this.token = new URLSearchParams(location.search).get("token") ?? "";
    this.waitMs = FIRST_WAIT_MS;
    this.open();
  }

  open() {
    clearTimeout(this.timer);
    this.on.status("connecting", "connecting");
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    const socket = new WebSocket(`${scheme}://${location.host}/socket?token=${encodeURIComponent(this.token)}`);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    this.unpacking = null;
    socket.onopen = () => {
      this.waitMs = FIRST_WAIT_MS;
      this.on.status("open", "live");
    };
    socket.onmessage = (event) => {
      if (event.data instanceof ArrayBuffer) {
        this.on.pulse(0);
        this.receive(event.data);
      } else this.hear(JSON.parse(event.data));
    };
    socket.onclose = () => this.retry();
  }

  /** What comes in between states. */
  hear({ type, busy_secs: secs, reason }) {
    this.on.pulse(type === "pulse" && secs > 0 ? secs : 0);
    if (type === "refused") this.on.refused(reason);
  }

  /** Messages are read in their order; packed ones take a moment, for which those behind them wait. */
  receive(buffer) {
    if (!this.unpacking && !isPacked(buffer)) {
      this.on.message(decode(buffer));
      return;
    }
    const { socket } = this;
    const reading = Promise.resolve(this.unpacking).then(() => unpacked(buffer)).then((whole) => {
      if (this.unpacking === reading) this.unpacking = null;
      if (this.socket === socket) this.on.message(decode(whole));
    }).catch(() => socket.close());
    this.unpacking = reading;
  }

  async retry() {
    const wait = this.waitMs;
    this.waitMs = Math.min(2 * wait, MAX_WAIT_MS);
    try {
      const answer = await fetch(`/access?token=${encodeURIComponent(this.token)}`);
      if (answer.status === 403) {
        this.on.status("refused", await answer.text());
        return;
      }
    } catch {
      // Nobody there: the program has ended, or the link is broken.
    }
    this.on.status("closed", "reconnecting");
    this.timer = setTimeout(() => this.open(), wait);
  }

  useToken(token) {
    this.token = token.trim();
    this.waitMs = FIRST_WAIT_MS;
    this.open();
  }

  /** Sends a command; without a connection it is left out. */
  send(type, more = {}) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify({ type, ...more }));
  }

  /** Says that an update has been drawn, so that the next one may come. */
  drawn() {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send("drawn");
  }
}
