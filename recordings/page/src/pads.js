// Stools under the places where something stands: wherever a support has carried, from the ground up to its pad.
import { BoxGeometry, Mesh, MeshLambertMaterial, Quaternion, Vector3 } from "three";

const APART = 0.02; // of the radius of the scene: pads that are closer are one
const EDGE = 0.012; // of the radius: edge of a stool

export class Pads {
  constructor(scene, run) {
    Object.assign(this, { scene, run, looked: 0, stools: [] });
  }

  stand(floor, radius) {
    Object.assign(this, { floor, radius });
    for (const stool of this.stools) this.size(stool);
  }

  // Look at the samples that have come since: a few of each stretch in which a support carries are enough.
  grow() {
    const { run } = this;
    const n = run.t.length;
    const step = Math.max(1, Math.floor((n - this.looked) / 400));
    for (let i = this.looked; i < n; i += step) {
      for (const support of run.supports) {
        const force = run.signal.get("support/force/" + support.name);
        const body = run.body.get(support.body);
        if (force && body && force.y[i] > 0) this.add(support, body.x.subarray(7 * i, 7 * i + 7));
      }
    }
    this.looked = n;
  }

  add(support, x) {
    const p = new Vector3(...support.p).applyQuaternion(new Quaternion(x[3], x[4], x[5], x[6]));
    p.add(new Vector3(x[0], x[1], x[2])).setZ(support.height);
    if (this.stools.some((s) => s.top.distanceTo(p) < APART * this.radius)) return;
    const mesh = new Mesh(new BoxGeometry(1, 1, 1), new MeshLambertMaterial({ color: 0x8d8577 }));
    const stool = { top: p, mesh };
    this.size(stool);
    this.stools.push(stool);
    this.scene.add(mesh);
  }

  size({ top, mesh }) {
    const edge = EDGE * this.radius;
    const height = Math.max(top.z - this.floor, 0.1 * edge);
    mesh.scale.set(edge, edge, height);
    mesh.position.set(top.x, top.y, top.z - height / 2);
  }
}
