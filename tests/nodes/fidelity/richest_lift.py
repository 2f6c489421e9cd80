"""A lift at the finest model level in independent code: maximal coordinates, NumPy, SciPy's Radau.

Every loader is two rigid bodies with Lagrange multipliers at their hinge, every hook rope a chain of lumps (x, y, z and
yaw), the girder its first mode with what it carries, trolleys and gantries masses on servos, supports springs that only
push.  It plays the action list itself.  Numbers (masses, lengths, speeds) come from the plan; equations do not.

    richest(plan, rtol=1e-6) -> History: times, hook tensions, block positions, when each action ended
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from maximal_lift import Lift
from maximal_parts import Reference, trapezoid
from scipy.integrate import Radau
from vectors import rotation

INSIDE = np.array([0.2, 0.4, 0.6, 0.8])  # where peaks are looked for within a step


@dataclass
class History:
    """What one run showed at the ends of all steps."""

    hooks: list[str]
    times: list[float] = field(default_factory=list)
    tensions: list[np.ndarray] = field(default_factory=list)
    places: list[np.ndarray] = field(default_factory=list)  # of the middle of the block
    ended: list[float] = field(default_factory=list)  # of the actions
    evaluations: int = 0
    states: int = 0
    inside: np.ndarray | float = 0.0  # largest tensions between the ends of steps

    @property
    def cost(self) -> int:
        """Evaluations, those of Jacobians included, times states."""
        return self.evaluations * self.states

    @property
    def peaks(self) -> np.ndarray:
        """(n_hooks,) [N]"""
        return np.maximum(self.inside, np.max(self.tensions, axis=0))


def richest(plan, rtol: float = 1e-6, lumps: int = 2) -> History:
    """Play the action list of a plan."""
    lift = Lift(plan, lumps)
    out = History([r.name for r in lift.ropes], states=len(lift.y0))
    player = _Player(lift, out, rtol)
    for action in plan.actions:
        player.play(action)
        out.ended.append(player.t)
    return out


class _Player:
    """Advances a lift from action to action."""

    def __init__(self, lift: Lift, out: History, rtol: float) -> None:
        self.lift, self.out, self.rtol, self.t, self.y = lift, out, rtol, 0.0, lift.y0
        self.atol = rtol * 1e-3
        self.note(0.0, self.y)

    def play(self, action) -> None:
        """Start all orders; go on until each is done."""
        self.bound = self.lift.plan.end or 1e9
        waiting, until = [self.t], []
        for order in action.orders:
            kind = type(order).__name__
            if kind == "Wait":
                waiting.append(self.t + order.seconds)
                continue
            reference = self.reference(order.actuator)
            if order.until is not None or order.by is None:
                until.append((reference, order))
                reference.begin(self.t, [(abs(order.speed) / order.accel, np.sign(order.speed) * order.accel)])
            else:
                legs = trapezoid(order.by, order.speed, order.accel)
                reference.begin(self.t, legs)
                waiting.append(self.t + sum(d for d, _ in legs))
        if until:
            self.go(None, self.condition(until[0][1].until))
            for reference, order in until:
                _, v = reference(self.t)
                reference.begin(self.t, [(abs(v) / order.accel, -np.sign(v) * order.accel)])
                waiting.append(self.t + abs(v) / order.accel)
        self.go(max(waiting), None)

    def reference(self, name: str) -> Reference:
        names = [r.name for r in self.lift.ropes]
        return self.lift.winches[names.index(name)] if name in names else self.lift.refs[self.lift.names.index(name)]

    def condition(self, until):
        """A function that is positive once it holds."""
        lift = self.lift
        if type(until).__name__ == "LiftedCondition":
            return lambda: -float(lift.standing.max())
        return lambda: float(lift.sling_stretch.min())

    def go(self, until: float | None, holds) -> None:
        """Integrate to a time, or until a condition holds."""
        stop = min(until if until is not None else 1e9, self.bound)
        if stop <= self.t:
            return
        solver = Radau(self.moved, self.t, self.y - self.lift.y0, stop, rtol=self.rtol, atol=self.atol,
                       jac=self.jacobian, first_step=min(1e-3, stop - self.t), max_step=0.25)  # fmt: skip
        while solver.status == "running":
            before = solver.t
            message = solver.step()
            assert solver.status != "failed", message
            if holds is not None and self.value(holds, solver.t, solver.y + self.lift.y0) > 0.0:
                dense, a, b = self.within(solver), before, solver.t
                while b - a > 1e-7:
                    middle = (a + b) / 2.0
                    a, b = (a, middle) if self.value(holds, middle, dense(middle)) > 0.0 else (middle, b)
                self.t, self.y = b, dense(b)
                self.note(self.t, self.y)
                break
            dense = self.within(solver)
            t = before + INSIDE * (solver.t - before)
            self.out.inside = np.maximum(self.out.inside, self.lift.tensions(t, dense(t)).max(0))
            self.t, self.y = solver.t, solver.y + self.lift.y0
            self.note(self.t, self.y)
        self.out.evaluations += solver.nfev + solver.njev * len(self.y)

    def moved(self, t: float, z: np.ndarray) -> np.ndarray:
        """The equations of what has moved since the start, on which relative errors count."""
        return self.lift(t, z + self.lift.y0)

    def within(self, solver: Radau):
        """The state within the last step."""
        dense = solver.dense_output()
        start = self.lift.y0
        return lambda t: (dense(t).T + start).T

    def value(self, holds, t: float, y: np.ndarray) -> float:
        self.lift(t, y)
        return holds()

    def jacobian(self, t: float, y: np.ndarray) -> np.ndarray:
        """By differences, all columns in one batch."""
        h = 1e-7
        y = y + self.lift.y0
        return (self.lift(t, y[:, None] + h * np.eye(len(y))) - self.lift(t, y)[:, None]) / h

    def note(self, t: float, y: np.ndarray) -> None:
        self.out.times.append(t)
        self.out.tensions.append(self.lift.tensions(t, y[:, None])[0])
        n = self.lift.n_bodies
        R = rotation(y[7 * n - 4 : 7 * n])
        self.out.places.append(y[3 * n - 3 : 3 * n] - R @ self.lift.com[-1])
