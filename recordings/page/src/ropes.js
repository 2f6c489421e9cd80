// Ropes as lines of a width in pixels, coloured by how much of their rated tension they carry.
import { Color, Vector3 } from "three";
import { LineMaterial } from "three/examples/jsm/lines/LineMaterial.js";
import { LineSegments2 } from "three/examples/jsm/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/examples/jsm/lines/LineSegmentsGeometry.js";
import { lastBefore, mix } from "./data.js";

const SLACK = new Color(0x8a949e);
const UNRATED = new Color(0x3d6fb5); // carries, but nobody has said how much it may
const WIDTH = 2.2; // [pixel]

// Green at rest, yellow at half, red at the rated tension.
export function useColour(use, colour = new Color()) {
  return colour.setHSL(0.33 * (1 - Math.min(1, Math.max(0, use))), 0.85, 0.42);
}

export class Ropes {
  constructor(scene, run) {
    this.run = run;
    this.scene = scene;
    this.material = new LineMaterial({ vertexColors: true, linewidth: WIDTH });
    this.room = 0;
  }

  // A geometry for at least so many lines; ropes that are hooked later may be more.
  make(lines) {
    this.object?.removeFromParent();
    this.room = Math.max(8, 2 * lines);
    this.place = new Float32Array(6 * this.room);
    this.colour = new Float32Array(6 * this.room);
    this.geometry = new LineSegmentsGeometry().setPositions(this.place).setColors(this.colour);
    this.object = new LineSegments2(this.geometry, this.material);
    this.object.frustumCulled = false;
    this.scene.add(this.object);
  }

  hang(now, at, matrix) {
    const lines = this.run.rig[lastBefore(this.run.rig, now)]?.lines ?? [];
    if (lines.length > this.room || !this.object) this.make(lines.length);
    const p = new Vector3();
    const c = new Color();
    lines.forEach((line, k) => {
      const signal = this.run.signal.get("rope/tension/" + line.rope);
      const tension = signal ? mix(signal.y, 1, at, 0) : 0;
      const rated = this.run.rated[line.rope];
      if (tension <= 0) c.copy(SLACK);
      else if (rated) useColour(tension / rated, c);
      else c.copy(UNRATED);
      [[line.a_body, line.a], [line.b_body, line.b]].forEach(([body, point], end) => {
        p.set(...point).applyMatrix4(matrix(body));
        this.place.set([p.x, p.y, p.z], 6 * k + 3 * end);
        this.colour.set([c.r, c.g, c.b], 6 * k + 3 * end);
      });
    });
    this.geometry.setPositions(this.place).setColors(this.colour);
    this.geometry.instanceCount = lines.length;
  }

  resize(w, h) {
    this.material.resolution.set(w, h);
  }
}
