// Frames of particles: the format is described in packing.rs.

/** Bytes of base64 text, decompressed. */
async function inflated(text) {
  const packed = Uint8Array.from(atob(text.trim()), (character) => character.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Numbers stored as planes of bytes, the lowest first; returns them and where the next begin. */
function planes(raw, start, count, bytes) {
  const numbers = bytes > 2 ? new Uint32Array(count) : new Uint16Array(count);
  for (let plane = 0; plane < bytes; plane++) {
    const from = start + plane * count;
    for (let i = 0; i < count; i++) numbers[i] |= raw[from + i] << (8 * plane);
  }
  return [numbers, start + bytes * count];
}

/** Running sums, in the width of the array. */
function summed(numbers) {
  for (let i = 1; i < numbers.length; i++) numbers[i] += numbers[i - 1];
  return numbers;
}

/**
 * Forecasts of a code by their names: what they take from the frame before, p, and from the one before that, q, and whether they
 * add by how much the particle before differs from that.
 */
const forecasts = [
  { from: () => 0, beside: true },
  { from: (p, q, i) => p[i], beside: false },
  { from: (p, q, i) => p[i], beside: true },
  { from: (p, q, i) => 2 * p[i] - q[i], beside: false },
  { from: (p, q, i) => 2 * p[i] - q[i], beside: true },
];

/** A frame from its bytes: groups, ids, and per column the codes of all particles; `before` are the frames before it, the latest first. */
function decoded(raw, facts, columns, before = []) {
  const count = facts.count;
  let at = 0;
  let { groups, ids } = before[0] ?? {};
  if (!before.length) {
    [groups, at] = planes(raw, at, count, 2);
    [ids, at] = planes(raw, at, count, 4);
    summed(groups);
    summed(ids);
  }
  const codes = {};
  for (const column of columns) {
    const { from, beside } = forecasts[raw[at++]];
    let folded;
    [folded, at] = planes(raw, at, count, column.bits / 8);
    const mask = column.bits === 8 ? 0xff : 0xffff;
    const [p, q] = before.map((frame) => frame.codes[column.name]);
    const list = new Uint16Array(count);
    let own = 0;
    for (let i = 0; i < count; i++) {
      const difference = folded[i] & 1 ? -((folded[i] + 1) >> 1) : folded[i] >> 1;
      own = beside ? own + difference : difference;
      list[i] = (from(p, q, i) + own) & mask;
    }
    codes[column.name] = list;
  }
  return { time: facts.time, step: facts.step, count, groups, ids, codes, columns };
}

/** The largest code of a column stands for no value. */
const noneOf = (column) => (column.bits === 8 ? 0xff : 0xffff);

/** Value of a column at a particle; NaN for none. */
function valueAt(frame, name, i) {
  const column = frame.columns.find((one) => one.name === name);
  if (!column) return NaN;
  const code = frame.codes[name][i];
  const none = noneOf(column);
  return code === none ? NaN : column.lower + (code * (column.upper - column.lower)) / (none - 1);
}

/** All values of a column as floats; NaN for none. */
function valuesOf(frame, name) {
  const values = new Float32Array(frame.count).fill(NaN);
  const column = frame.columns.find((one) => one.name === name);
  if (!column) return values;
  const none = noneOf(column);
  const quantum = (column.upper - column.lower) / (none - 1);
  const codes = frame.codes[name];
  for (let i = 0; i < frame.count; i++) if (codes[i] !== none) values[i] = column.lower + codes[i] * quantum;
  return values;
}

/** The frames of this document, one after another: each is handed over as soon as it is read. */
async function readEmbedded(run, take) {
  const elements = document.querySelectorAll("script.frame");
  let before = [];
  for (let k = 0; k < elements.length; k++) {
    const raw = await inflated(elements[k].textContent);
    elements[k].remove();
    const frame = decoded(raw, run.frames[k], run.columns, before);
    before = [frame, ...before].slice(0, 2);
    take(k, frame);
  }
}
