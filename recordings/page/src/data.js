// The recording as the page holds it: typed arrays made from the JSON that stands in the page.

function numbers(text, Type) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  return new Type(bytes.buffer);
}

export function read(run) {
  run.t = numbers(run.t, Float64Array);
  for (const body of run.bodies) body.x = numbers(body.x, Float32Array);
  for (const signal of run.signals) signal.y = numbers(signal.y, Float32Array);
  run.signal = new Map(run.signals.map((s) => [s.group + "/" + s.name, s]));
  run.first = run.t[0];
  run.last = run.t[run.t.length - 1];
  return run;
}

// The sample at or before a time, and how far the time lies towards the next one.
export function locate(t, now) {
  let i = 0;
  let j = t.length - 1;
  while (j - i > 1) {
    const k = (i + j) >> 1;
    if (t[k] <= now) i = k;
    else j = k;
  }
  const gap = t[j] - t[i];
  return { i, j, w: gap > 0 ? Math.min(1, Math.max(0, (now - t[i]) / gap)) : 0 };
}

export const mix = (x, n, at, k) => x[n * at.i + k] * (1 - at.w) + x[n * at.j + k] * at.w;

// 75.3 s, 12:05, 1:06:04
export function clock(seconds) {
  if (seconds < 60) return seconds.toFixed(2) + " s";
  const s = Math.floor(seconds);
  const two = (x) => String(x).padStart(2, "0");
  const h = Math.floor(s / 3600);
  const m = Math.floor(s / 60) % 60;
  return (h ? h + ":" + two(m) : m) + ":" + two(s % 60);
}
