"""A load of 450 t below one winch: the scene shared by the hoisting tests, and its equation in SciPy.

The rope leaves above the pad on which the load stands (or nearly does).  The pad is so stiff that it settles by 5 nm
under the whole weight: at 0.05 m/s that is wound in 1e-7 s.  The accuracy keeps steps to 1e-11 m, far below the 5 nm.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from chain import CLOSED_FORMS, G
from scipy.integrate import solve_ivp

GIVEN = CLOSED_FORMS["C07a"]["given"]
MASS, STIFFNESS, WEIGHT = GIVEN["m"], GIVEN["k"], GIVEN["m"] * G
SETTLED = 5e-9  # [m]
PAD = WEIGHT / SETTLED  # [N/m]
PAD_DAMPING = float(2 * 0.3 * np.sqrt(PAD * MASS))

SUPPORTS = f"""
  supports:
    ground: {{body: load, height: 0 m, stiffness: {PAD!r} N/m, damping: {PAD_DAMPING!r} N s/m}}
"""

SCENE = """\
heavylift: 1
name: hoist
accuracy: 1e-9 %
samples: {samples} Hz
end: {end} s
mechanism:
  bodies:
    load: {{mass: 450 t, inertia: [1e7 kg m2, 1e7 kg m2, 1e7 kg m2]}}
  joints:
    free: {{type: free, child: load, position: [0, 0, {z!r} m]}}
  ropes:
    rope:
      start: {{body: world, at: [0, 0, {height} m]}}
      end: {{body: load}}
      EA: {EA!r} N
      length: {length!r} m
      winch: {{ramp: {ramp} m/s2, shortest: 5 m, longest: 10 km}}
"""


class Rope(NamedTuple):
    """A rope of `height` [m] above the load on its pad, with EA [N]."""

    height: float = GIVEN["L"]
    EA: float = GIVEN["falls"] * GIVEN["EA"]

    @property
    def carrying(self) -> float:
        """Unstretched length that carries the weight of a load which just touches the pad."""
        return self.height / (1 + WEIGHT / self.EA)

    def scene(self, samples: int, end: float, z: float, length: float, ramp: float = 1.0, pad: bool = True) -> str:
        """The scene text with this unstretched length at the start."""
        text = SCENE.format(samples=samples, end=end, z=z, height=self.height, EA=self.EA, length=length, ramp=ramp)
        return text + (SUPPORTS if pad else "")

    def hoisted(self, start: float, speed: float, seconds: float) -> list[tuple[float, str]]:
        """Slack and taut events after a lift-off at `start`: m z'' = T - m g, T = EA (l - L0) / L0, L0' = -speed."""

        def wound(t: float) -> float:
            return self.carrying - speed * (t - start)

        def elongation(t: float, y: list[float]) -> float:
            return self.height - y[0] - wound(t)

        def taut(t: float, y: list[float]) -> list[float]:
            return [y[1], self.EA * elongation(t, y) / wound(t) / MASS - G]

        def slack(t: float, y: list[float]) -> list[float]:
            return [y[1], -G]

        events: list[tuple[float, str]] = []
        t, y = start, [0.0, 0.0]
        while True:
            law, ends, direction = [(taut, "slack", -1.0), (slack, "taut", 1.0)][len(events) % 2]
            elongation.terminal, elongation.direction = True, direction  # type: ignore[attr-defined]
            got = solve_ivp(law, (t, seconds), y, "DOP853", rtol=1e-12, atol=1e-12, events=elongation, max_step=0.01)
            if not len(got.t_events[0]):
                return events
            t, y = float(got.t_events[0][0]), list(got.y_events[0][0])
            events.append((t, ends))


def winding_time(length: float, speed: float, ramp: float) -> float:
    """Seconds to wind up (or off) this much rope from rest, the ramp included."""
    return length / speed + speed / (2 * ramp)
