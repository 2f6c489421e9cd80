// A run that still goes on, over Server-Sent Events: first what is drawn, then what happens, last how it ended.
import { Run } from "./data.js";

// `begun(run)` once, then `grown(run)` after each piece, `ended(run)`; `lost` while the connection is away.
export function listen(address, { begun, grown, ended, lost }) {
  const source = new EventSource(address);
  let run = null;
  source.addEventListener("begin", (e) => {
    if (run) return;
    run = new Run(JSON.parse(e.data));
    begun(run);
  });
  source.addEventListener("more", (e) => {
    lost(false);
    const more = JSON.parse(e.data);
    if (more.rows) run.extend(more.rows);
    for (const list of ["events", "stages", "rig"]) run[list].push(...(more[list] ?? []));
    Object.assign(run, { status: more.status });
    grown(run);
  });
  source.addEventListener("end", (e) => {
    source.close(); // nothing more comes, and nobody would answer
    Object.assign(run, JSON.parse(e.data));
    ended(run);
  });
  source.onerror = () => lost(true);
  return source;
}
