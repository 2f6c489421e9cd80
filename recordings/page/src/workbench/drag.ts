// Moves things by hand: what is dragged, or nudged with arrow keys, goes along its free axes, snaps, and writes its place.
import { Mesh, MeshBasicMaterial, type Object3D, Plane, Raycaster, SphereGeometry, Vector2, Vector3 } from "three";
import type { Stage } from "../stage.js";
import type { Handle, Path, Picture } from "./api";
import { element } from "./dom";
import type { Edit } from "./templates";
import { words } from "./words";

const GRID_m = 0.5, FINE_m = 0.01;
const NEAR_m = 0.6; // from a hook that a lug snaps under, from a lug that a support snaps under, in plan
const GRIP_px = [5, 14]; // around a lug or support: the least and the most, between them a third of the way to the next one
const STILL_m = 1e-6;
const LENGTHS: Record<string, number> = { m: 1, mm: 1e-3, cm: 1e-2, km: 1e3, ft: 0.3048, in: 0.0254 };
const ARROWS: Record<string, [number, number, number]> = {
  ArrowLeft: [-1, 0, 0], ArrowRight: [1, 0, 0], ArrowUp: [0, 1, 0], ArrowDown: [0, -1, 0], PageUp: [0, 0, 1], PageDown: [0, 0, -1],
};

const length = (text: string) => {
  const [, number, unit] = /^([-+]?[\d.]+(?:e[-+]?\d+)?)\s*([a-z]+)$/i.exec(text) ?? [];
  return Number(number) * (LENGTHS[unit] ?? NaN);
};

interface Held { handle: Handle; from: Vector3; plane: Plane; places: Map<string, Vector3>; by: Vector3 }

export class Drag {
  readonly told = element("output", { className: "moving", hidden: true });
  on = false;
  private held: Held | null = null;
  private chosen: Path = [];
  private readonly mark = new Mesh(new SphereGeometry(1, 16, 12), new MeshBasicMaterial({ color: 0xd0342c, depthTest: false, transparent: true }));

  constructor(private readonly stage: () => Stage, private readonly picture: () => Picture | null,
    private readonly edit: (edits: () => Edit[]) => Promise<string>, private readonly picked: (path: Path) => void,
    private readonly written: (path: Path) => string[]) {}

