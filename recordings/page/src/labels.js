// What is written over the scene: names, loads of ropes, centre of gravity and lugs, dimensions. A canvas of its own, so
// letters are sharp however coarse the scene is drawn; what would cover something more important is left out.
import { Box3, Vector3 } from "three";
import { mix } from "./data.js";

const INKS = { light: { ink: "#1d2733", halo: "#ffffffd9", mark: "#a3182b" }, dark: { ink: "#e6edf3", halo: "#12181fd9", mark: "#ff8b80" } };
const FONT = "12px system-ui, sans-serif";
const SHORT = 24; // [pixel] a length that looks shorter has no dimension
const BESIDE = 8; // [pixel] between a point and what is written beside it
const LOW = 0.05; // [m] above the ground that are told

export class Labels {
  constructor(host, run, matrix) {
    Object.assign(this, { host, run, matrix, theme: "light", on: new Set(["names", "loads", "gravity"]) });
    this.canvas = document.createElement("canvas");
    this.canvas.className = "labels";
    host.append(this.canvas);
    this.names = this.named();
  }

  // One name for each machine: behind the last dot where all are parts of one, before the first where there are several.
  named() {
    const drawn = this.run.bodies.filter((b) => this.run.boxes.some((box) => box.body === b.name));
    const machines = new Set(drawn.map((b) => b.name.split(".")[0]));
    const found = new Map();
    for (const { name } of drawn) {
      const told = machines.size > 1 ? name.split(".")[0] : name.split(".").at(-1);
      const boxes = this.run.boxes.filter((box) => box.body === name);
      const high = boxes.reduce((a, b) => (b.centre[2] + b.size[2] / 2 > a.centre[2] + a.size[2] / 2 ? b : a));
      const p = [high.centre[0], high.centre[1], high.centre[2] + high.size[2] / 2];
      if (!found.has(told)) found.set(told, { text: told, body: name, p });
    }
    const blocks = (x) => (x.body === this.run.block?.name ? 0 : 1);
    return [...found.values()].sort((a, b) => blocks(a) - blocks(b));
  }

  resize(w, h) {
    const ratio = Math.min(2, devicePixelRatio);
    Object.assign(this.canvas, { width: w * ratio, height: h * ratio });
    Object.assign(this.canvas.style, { width: w + "px", height: h + "px" });
    Object.assign(this, { w, h, ratio });
  }

  place(body, p) {
    return new Vector3(...p).applyMatrix4(this.matrix(body));
  }

  // Where a point of the world is seen [pixel]; null behind the camera.
  seen(p, camera) {
    const q = p.clone().project(camera);
    return q.z > 1 ? null : [((q.x + 1) / 2) * this.w, ((1 - q.y) / 2) * this.h];
  }

  draw(camera, at, rig) {
    const c = this.canvas.getContext("2d");
    c.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    c.clearRect(0, 0, this.w, this.h);
    if (!this.run.t.length) return;
    Object.assign(c, { font: FONT, textAlign: "center", textBaseline: "middle", lineJoin: "round", lineWidth: 3 });
    const { ink, halo, mark } = INKS[this.theme];
    const taken = [];
    this.written = []; // for tests
    const write = (text, p, dx = 0, dy = 0, colour = ink) => {
      const q = p && this.seen(p, camera);
      if (!q) return;
      const half = c.measureText(text).width / 2 + 2;
      const [x, y] = [q[0] + dx * (half + BESIDE), q[1] + dy];
      if (x < half || x > this.w - half || y < 8 || y > this.h - 8) return;
      if (taken.some(([a, b, r]) => Math.abs(a - x) < r + half && Math.abs(b - y) < 14)) return;
      taken.push([x, y, half]);
      this.written.push(text);
      c.strokeStyle = halo;
      c.strokeText(text, x, y);
      c.fillStyle = colour;
      c.fillText(text, x, y);
    };
    const dot = (p, r, colour) => {
      const q = this.seen(p, camera);
      if (!q) return;
      c.fillStyle = colour;
      c.beginPath();
      c.arc(...q, r, 0, 7);
      c.fill();
    };
    if (this.on.has("dimensions")) this.dimensions(c, camera, write, mark);
    if (this.on.has("gravity")) this.gravity(c, camera, write, ink, halo);
    if (this.on.has("names")) for (const { text, body, p } of this.names) write(text, this.place(body, p), 0, -10);
    if (this.on.has("loads")) for (const { text, p } of this.loads(at, rig)) write(text, p, 1, 0);
    if (this.on.has("lugs")) {
      for (const { name, p } of this.run.block?.lugs ?? []) {
        dot(this.place(this.run.block.name, p), 2.5, mark);
        write(name, this.place(this.run.block.name, p), 1, 8);
      }
    }
  }

