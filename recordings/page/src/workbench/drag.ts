// Moves block, cranes, trolleys and lugs by hand: what is dragged goes along its free axes, snaps, and writes its place.
import { type Object3D, Plane, Raycaster, Vector2, Vector3 } from "three";
import type { Stage } from "../stage.js";
import type { Handle, Picture } from "./api";
import { element } from "./dom";
import type { Edit } from "./templates";
import { words } from "./words";

const GRID_m = 0.5, FINE_m = 0.01;
const NEAR_m = 0.6; // from a hook that a lug snaps under, in plan
const GRIP_px = 14; // around a lug

interface Held { handle: Handle; from: Vector3; plane: Plane; places: Map<string, Vector3>; by: Vector3 }

export class Drag {
  readonly told = element("output", { className: "moving", hidden: true });
  on = false;
  private held: Held | null = null;

  constructor(private readonly stage: () => Stage, private readonly picture: () => Picture | null,
    private readonly edit: (edits: Edit[]) => Promise<string>) {}

  attach(canvas: HTMLCanvasElement): void {
    canvas.addEventListener("pointerdown", (e) => this.take(e), true);
    canvas.addEventListener("pointermove", (e) => this.drag(e));
    canvas.addEventListener("pointerup", () => void this.put());
    canvas.addEventListener("pointercancel", () => this.drop());
  }

  private ray(e: PointerEvent): Raycaster {
    const box = (e.target as HTMLElement).getBoundingClientRect();
    const ray = new Raycaster();
    ray.setFromCamera(new Vector2((2 * (e.clientX - box.x)) / box.width - 1, 1 - (2 * (e.clientY - box.y)) / box.height), this.stage().camera);
    return ray;
  }

  private body(object: Object3D | null): string {
    for (const [name, group] of this.stage().frames) if (name !== "world" && group === object) return name;
    return object?.parent ? this.body(object.parent) : "";
  }

  private place(body: string, p: number[]): Vector3 {
    return new Vector3(...p).applyMatrix4(this.stage().frames.get(body)!.matrixWorld);
  }

  // The lug or the body under the pointer.
  private found(e: PointerEvent): { handle: Handle; at: Vector3 } | null {
    const { moving } = this.picture()!;
    const box = (e.target as HTMLElement).getBoundingClientRect();
    if (this.stage().labels.on.has("lugs")) {
      for (const handle of moving.filter((x) => x.lug)) {
        const at = this.place(handle.body!, handle.at);
        const seen = at.clone().project(this.stage().camera);
        const [x, y] = [((seen.x + 1) / 2) * box.width + box.x, ((1 - seen.y) / 2) * box.height + box.y];
        if (Math.hypot(x - e.clientX, y - e.clientY) < GRIP_px) return { handle, at };
      }
    }
    for (const hit of this.ray(e).intersectObjects(this.stage().scene.children, true)) {
      const body = this.body(hit.object);
      const handle = moving.filter((x) => x.bodies.includes(body)).sort((a, b) => a.bodies.length - b.bodies.length)[0];
      if (handle) return { handle, at: hit.point };
    }
    return null;
  }

  private take(e: PointerEvent): void {
    if (!this.on || e.button || !this.picture()) return;
    const found = this.found(e);
    if (!found) return;
    e.stopImmediatePropagation();
    (e.target as HTMLElement).setPointerCapture(e.pointerId);
    this.stage().controls.enabled = false;
    const { handle, at } = found;
    const places = new Map(handle.bodies.map((name) => [name, this.stage().frames.get(name)!.position.clone()]));
    this.held = { handle, from: at, plane: new Plane(new Vector3(0, 0, 1), -at.z), places, by: new Vector3() };
    this.tell();
  }

  private drag(e: PointerEvent): void {
    const { held } = this;
    const to = held && this.ray(e).ray.intersectPlane(held.plane, new Vector3());
    if (!held || !to) return;
    const by = to.sub(held.from).setZ(0);
    if (!held.handle.free.includes("x")) by.x = 0;
    if (!held.handle.free.includes("y")) by.y = 0;
    held.by = this.snapped(held, by, e.shiftKey);
    for (const [name, p] of held.places) this.stage().frames.get(name)!.position.copy(p).add(held.by);
    this.tell();
    this.stage().moved();
  }

  // To the grid of what is written; lugs that come near a hook in plan go right under it.
  private snapped({ handle, places }: Held, by: Vector3, fine: boolean): Vector3 {
    const { moving, hooks } = this.picture()!;
    const lugs = moving.filter((x) => (handle.lug ? x === handle : places.has(x.body ?? "")));
    const eyes = hooks.map((x) => this.place(x.body, x.p));
    const start = (x: Handle) => this.place(x.body!, x.at).sub(handle.lug ? new Vector3() : (this.held?.by ?? new Vector3()));
    let best: Vector3 | null = null, least = NEAR_m;
    if (!fine && handle.free.length > 1) {
      for (const lug of lugs) {
        const p = start(lug);
        for (const eye of eyes) {
          const d = new Vector3(eye.x - p.x, eye.y - p.y, 0);
          if (d.distanceTo(by) < least) [best, least] = [d, d.distanceTo(by)];
        }
      }
    }
    if (best) return best;
    const step = fine ? FINE_m : GRID_m;
    const round = (x: number, at: number) => Math.round((at + x) / step) * step - at;
    const [x, y] = handle.free === "y" ? [0, handle.at[0]] : [handle.at[0], handle.at[1] ?? 0];
    return handle.lug ? by.set(Math.round(by.x / step) * step, Math.round(by.y / step) * step, 0)
      : by.set(by.x ? round(by.x, x) : 0, by.y ? round(by.y, y) : 0, 0);
  }

  // What is written for where it is now.
  private value({ handle, by }: Held): string {
    const p = by.clone();
    if (handle.lug) p.transformDirection(this.stage().frames.get(handle.body!)!.matrixWorld.clone().invert()).multiplyScalar(by.length());
    const moved = handle.free === "y" ? [p.y] : [p.x, p.y, p.z];
    const written = handle.at.map((x, i) => `${Number((x + (moved[i] ?? 0)).toFixed(3))} m`);
    return handle.listed ? `[${written.join(", ")}]` : written[0];
  }

  private tell(): void {
    this.told.hidden = !this.held;
    if (this.held) this.told.textContent = words.moving(this.held.handle.path.slice(0, -1).concat(this.held.handle.lug ?? []).join(" "), this.value(this.held));
  }

  private drop(): void {
    this.held = null;
    this.stage().controls.enabled = true;
    this.tell();
  }

  private async put(): Promise<void> {
    const { held } = this;
    if (!held) return;
    const value = this.value(held);
    this.drop();
    if (held.by.length() < 1e-6) return;
    const refused = await this.edit([{ path: held.handle.path, value }]);
    if (refused) {
      this.told.hidden = false;
      this.told.textContent = refused;
      for (const [name, p] of held.places) this.stage().frames.get(name)!.position.copy(p);
      this.stage().moved();
    }
  }
}
