// The run as the page holds it: columns of numbers that may grow, and what happened when.

export function numbers(text, Type) {
  const letters = atob(text);
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = letters.charCodeAt(i);
  return new Type(bytes.buffer);
}

// Numbers that travel deflated, first bytes of all first, then second bytes of all, ...
async function unpacked(text, Type) {
  const stream = new Blob([numbers(text, Uint8Array)]).stream().pipeThrough(new DecompressionStream("deflate"));
  const planes = new Uint8Array(await new Response(stream).arrayBuffer());
  const size = Type.BYTES_PER_ELEMENT;
  const n = planes.length / size;
  const bytes = new Uint8Array(planes.length);
  for (let k = 0; k < size; k++) for (let i = 0, at = k * n; i < n; i++) bytes[size * i + k] = planes[at + i];
  return new Type(bytes.buffer);
}

// Numbers, `n` in a row of this column, with room for more.
class Column {
  constructor(n, Type = Float32Array) {
    this.n = n;
    this.rows = 0;
    this.room = new Type(n * 256);
  }

  // Row r takes values of `from` that stand at offset + r * stride.
  extend(rows, from, offset, stride) {
    const need = this.n * (this.rows + rows);
    if (need > this.room.length) {
      const room = new this.room.constructor(Math.max(need, 2 * this.room.length));
      room.set(this.room);
      this.room = room;
    }
    let at = this.n * this.rows;
    for (let r = 0; r < rows; r++) for (let k = 0; k < this.n; k++) this.room[at++] = from[offset + r * stride + k];
    this.rows += rows;
    return this.room.subarray(0, this.n * this.rows);
  }
}

export class Run {
  constructor(head) {
    Object.assign(this, head);
    this.time = new Column(1, Float64Array);
    this.t = new Float64Array(0);
    for (const body of this.bodies) Object.assign(body, { column: new Column(7), x: new Float32Array(0) });
    for (const signal of this.signals) Object.assign(signal, { column: new Column(1), y: new Float32Array(0) });
    this.signal = new Map(this.signals.map((s) => [s.group + "/" + s.name, s]));
    this.body = new Map(this.bodies.map((b) => [b.name, b]));
    if (head.rows) this.extend(head.rows);
  }

  extend({ t, x }) {
    const times = numbers(t, Float64Array);
    const values = numbers(x, Float32Array);
    const stride = 7 * this.bodies.length + this.signals.length;
    this.t = this.time.extend(times.length, times, 0, 1);
    this.bodies.forEach((body, i) => (body.x = body.column.extend(times.length, values, 7 * i, stride)));
    const start = 7 * this.bodies.length;
    this.signals.forEach((s, i) => (s.y = s.column.extend(times.length, values, start + i, stride)));
  }

  // The finer level of a long recording in place of the coarse one, which is seen at once.
  async refine() {
    if (!this.detail) return false;
    const [t, x] = await Promise.all([unpacked(this.detail.t, Float64Array), unpacked(this.detail.x, Float32Array)]);
    const n = t.length;
    this.t = t;
    this.bodies.forEach((body, i) => {
      body.x = new Float32Array(7 * n);
      for (let k = 0; k < 7; k++) for (let r = 0, from = (7 * i + k) * n; r < n; r++) body.x[7 * r + k] = x[from + r];
    });
    this.signals.forEach((signal, i) => (signal.y = x.subarray((7 * this.bodies.length + i) * n, (7 * this.bodies.length + i + 1) * n)));
    this.detail = null;
    return true;
  }

  // A time as a clock tells it: 1:02.50 in a short run, 12:05, 1:06:04.
  clock(t) {
    return clock(t, this.last < 120 ? 2 : 0);
  }

  // What a rope carried at most as a share of what it may carry; 0 where nobody has said how much.
  use(rope) {
    const signal = this.signal.get("rope/tension/" + rope);
    const rated = this.rated[rope];
    if (!signal || !rated) return 0;
    let most = 0;
    for (const tension of signal.y) if (tension > most) most = tension;
    return most / rated;
  }

  get first() {
    return this.t[0] ?? 0;
  }

  get last() {
    return this.t[this.t.length - 1] ?? 0;
  }
}

// The sample at or before a time, and how far the time lies towards the next one.
export function locate(t, now) {
  let i = 0;
  let j = Math.max(0, t.length - 1);
  while (j - i > 1) {
    const k = (i + j) >> 1;
    if (t[k] <= now) i = k;
    else j = k;
  }
  const gap = t[j] - t[i];
  return { i, j, w: gap > 0 ? Math.min(1, Math.max(0, (now - t[i]) / gap)) : 0 };
}

export const mix = (x, n, at, k) => x[n * at.i + k] * (1 - at.w) + x[n * at.j + k] * at.w;

// The last one of things with a time `t`, in order, that is not after now; -1 if there is none.
export function lastBefore(things, now) {
  let low = 0;
  let high = things.length;
  while (low < high) {
    const k = (low + high) >> 1;
    if (things[k].t <= now) low = k + 1;
    else high = k;
  }
  return low - 1;
}

// Steps between the marks of an axis of time [s], and what stands at them.
const STEPS_s = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 14400, 36000, 86400];
export const timeAxis = { incrs: STEPS_s, values: (plot, at, i, room, step) => at.map((t) => clock(t, step >= 1 ? 0 : 2)) };

// 1:15, 1:06:04, with digits behind the second 1:15.30
export function clock(seconds, digits = 0) {
  const unit = 10 ** digits;
  const ticks = Math.round(seconds * unit);
  const two = (x) => String(x).padStart(2, "0");
  const h = Math.floor(ticks / (3600 * unit));
  const m = Math.floor(ticks / (60 * unit)) % 60;
  const rest = ((ticks % (60 * unit)) / unit).toFixed(digits).padStart(digits ? 3 + digits : 2, "0");
  return (h ? h + ":" + two(m) : m) + ":" + rest;
}
