// The run as the page holds it: columns of numbers that may grow, and what happened when.

function numbers(text, Type) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
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

// 75.3 s, 12:05, 1:06:04
export function clock(seconds) {
  if (seconds < 60) return seconds.toFixed(2) + " s";
  const s = Math.floor(seconds + 1e-6);
  const two = (x) => String(x).padStart(2, "0");
  const h = Math.floor(s / 3600);
  const m = Math.floor(s / 60) % 60;
  return (h ? h + ":" + two(m) : m) + ":" + two(s % 60);
}
