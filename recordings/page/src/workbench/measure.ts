// Distances between points that are clicked in three dimensions.
import { BufferGeometry, Line, LineBasicMaterial, Raycaster, Vector2, Vector3 } from "three";
import type { Stage } from "../stage.js";
import { words } from "./words";

export class Measure {
  private from: Vector3 | null = null;
  private line: Line | null = null;
  on = false;

  constructor(private readonly stage: () => Stage, private readonly tell: (text: string) => void) {}

  toggle(on: boolean): void {
    this.on = on;
    this.from = null;
    this.line?.removeFromParent();
    this.line = null;
    this.tell(on ? words.first : "");
    this.stage().ask();
  }

  attach(canvas: HTMLCanvasElement): void {
    let down = new Vector2();
    canvas.addEventListener("pointerdown", (e) => (down = new Vector2(e.clientX, e.clientY)));
    canvas.addEventListener("pointerup", (e) => {
      if (this.on && !e.button && down.distanceTo(new Vector2(e.clientX, e.clientY)) < 4) this.click(e);
    });
  }

  private click(e: PointerEvent): void {
    const box = (e.target as HTMLElement).getBoundingClientRect();
    const ray = new Raycaster();
    ray.setFromCamera(new Vector2((2 * (e.clientX - box.x)) / box.width - 1, 1 - (2 * (e.clientY - box.y)) / box.height), this.stage().camera);
    const hit = ray.intersectObjects(this.stage().scene.children, true).find((x) => "isMesh" in x.object && !("isLineSegments2" in x.object));
    if (!hit) return;
    if (!this.from) {
      this.line?.removeFromParent();
      this.from = hit.point.clone();
      return this.tell(words.second(this.from.toArray()));
    }
    const by = hit.point.clone().sub(this.from);
    this.line = new Line(new BufferGeometry().setFromPoints([this.from, hit.point]), new LineBasicMaterial({ color: 0xd0342c, depthTest: false }));
    this.stage().scene.add(this.line);
    this.stage().ask();
    this.tell(words.distance(by.length(), by.toArray()));
    this.from = null;
  }
}
