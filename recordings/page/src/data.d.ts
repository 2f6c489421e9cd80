// What the workbench uses of a run as pages hold it.
export class Run {
  constructor(head: object);
  t: Float64Array;
  boxes: { body: string; centre: number[]; size: number[] }[];
  bodies: { name: string }[];
  block: { name: string; lugs: { name: string; p: number[] }[] } | null;
  supports: { name: string; body: string; p: number[] }[];
  events: { t: number; text: string; inner: boolean }[];
  stages: { t: number; name: string }[];
  status: string;
  title: string;
  readonly first: number;
  readonly last: number;
  clock(t: number): string;
  refine(): Promise<boolean>;
}
export function clock(seconds: number, digits?: number): string;
