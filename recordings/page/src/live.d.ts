// What the workbench uses of a run that goes on.
import type { Run } from "./data.js";

export function listen(address: string, heard: { begun: (run: Run) => void; grown: (run: Run) => void; ended: (run: Run) => void; lost: (away: boolean) => void }): EventSource;