  // Ropes that carry, those that are used most first, each in the middle of its lines.
  loads(at, rig) {
    const ropes = Map.groupBy(rig, (line) => line.rope);
    const found = [];
    for (const [rope, lines] of ropes) {
      const signal = this.run.signal.get("rope/tension/" + rope);
      const tension = signal ? mix(signal.y, 1, at, 0) : 0;
      if (!(tension > 0)) continue;
      const p = new Vector3();
      for (const line of lines) p.add(this.place(line.a_body, line.a)).add(this.place(line.b_body, line.b));
      const use = tension / (this.run.rated[rope] ?? Infinity);
      const share = use > 0 ? ` · ${(100 * use).toFixed(0)} %` : "";
      found.push({ text: `${(tension / 1e3).toFixed(0)} kN${share}`, p: p.divideScalar(2 * lines.length), use });
    }
    return found.sort((a, b) => b.use - a.use);
  }

  // The quartered circle of drawings.
  gravity(c, camera, write, ink, halo) {
    const { block } = this.run;
    if (!block) return;
    const p = this.place(block.name, block.com);
    const q = this.seen(p, camera);
    if (!q) return;
    const r = 7;
    c.fillStyle = halo;
    c.beginPath();
    c.arc(...q, r + 1.5, 0, 7);
    c.fill();
    c.fillStyle = ink;
    for (const start of [0, Math.PI]) {
      c.beginPath();
      c.moveTo(...q);
      c.arc(...q, r, start, start + Math.PI / 2);
      c.fill();
    }
    c.strokeStyle = ink;
    c.lineWidth = 1.2;
    c.beginPath();
    c.arc(...q, r, 0, 7);
    c.stroke();
    c.lineWidth = 3;
    write(`CG ${(block.mass / 1e3).toFixed(0)} t`, p, 1);
  }

  // Length, width and height of the block along the edges that are seen lowest, and how high it hangs.
  dimensions(c, camera, write, mark) {
    const box = this.run.boxes.find((b) => b.body === this.run.block?.name);
    if (!box) return;
    const corner = (k) => this.place(box.body, [0, 1, 2].map((i) => box.centre[i] + ((k >> i) & 1 ? 0.5 : -0.5) * box.size[i]));
    const corners = [0, 1, 2, 3, 4, 5, 6, 7].map(corner);
    const line = (a, b, text) => {
      const [p, q] = [this.seen(a, camera), this.seen(b, camera)];
      if (!p || !q || Math.hypot(p[0] - q[0], p[1] - q[1]) < SHORT) return;
      c.strokeStyle = mark;
      c.lineWidth = 1.5;
      c.beginPath();
      c.moveTo(...p);
      c.lineTo(...q);
      c.stroke();
      c.lineWidth = 3;
      write(text, a.clone().add(b).multiplyScalar(0.5), 0, 0, mark);
    };
    const depth = (a, b) => (this.seen(corners[a], camera)?.[1] ?? 0) + (this.seen(corners[b], camera)?.[1] ?? 0);
    for (const i of [0, 1, 2]) {
      const edges = [0, 1, 2, 3, 4, 5, 6, 7].filter((k) => !((k >> i) & 1)).map((k) => [k, k | (1 << i)]);
      const [a, b] = edges.reduce((x, y) => (depth(...y) > depth(...x) ? y : x));
      line(corners[a], corners[b], `${+box.size[i].toFixed(2)} m`);
    }
    const low = new Box3().setFromPoints(corners).min.z;
    const foot = corners.reduce((a, b) => (b.z < a.z - 1e-6 ? b : a));
    if (low > LOW) line(foot, foot.clone().setZ(0), `${low.toFixed(2)} m`);
  }
}
