// Marks in 3D what a check is about: a rope, a lug, a support, a body, or the shortest way between two things.
import { BufferGeometry, Line, LineBasicMaterial, Mesh, MeshBasicMaterial, SphereGeometry, Vector3 } from "three";
import type { Stage } from "../stage.js";
import type { Run } from "../data.js";

const COLOUR = 0xd0342c;
const SIZE = 0.012; // of the radius of what is seen

export class Pin {
  private drawn: (Mesh | Line)[] = [];
  at: Vector3 | null = null;

  constructor(private readonly stage: () => Stage) {}

  clear(): void {
    for (const x of this.drawn) x.removeFromParent();
    this.drawn = [];
    this.at = null;
  }

  // `ends`: of a clearance, in the world. Whether the subject was found.
  show(run: Run, subject: string, ends?: number[][]): boolean {
    this.clear();
    const points = ends?.map((p) => new Vector3(...p)) ?? this.places(run, subject);
    const material = new MeshBasicMaterial({ color: COLOUR, depthTest: false, transparent: true, opacity: 0.85 });
    for (const p of points) {
      const ball = new Mesh(new SphereGeometry(this.stage().radius * SIZE, 16, 12), material);
      ball.position.copy(p);
      this.drawn.push(ball);
    }
    if (ends) this.drawn.push(new Line(new BufferGeometry().setFromPoints(points), new LineBasicMaterial({ color: COLOUR, depthTest: false })));
    for (const x of this.drawn) {
      x.renderOrder = 9;
      this.stage().scene.add(x);
    }
    this.at = points[0] ?? null;
    this.stage().ask();
    return points.length > 0;
  }

  private places(run: Run, subject: string): Vector3[] {
    const { labels, frames, rig } = this.stage();
    const words = new Set([subject, subject.replace(" ", "."), ...subject.split(/[\s,]+/)]);
    const lines = rig.filter((x) => words.has(x.rope));
    if (lines.length) return [lines.reduce((sum, x) => sum.add(labels.place(x.a_body, x.a)).add(labels.place(x.b_body, x.b)), new Vector3()).divideScalar(2 * lines.length)];
    const lug = run.block?.lugs.find((x) => words.has(x.name));
    if (lug) return [labels.place(run.block!.name, lug.p)];
    const support = run.supports.find((x) => words.has(x.name));
    if (support) return [labels.place(support.body, support.p)];
    const body = run.bodies.find((x) => words.has(x.name)) ?? run.bodies.find((x) => words.has(x.name.split(".")[0]));
    const box = body && run.boxes.find((x) => x.body === body.name);
    return body && frames.has(body.name) ? [labels.place(body.name, box?.centre ?? [0, 0, 0])] : [];
  }
}
