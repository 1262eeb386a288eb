// Messages from the server: a JSON header with arrays behind it.

export const SCENE = 1;
export const STATE = 2;
export const IMAGE = 3;

const TYPES = { f32: Float32Array, u8: Uint8Array };
const text = new TextDecoder();

/** Reads a message; the arrays are views of the buffer. */
export function decode(buffer) {
  const view = new DataView(buffer);
  const kind = view.getUint8(0);
  const length = view.getUint32(4, true);
  const header = JSON.parse(text.decode(new Uint8Array(buffer, 8, length)));
  const arrays = {};
  for (const [name, [offset, count, type]] of Object.entries(header.arrays)) {
    arrays[name] = new TYPES[type](buffer, 8 + length + offset, count);
  }
  return { kind, header, arrays };
}
