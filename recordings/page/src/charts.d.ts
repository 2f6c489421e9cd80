// What the workbench uses of charts.
import type { Run } from "./data.js";

export class Charts {
  constructor(host: HTMLElement, picker: HTMLElement, run: Run, jump: (t: number) => void);
  on: Set<string>;
  draw(): void;
  grow(): void;
  cursor(now: number): void;
  paint(theme: string): void;
  resize(): void;
}
