// The box around all that is ever drawn, and the ball around it; planes and rails of the world do not count, nor do
// mooring lines below all bodies, which reach down to the lowest point.
import { Quaternion, Vector3 } from "three";

const INSTANTS = 32;

export function measure(run) {
  const low = new Vector3(Infinity, Infinity, Infinity);
  const high = new Vector3(-Infinity, -Infinity, -Infinity);
  const corner = new Vector3();
  const turn = new Quaternion();
  const place = new Vector3();
  const pose = new Quaternion();
  const n = run.t.length;
  const moving = run.boxes.some((b) => b.body !== "world");
  for (const box of run.boxes) {
    const body = run.body.get(box.body);
    if (!body && moving && Math.max(...box.size) > 8 * Math.min(...box.size)) continue;
    turn.set(...box.turn);
    const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((k) =>
      new Vector3(...[0, 1, 2].map((i) => ((k >> i) & 1 ? 0.5 : -0.5) * box.size[i])).applyQuaternion(turn).add(new Vector3(...box.centre)));
    const step = body ? Math.max(1, Math.floor(n / INSTANTS)) : Infinity;
    for (let i = 0; i === 0 || i < n; i += step) {
      if (body && n) {
        const x = body.x.subarray(7 * i, 7 * i + 7);
        place.set(x[0], x[1], x[2]);
        pose.set(x[3], x[4], x[5], x[6]);
      } else {
        place.set(0, 0, 0);
        pose.identity();
      }
      for (const p of corners) {
        corner.copy(p).applyQuaternion(pose).add(place);
        low.min(corner);
        high.max(corner);
      }
    }
  }
  const floats = low.z;
  let lowest = low.z;
  for (const rig of run.rig) {
    for (const line of rig.lines) {
      for (const [body, p] of [[line.a_body, line.a], [line.b_body, line.b]]) {
        if (body === "world") lowest = Math.min(lowest, p[2]);
        if (body === "world" && !(p[2] < floats && isFinite(floats))) {
          low.min(corner.set(...p));
          high.max(corner);
        }
      }
    }
  }
  if (!isFinite(low.x)) {
    low.set(-5, -5, 0);
    high.set(5, 5, 5);
  }
  const middle = low.clone().add(high).multiplyScalar(0.5);
  return { low, high, lowest, middle, radius: Math.max(1e-3, high.distanceTo(low) / 2) };
}
