// Reads what `robomore.rendering.packing` wrote: JSON with arrays of numbers in it.

const TYPES = { i1: Int8Array, u1: Uint8Array, i2: Int16Array, u2: Uint16Array, i4: Int32Array,
  u4: Uint32Array, f4: Float32Array };
const HEAD = 8; // `RMR1` and the length of the JSON text

export async function unpack(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const buffer = await new Response(stream).arrayBuffer();
  const length = new DataView(buffer).getUint32(4, true);
  const text = new TextDecoder().decode(new Uint8Array(buffer, HEAD, length));
  return JSON.parse(text, (key, value) => {
    if (!value || !Array.isArray(value["@"])) return value;
    const [offset, count, type] = value["@"];
    return new TYPES[type](buffer, HEAD + length + offset, count);
  });
}

// Returns what a `<script type="application/octet-stream" data-pack=NAME>` of this page holds.
export async function embedded(name) {
  const element = document.querySelector(`script[data-pack="${CSS.escape(name)}"]`);
  if (!element) return null;
  const text = atob(element.textContent.trim());
  return unpack(Uint8Array.from(text, (letter) => letter.charCodeAt(0)));
}

// Undoes `changes`: running sums of each run of `length` numbers, in the array's own type.
export function summed(array, length) {
  const sums = array.slice();
  for (let start = 0; start < sums.length; start += length) {
    for (let i = start + 1; i < start + length; i++) sums[i] += sums[i - 1];
  }
  return sums;
}
