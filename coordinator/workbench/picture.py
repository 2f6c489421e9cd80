"""States of the equilibrium path as pages draw them: poses and tensions in 3D, plan and two elevations as drawings."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import msgspec
import numpy as np
from heavylift.coordinator.record.drawing import RopeLines, boxes
from heavylift.coordinator.record.facts import hanging, supports
from heavylift.kernel.algebra.attitudes import quaternions
from heavylift.nodes.limits.named import rated
from heavylift.nodes.plan.connections import lug_places
from heavylift.nodes.plan.plan import Plan, encode
from heavylift.nodes.statics import StaticState
from heavylift.recordings import DrawnBox, RopeLine, SampleChannel, SampleLayout
from heavylift.recordings.drawings.instants import instant
from heavylift.recordings.drawings.sheets import svg_alone
from heavylift.recordings.drawings.views import three
from heavylift.recordings.format.machines import block
from heavylift.recordings.format.samples import POSE, POSE_COLUMNS
from heavylift.recordings.render.content import packed, shown
from numpy.typing import NDArray

Floats = NDArray[np.float64]
SIGNALS = {"rope/tension": "tensions", "support/force": "supports"}  # [N]
ROOM = 100.0, 58.0  # [mm] of a drawing: letters of 2.2 mm are legible in a quarter of a screen


class Picture:
    """The static states of a lift from start to end, as shown in 3D and as drawings by the pages."""

    def __init__(self, plan: Plan, states: Sequence[StaticState]) -> None:
        self.plan, self.states = plan, states
        self._boxes: list[DrawnBox] = boxes(plan)
        self._systems = [machine.system for machine in plan.machines]
        self._ties = [tie for machine in plan.machines for tie in machine.ties]

    @cached_property
    def _data(self) -> dict[str, Any]:
        found: dict[str, Any] = msgspec.json.decode(encode(self.plan))
        return found

    @cached_property
    def _poses(self) -> dict[str, Floats]:
        """Poses in all states by body: (n, 7) [m, quaternion x y z w]."""
        at = {name: [np.array([x.poses[name][k] for x in self.states]) for k in (0, 1)] for name in self._bodies}
        return {name: np.hstack([p, quaternions(R)]) for name, (p, R) in at.items()}

    @property
    def _bodies(self) -> list[str]:
        return sorted(self.states[0].poses)

    def _rig(self, state: StaticState) -> list[RopeLine]:
        """Return the rope lines of a state, with each sling drawn to the lug to which it is hooked."""
        lugs = lug_places(self.plan.machines)
        ends = {tie.rope: lugs.get(state.hooked[tie.rope], tie.lower) if tie.rope in state.hooked else None
                for tie in self._ties}  # fmt: skip
        return RopeLines(self._systems, bent=False).resting(ends)

    def content(self) -> dict[str, object]:
        """Return all states of the lift as data for the 3D page, in which the state's number replaces the time."""
        channels, rows, end = list[SampleChannel](), list[Floats](), 0
        for topic, names, unit, values in self._columns():
            channels.append(SampleChannel(topic, names, unit, end, end := end + len(names)))
            rows.append(values)
        layout = shown(SampleLayout(channels))
        rigs = [{"t": float(k), "lines": self._rig(x)} for k, x in enumerate(self.states)
                if not k or x.hooked != self.states[k - 1].hooked]  # fmt: skip
        carried = block(self._data)
        return {
            **layout.head(),
            "rows": {
                "t": packed(np.arange(len(self.states), dtype=np.float64), "<f8"),
                "x": packed(np.hstack(rows)[:, layout.columns]),
            },
            "boxes": self._boxes,
            "rig": rigs,
            "rated": rated(self.plan),
            "supports": [x for x in supports(self.plan) if not x["on"]],
            "block": {
                "name": carried["body"],
                "mass": carried["mass"],
                "com": carried.get("com", (0.0, 0.0, 0.0)),
                "lugs": [{"name": name, "p": p} for name, p in carried.get("lugs", {}).items()],
            } if carried else None,
            "states": [
                {"t": x.t, "action": x.action, "stage": x.stage, "event": x.event, "last": self._last(k)}
                for k, x in enumerate(self.states)
            ],
        }  # fmt: skip

    def _last(self, k: int) -> bool:
        """Return whether a state is the last one of its action."""
        return k + 1 == len(self.states) or self.states[k + 1].action != self.states[k].action

    def _columns(self) -> list[tuple[str, list[str], str, Floats]]:
        found = [(POSE + name, list(POSE_COLUMNS), "", x) for name, x in self._poses.items()]
        for topic, part in SIGNALS.items():
            names = sorted(getattr(self.states[0], part))
            values = np.array([[getattr(x, part)[name] for name in names] for x in self.states])
            found.append((topic, names, "N", values.reshape(len(self.states), len(names))))
        return found

    def drawings(self, k: int) -> list[dict[str, str]]:
        """Return plan view and two elevations of the lift in state k, each with its title; empty if nothing hangs on
        hooks."""
        state = self.states[k]
        if not any(machine.hooks for machine in self.plan.machines):
            return []
        poses = {name: x[k] for name, x in self._poses.items()}
        rig, hung = self._rig(state), hanging(self.plan)
        x = instant(self._data, state.stage, state.t, self._boxes, poses, rig, state.tensions, hung)
        return [{"title": view.title, "svg": svg_alone(view, ROOM)} for view in three(x, ROOM)]
