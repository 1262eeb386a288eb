// A slow link: passes TCP on with so many bytes a second in each direction, and holds no more than a small buffer.

import { connect, createServer } from "node:net";

const TICK_MS = 20;
const MAX_HELD = 4096;

/** The port of a link to a port of this computer. `delayMs` is the time of the way, for each piece. */
export async function slowLink(port, bytesPerSecond, delayMs = 30) {
  const server = createServer((near) => {
    const far = connect({ host: "127.0.0.1", port });
    const pipes = [pipe(near, far, bytesPerSecond, delayMs), pipe(far, near, bytesPerSecond, delayMs)];
    const end = () => {
      pipes.forEach((stop) => stop());
      near.destroy();
      far.destroy();
    };
    for (const socket of [near, far]) {
      socket.setNoDelay(true);
      socket.on("error", end);
      socket.on("close", end);
    }
  });
  await new Promise((resolve) => { server.listen(0, "127.0.0.1", resolve); });
  return { port: server.address().port, close: () => server.close() };
}

function pipe(from, to, bytesPerSecond, delayMs) {
  let held = Buffer.alloc(0);
  let credit = 0;
  from.on("data", (data) => {
    held = Buffer.concat([held, data]);
    if (held.length > MAX_HELD) from.pause();
  });
  const timer = setInterval(() => {
    credit = Math.min(credit + bytesPerSecond * TICK_MS / 1000, bytesPerSecond / 10);
    const count = Math.min(Math.floor(credit), held.length);
    if (count === 0) return;
    const piece = held.subarray(0, count);
    held = held.subarray(count);
    credit -= count;
    setTimeout(() => to.writable && to.write(piece), delayMs);
    if (held.length <= MAX_HELD) from.resume();
  }, TICK_MS);
  return () => clearInterval(timer);
}
