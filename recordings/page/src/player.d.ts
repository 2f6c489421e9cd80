// What the workbench uses of the common time.
import type { Run } from "./data.js";

export class Player {
  constructor(run: Run, show: (now: number) => void);
  now: number;
  playing: boolean;
  following: boolean;
  speed: number;
  onchange: () => void;
  jump(t: number): void;
  follow(on: boolean): void;
  play(on: boolean): void;
}