  attach(canvas: HTMLCanvasElement): void {
    Object.assign(canvas, { tabIndex: 0 });
    canvas.setAttribute("aria-label", words.canvas);
    canvas.setAttribute("role", "application");
    let down = new Vector2();
    canvas.addEventListener("pointerdown", (e) => {
      down = new Vector2(e.clientX, e.clientY);
      this.take(e);
    }, true);
    canvas.addEventListener("pointermove", (e) => this.drag(e));
    canvas.addEventListener("pointerup", (e) => {
      if (!this.held && !e.button && down.distanceTo(new Vector2(e.clientX, e.clientY)) < 4) this.pick(e);
      void this.put();
    });
    canvas.addEventListener("pointercancel", () => this.drop());
    canvas.addEventListener("keydown", (e) => this.nudge(e));
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

  // Where it is by the text, which may be ahead of the picture.
  private now(handle: Handle): Handle {
    const at = this.written(handle.path).map(length);
    if (at.length !== handle.at.length || !at.every(Number.isFinite)) return handle;
    return { ...handle, at, p: handle.p?.map((x, i) => x + (at[i] ?? 0) - (handle.at[i] ?? 0)) };
  }

  private get moving(): Handle[] {
    return this.picture()?.moving.map((x) => this.now(x)) ?? [];
  }

  // The lug or support near the pointer, else the smallest thing under it.
  private found(e: PointerEvent): { handle: Handle; at: Vector3 } | null {
    const { moving } = this;
    const box = (e.target as HTMLElement).getBoundingClientRect();
    const points = moving.filter((x) => x.point && this.on).map((handle) => {
      const at = this.place(handle.body!, handle.p!);
      const q = at.clone().project(this.stage().camera);
      return { handle, at, deep: q.z, seen: new Vector2(((q.x + 1) / 2) * box.width, ((1 - q.y) / 2) * box.height), kind: String(handle.path.at(-2)) };
    });
    const pointer = new Vector2(e.clientX - box.x, e.clientY - box.y);
    const reach = (x: (typeof points)[0]) => Math.min(GRIP_px[1], Math.max(GRIP_px[0], Math.min(...points.filter((y) => y !== x && y.kind === x.kind).map((y) => y.seen.distanceTo(x.seen))) / 3));
    const near = points.filter((x) => x.seen.distanceTo(pointer) < reach(x)).sort((a, b) => a.deep - b.deep)[0];
    if (near) return near;
    for (const hit of this.ray(e).intersectObjects(this.stage().scene.children, true)) {
      const body = this.body(hit.object);
      const handle = moving.filter((x) => x.bodies.includes(body)).sort((a, b) => a.bodies.length - b.bodies.length)[0];
      if (handle) return { handle, at: hit.point };
    }
    return null;
  }

  // A click without a move leads to the thing in outline, form and text.
  private pick(e: PointerEvent): void {
    const found = this.picture() && this.found(e);
    if (found) this.choose(found.handle);
  }

  private choose(handle: Handle): void {
    this.chosen = handle.path;
    this.picked(handle.point ? handle.path : handle.path.slice(0, -1));
  }

  private hold(handle: Handle, from: Vector3, plane: Plane): Held {
    const places = new Map(handle.bodies.map((name) => [name, this.stage().frames.get(name)!.position.clone()]));
    return { handle, from, plane, places, by: new Vector3() };
  }

  private take(e: PointerEvent): void {
    if (!this.on || e.button || !this.picture()) return;
    const found = this.found(e);
    if (!found) return;
    e.stopImmediatePropagation();
    (e.target as HTMLElement).setPointerCapture(e.pointerId);
    this.stage().controls.enabled = false;
    const { handle, at } = found;
    const look = this.stage().camera.getWorldDirection(new Vector3());
    const upright = handle.free.includes("z") && Math.abs(look.z) < 0.1; // seen from a side: heights, too
    this.held = this.hold(handle, at, new Plane().setFromNormalAndCoplanarPoint(upright ? look.setZ(0).normalize() : new Vector3(0, 0, 1), at));
    this.tell();
  }

  private drag(e: PointerEvent): void {
    const { held } = this;
    const to = held && this.ray(e).ray.intersectPlane(held.plane, new Vector3());
    if (!held || !to) return;
    const by = to.sub(held.from);
    for (const axis of ["x", "y", "z"] as const) if (!held.handle.free.includes(axis) || (axis === "z" && held.plane.normal.z > 0.5)) by[axis] = 0;
    held.by = this.snapped(held, by, e.shiftKey);
    this.show(held);
  }

  private show(held: Held): void {
    for (const [name, p] of held.places) this.stage().frames.get(name)!.position.copy(p).add(held.by);
    if (held.handle.point) {
      this.mark.position.copy(this.place(held.handle.body!, held.handle.p!)).add(held.by);
      this.mark.scale.setScalar(this.stage().radius * 0.008);
      this.stage().scene.add(this.mark);
    }
    this.tell();
    this.stage().moved();
  }

  // To the grid of what is written; lugs that come near a hook in plan go right under it, supports under a lug.
  private snapped({ handle, places }: Held, by: Vector3, fine: boolean): Vector3 {
    const { moving } = this;
    const { hooks } = this.picture()!;
    const support = handle.path.includes("supports");
    const lugs = moving.filter((x) => x.path.includes("lugs"));
    const own = handle.point ? [handle] : lugs.filter((x) => places.has(x.body ?? ""));
    const eyes = support ? lugs.map((x) => this.place(x.body!, x.p!)) : hooks.map((x) => this.place(x.body, x.p));
    const start = (x: Handle) => this.place(x.body!, x.p!).sub(handle.point ? new Vector3() : (this.held?.by ?? new Vector3()));
    let best: Vector3 | null = null, least = NEAR_m;
    if (!fine && handle.free.length > 1 && !by.z) {
      for (const lug of own) {
        const p = start(lug);
        for (const eye of eyes) {
          const d = new Vector3(eye.x - p.x, eye.y - p.y, 0);
          if (d.distanceTo(by) < least) [best, least] = [d, d.distanceTo(by)];
        }
      }
    }
    if (best) return best;
    const step = fine ? FINE_m : GRID_m;
    const round = (x: number, at: number) => (x ? Math.round((at + x) / step) * step - at : 0);
    const [x, y, z] = handle.point ? [0, 0, 0] : handle.free === "y" ? [0, handle.at[0], 0] : [handle.at[0], handle.at[1] ?? 0, handle.at[2] ?? 0];
    return by.set(round(by.x, x), round(by.y, y), round(by.z, z));
  }

  // What is written for where it is now.
  private value({ handle, by }: Held): string {
    const p = by.clone();
    if (handle.point && by.length() > 0) p.transformDirection(this.stage().frames.get(handle.body!)!.matrixWorld.clone().invert()).multiplyScalar(by.length());
    const moved = handle.free === "y" ? [p.y] : [p.x, p.y, p.z];
    const written = this.now(handle).at.map((x, i) => `${Number((x + (moved[i] ?? 0)).toFixed(3))} m`);
    return handle.listed ? `[${written.join(", ")}]` : written[0];
  }

  private tell(): void {
    this.told.hidden = !this.held;
    if (this.held) this.told.textContent = words.moving(this.held.handle.point ?? this.held.handle.path.slice(0, -1).join(" "), this.value(this.held));
  }

  private drop(): void {
    this.held = null;
    this.mark.removeFromParent();
    this.stage().controls.enabled = true;
    this.tell();
  }

  // Arrow keys move what was clicked last by a step of the grid, with Shift by a fine one.
  private nudge(e: KeyboardEvent): void {
    const handle = this.on && ARROWS[e.key] && this.moving.find((x) => x.path.join() === this.chosen.join());
    if (!handle) return;
    e.preventDefault();
    e.stopPropagation();
    const by = new Vector3(...ARROWS[e.key]).multiplyScalar(e.shiftKey ? FINE_m : GRID_m);
    for (const axis of ["x", "y", "z"] as const) if (!handle.free.includes(axis)) by[axis] = 0;
    this.held = this.hold(handle, new Vector3(), new Plane());
    this.held.by = by;
    this.show(this.held);
    void this.put();
  }

  private async put(): Promise<void> {
    const { held } = this;
    if (!held) return;
    const picture = this.picture();
    this.drop();
    this.choose(held.handle);
    if (held.by.length() < STILL_m) return;
    const refused = await this.edit(() => [{ path: held.handle.path, value: this.value(held) }]);
    if (!refused) return;
    this.told.hidden = false;
    this.told.textContent = refused;
    if (this.picture() !== picture) return;
    for (const name of held.places.keys()) this.stage().frames.get(name)!.position.sub(held.by);
    this.stage().moved();
  }
}
