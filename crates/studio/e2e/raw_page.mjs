// A page without a browser: a WebSocket by hand, so that a test decides when it reads.

import { randomBytes } from "node:crypto";
import { connect } from "node:net";
import { inflateRawSync } from "node:zlib";

const TEXT = 1;
const BINARY = 2;
/** Kind of a message that ends an update. */
const STATE = 2;

export class RawPage {
  /** `address` is the one that the program prints, with a token if there is one. */
  static async open(address, { reads = true } = {}) {
    const url = new URL(address);
    const socket = connect({ host: url.hostname, port: url.port });
    const page = new RawPage(socket, reads);
    const token = url.searchParams.get("token");
    socket.write([`GET /socket${token ? `?token=${token}` : ""} HTTP/1.1`, `Host: ${url.host}`, "Upgrade: websocket",
      "Connection: Upgrade", "Sec-WebSocket-Version: 13", `Sec-WebSocket-Key: ${randomBytes(16).toString("base64")}`,
      "", ""].join("\r\n"));
    await page.opened;
    return page;
  }

  constructor(socket, reads) {
    this.socket = socket;
    this.isClosed = false;
    this.bytes = 0;
    this.images = 0;
    this.updates = [];
    this.texts = [];
    this.openedAt = performance.now() / 1000;
    this.buffer = Buffer.alloc(0);
    this.opened = new Promise((resolve, reject) => {
      const refuse = () => reject(new Error("the socket was refused"));
      const onHead = (data) => {
        this.buffer = Buffer.concat([this.buffer, data]);
        const end = this.buffer.indexOf("\r\n\r\n");
        if (end < 0) return;
        socket.off("data", onHead);
        if (!this.buffer.subarray(0, end).toString().includes(" 101 ")) return refuse();
        this.buffer = this.buffer.subarray(end + 4);
        if (reads) {
          socket.on("data", (more) => this.take(more));
          this.take(Buffer.alloc(0));
        } else socket.pause();
        resolve();
      };
      socket.on("data", onHead);
      socket.on("error", refuse);
    });
    socket.on("close", () => { this.isClosed = true; });
  }

  take(data) {
    this.bytes += data.length;
    this.buffer = Buffer.concat([this.buffer, data]);
    for (let frame = this.next(); frame; frame = this.next()) {
      if (frame.code === TEXT) this.texts.push(JSON.parse(frame.body.toString()));
      if (frame.code !== BINARY) continue;
      if (frame.body[0] === STATE) {
        const content = frame.body[1] === 1 ? inflateRawSync(frame.body.subarray(8)) : frame.body.subarray(8);
        const header = JSON.parse(content.subarray(0, frame.body.readUInt32LE(4)));
        const { number, secs, is_stale: isStale, notice, drive, truth } = header;
        this.updates.push({ at: performance.now() / 1000, number, secs, isStale, notice, drive, pose: truth?.pose });
        this.send("drawn");
      } else if (frame.body[0] === 3) {
        this.firstImageAt ??= performance.now() / 1000;
        this.images += 1;
      }
    }
  }

  /** The next whole frame; the server sends them unmasked and in one piece. */
  next() {
    const { buffer } = this;
    if (buffer.length < 2) return null;
    let [length, start] = [buffer[1] & 127, 2];
    if (length === 126) {
      if (buffer.length < 4) return null;
      [length, start] = [buffer.readUInt16BE(2), 4];
    } else if (length === 127) {
      if (buffer.length < 10) return null;
      [length, start] = [Number(buffer.readBigUInt64BE(2)), 10];
    }
    if (buffer.length < start + length) return null;
    this.buffer = buffer.subarray(start + length);
    return { code: buffer[0] & 15, body: buffer.subarray(start, start + length) };
  }

  send(text) {
    const mask = randomBytes(4);
    const body = Buffer.from(text).map((byte, i) => byte ^ mask[i % 4]);
    this.socket.write(Buffer.concat([Buffer.from([0x80 | TEXT, 0x80 | body.length]), mask, body]));
  }

  get latest() {
    return this.updates[this.updates.length - 1];
  }

  close() {
    this.socket.destroy();
  }
}
