// What the workbench uses of the scene in three dimensions.
import type { Camera, Group, Scene, Vector3 } from "three";
import type { Run } from "./data.js";

export class Stage {
  constructor(host: HTMLElement, run: Run);
  camera: Camera;
  scene: Scene;
  radius: number;
  rig: { rope: string; a_body: string; a: number[]; b_body: string; b: number[] }[];
  frames: Map<string, Group>;
  gl: { domElement: HTMLCanvasElement };
  controls: { enabled: boolean; zoomToCursor: boolean };
  moved(): void;
  labels: { on: Set<string>; written: string[]; place(body: string, p: number[]): Vector3 };
  quality: { best: number };
  load(run: Run): void;
  frame(): void;
  look(view: string): void;
  show(now: number): void;
  paint(theme: string): void;
  resize(): void;
  ask(): void;
  draw(ratio: number): void;
}
