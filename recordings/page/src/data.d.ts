// What the workbench uses of a run as pages hold it.
export class Run {
  constructor(head: object);
  t: Float64Array;
  boxes: unknown[];
}
export function clock(seconds: number, digits?: number): string;
