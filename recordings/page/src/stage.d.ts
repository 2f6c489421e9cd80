// What the workbench uses of the scene in three dimensions.
import type { Camera, Group, Scene } from "three";
import type { Run } from "./data.js";

export class Stage {
  constructor(host: HTMLElement, run: Run);
  camera: Camera;
  scene: Scene;
  frames: Map<string, Group>;
  gl: { domElement: HTMLCanvasElement };
  controls: { enabled: boolean };
  moved(): void;
  labels: { on: Set<string>; written: string[] };
  quality: { best: number };
  load(run: Run): void;
  look(view: string): void;
  show(now: number): void;
  paint(theme: string): void;
  resize(): void;
  ask(): void;
  draw(ratio: number): void;
}
