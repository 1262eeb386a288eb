// Messages from the server: a JSON header with arrays behind it.

export const SCENE = 1;
export const STATE = 2;
export const IMAGE = 3;

/** Bytes before the header, and the one of them that says whether the rest is packed. */
const PREFIX = 8;
const PACKING = 1;

const TYPES = { f32: Float32Array, u8: Uint8Array };
const text = new TextDecoder();

export const isPacked = (buffer) => new Uint8Array(buffer)[PACKING] === 1;

/** The same message as it was before it was packed. */
export async function unpacked(buffer) {
  if (!isPacked(buffer)) return buffer;
  const content = new Blob([new Uint8Array(buffer, PREFIX)]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  const parts = [new Uint8Array(buffer, 0, PREFIX), await new Response(content).arrayBuffer()];
  const whole = await new Blob(parts).arrayBuffer();
  new Uint8Array(whole)[PACKING] = 0;
  return whole;
}

/** Reads a message; the arrays are views of the buffer. */
export function decode(buffer) {
  const view = new DataView(buffer);
  const kind = view.getUint8(0);
  const length = view.getUint32(4, true);
  const header = JSON.parse(text.decode(new Uint8Array(buffer, PREFIX, length)));
  const arrays = {};
  for (const [name, [offset, count, type]] of Object.entries(header.arrays)) {
    arrays[name] = new TYPES[type](buffer, PREFIX + length + offset, count);
  }
  return { kind, header, arrays };
}
