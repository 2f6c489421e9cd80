"""The action list carried out statically: the DEVS models of a scene, with the equilibrium path in place of the kernel.

The commander and the machines are the same models as in a run; time advances, but nothing swings. So each verb,
condition and switch has the same meaning as in a run.
"""

import dataclasses
from math import ceil, pi

import msgspec
import numpy as np
from heavylift.kernel.analysis.path import EquilibriumPath, PathPoint
from heavylift.kernel.description.mechanics import System
from heavylift.kernel.errors import HeavyliftError, KernelError, ModelError
from heavylift.kernel.methods.method import AtRest
from heavylift.kernel.model.program import Program
from heavylift.kernel.model.switching import StateChange as Switched
from heavylift.kernel.simulation.native.samples import shown
from heavylift.kernel.simulation.simulation import Simulation
from heavylift.nodes.devs import Tag, seconds, succ
from heavylift.nodes.models import subscriptions, system
from heavylift.nodes.models.commander.actuator_registry import TURN
from heavylift.nodes.models.parts import messages as m
from heavylift.nodes.plan.plan import Plan

from .contact_limits import apart, meets, there
from .models_at_rest import Models
from .state import REEVING, Acted, Pose, StaticState, reeved

LAST_NS = 100 * 3600 * 10**9  # simulated time after which a list that has not ended never does
WAYPOINT = pi / 12.0  # [rad] a turn of the block stops to be looked at


class StaticRun:
    """Executes the action list of a plan statically, along its equilibrium path.

    `states`: all states so far; `why`: why it ended before the end of the list; `cut`: what the list still waits for
    when the scene ends; `after`: name of a stage after which it stops.
    """

    def __init__(self, plan: Plan, after: str = "") -> None:
        # set-points of user models need simulated signals, which statics does not have
        plan = msgspec.structs.replace(plan, models=())  # what they lead stands
        self.plan, self.after, self.why, self.cut = plan, after, "", ""
        self.models = Models.of(plan)
        self._receives = subscriptions(plan, self.models.models)
        placed = _placed(system(plan, self.models.models))
        self._contacts = placed.contacts
        self.path = EquilibriumPath(_simulation(placed), frozenset(self._receives))
        self.states: list[StaticState] = []
        self.acted: list[Acted] = []
        self.stages: list[str] = []
        """Names of the stages that have begun."""
        self.tripped: list[tuple[float, str]] = []
        """Times [s] at which interlocks tripped, with their names."""
        self.over = self.ended = False
        self._last = Tag(-1)
        self._turned: list[int] = []

    def rest(self) -> StaticState:
        """Return the equilibrium at the start, before the first action."""
        self.path.start()
        self._collect()
        return self.states[0]

    def walk(self) -> None:
        """Follow the action list statically to its end, to the end of a stage, or as far as an equilibrium exists."""
        end = LAST_NS if self.plan.end is None else seconds(self.plan.end)
        try:
            happened = self.path.start()
            self._collect()
            happened += self._tight()
            self.simulator = self.models.simulator
            self.simulator.start()
            first = self.models.commander.actions
            self.acted += [self._begun()] * first.index
            while not self.over:
                while happened:
                    happened = self._tell(happened)
                due = self.simulator.next_time
                # waypoints already passed
                while self._turned and self._turned[0] <= self.path.epoch:
                    self._turned.pop(0)
                happened = self.path.run(min(due.t, end, *self._turned[:1]))
                self._collect()
                if not happened and self.path.epoch >= end:
                    self.ended = True
                    break
                if not happened and self.path.epoch == due.t and not self.over:
                    happened = self._transit(due)
        except HeavyliftError as error:
            # equilibria before the failure belong to the report
            self._collect()
            if isinstance(error, ModelError) and len(self.acted) < len(self.plan.actions):
                self.acted.append(self._begun())  # the action that was refused
            self.why = str(error)
        if self.states and not self.why:
            self._check_stability()
        if not self.why and not self.over:
            waits = self.models.commander.waiting_for()
            self.cut, self.why = (waits, "") if self.ended else ("", waits)

    # ---- models and path ----------------------------------------------------------------------------------

    def _tight(self) -> list[Switched]:
        """Return events for slings that are taut at the start and that the models assume to be slack."""
        # the path starts in equilibrium, where some slings carry already; models learn that by events
        carried = self.states[-1].tensions
        hooked = [tie.rope for x in self.plan.machines for tie in x.ties if tie.lug and tie.rope not in x.taut]
        return [Switched(name, "taut", carried[name]) for name in hooked if carried.get(name, 0.0) > 0.0]

    def _transit(self, tag: Tag) -> list[Switched]:
        """Execute the transitions of the models at a logical time, and return the mechanical events that result."""
        text = self.simulator.outputs()
        stages = [e.value.name for e in text if isinstance(e.value, m.Stage)]
        if any(isinstance(e.value, m.Finished) for e in text) or (stages and self.after in self.stages):
            self.over = True
            return []
        self.stages += stages
        number, begun = self.models.commander.actions.index, len(self.acted)
        self._advance(tag)
        inputs = [e.value for e in text if isinstance(e.value, m.KernelInput)]
        before = len(self.path.command.log)
        for value in inputs:
            self._execute(value)
        changed = [x for _, x in self.path.command.log[before:] if x.name in self._receives]
        if not inputs:
            return []
        settled = self.path.settle()
        # the state after commands still belongs to the action that ended there
        self._collect(number)  # what is commanded now was ordered before
        self.acted[begun:] = [self._begun()] * (len(self.acted) - begun)
        return [*changed, *settled]

    def _execute(self, value: m.KernelInput) -> None:
        """Apply an input for the kernel to the equilibrium path."""
        value.apply(self.path.command)
        if isinstance(value, m.SetProfile) and value.actuator == TURN:
            self._turned = self._waypoints()

    def _tell(self, happened: list[Switched]) -> list[Switched]:
        """Pass mechanical events to the models, and return the events that result."""
        heard = [(model, e) for e in happened for model in self._receives.get(e.name, ())]
        if not heard:
            return []
        for model, e in heard:
            self.simulator.inject(f"state_{model}", m.StateEvent(e.name, e.what, e.value))
        # a microstep later than the last transition, as superdense time requires
        tag, due = max(Tag(self.path.epoch), succ(self._last)), self.simulator.next_time
        if due <= tag:
            return self._transit(due)
        self._advance(tag)
        return []

    def _advance(self, tag: Tag) -> None:
        """Advance the models to a logical time; store the present state for the actions that begin then."""
        commander = self.models.commander.actions
        before, tripped = commander.index, commander.picture.tripped
        self.simulator.advance(tag)
        new = commander.picture.tripped - tripped
        self.tripped += [(self.path.epoch * 1e-9, name) for name in sorted(new)]
        self._last = tag
        if commander.index > before:
            self._check_stability()
        self.acted += [self._begun()] * (commander.index - before)

    def _check_stability(self) -> None:
        """Compute and store the smallest stiffness of the equilibrium at the end of an action; negative if it is
        unstable."""
        self.states[-1] = dataclasses.replace(self.states[-1], stiffness=self.path.stiffness())

    def _begun(self) -> Acted:
        """Return the present state as the one in which an action begins."""
        commander = self.models.commander.actions
        taut = tuple(name for name, state in commander.picture.ropes.items() if state == "taut")
        return Acted(dataclasses.replace(self.states[-1], hooked=dict(commander.lugs)), taut, self.path.epoch * 1e-9)

    def _waypoints(self) -> list[int]:
        """Return the times [ns] at which a turn reaches multiples of the angle `WAYPOINT`."""
        a = self.path.command.references.actuators[TURN]
        # a turn without end has no waypoints
        if not a.move.duration < 1e9:
            return []
        start, distance = a.start_ns, a.move.displacement(a.move.duration)
        first, last = sorted((a.x0, a.x0 + distance))
        angles = [k * WAYPOINT for k in range(ceil(first / WAYPOINT), ceil(last / WAYPOINT))]
        times = []
        for part in sorted((angle - a.x0) / distance for angle in angles if first < angle < last):
            # profile times are found by bisection, as displacement has no closed inverse for three pieces
            low, high = 0, seconds(a.move.duration)
            while high - low > 1:
                middle = (low + high) // 2
                behind = a.move.displacement(middle * 1e-9) / distance < part
                low, high = (middle, high) if behind else (low, middle)
            times.append(start + high)
        return times

    # ---- points -------------------------------------------------------------------------------------------

    def _collect(self, number: int | None = None) -> None:
        """Store the new points of the path as states of an action."""
        commander = self.models.commander.actions
        number = commander.index if number is None else number
        action = self.plan.actions[number - 1] if number else None
        stage = (action.stage or f"action {number}") if action else "at the start"
        new, self.path.points[:] = list(self.path.points), []
        for rest in new:
            state = self._state(rest, number, stage, dict(commander.lugs))
            self._look(state)
            self.states.append(state)

    def _look(self, state: StaticState) -> None:
        """Raise KernelError if rigid shapes penetrate between the last state and this one."""
        before = self.states[-1] if self.states else state
        found = [(part, x.name) for x in self._contacts if (part := meets(x, before, state)) is not None]
        if found:
            part, name = min(found)
            self.states.append(dataclasses.replace(there(before, state, part), event=f"{name} touches"))
            at = f"at {self.states[-1].t:.1f} s" if state.t else "at the start"
            raise KernelError(f"'{name}' touches {at}; static loads with closed rigid contacts are not computed")

    def _state(self, rest: PathPoint, number: int, stage: str, lugs: dict[str, str]) -> StaticState:
        s, row = self.path.command, rest.row
        system = s.program.system
        tensions = dict(zip((r.name for r in system.ropes), row.tension.tolist(), strict=True))
        tensions |= zip((r.name for r in system.rigid_ropes), row.pull.tolist(), strict=True)
        parts = [(reeved(part), float(row.shown[i])) for part, i in shown(s.program).get((REEVING, "N"), ())]
        # a rope over sheaves is represented by its most loaded part
        tensions |= {rope: max(x for other, x in parts if other == rope) for rope, _ in parts}
        supports = dict(zip((u.name for u in system.supports), row.normal.tolist(), strict=True))
        poses, q = row.poses.reshape(-1, 12).tolist(), row.q.tolist()
        loads = {cargo.body for machine in self.plan.machines for cargo in machine.cargo}
        names = [d.name for d in system.drives] + [r.name for r in system.all_ropes if r.winch]
        names += [x.name for x in system.masters]
        t = rest.t_ns
        return StaticState(
            t=t * 1e-9,
            action=number,
            stage=stage,
            event=", ".join(f"{e.name} {e.what}" for e in rest.events if e.what not in ("stick", "slip")),
            tensions=tensions,
            supports=supports,
            poses={k.body.name: _pose(x) for k, x in zip(s.program.graph.links, poses, strict=True)},
            coordinates={k.joint.name: q[k.q.start] for k in s.program.graph.links if k.q.stop > k.q.start},
            references={name: s.references.value(name, t) for name in names},
            speeds={name: s.references.speed(name, t) for name in names},
            hooked=lugs,
            grounded=any(supports[u.name] > 0.0 for u in system.supports if u.point.body in loads),
            modes={k.body.name: tuple(q[k.q_modes]) for k in s.program.graph.links if k.n_modes},
            stiffness=None,
        )


def _pose(x: list[float]) -> Pose:
    return (x[0], x[1], x[2]), ((x[3], x[4], x[5]), (x[6], x[7], x[8]), (x[9], x[10], x[11]))


def _simulation(system: System) -> Simulation:
    """Return the simulation for static calculations. Only contacts that touch at the start are kept, since only these
    can carry a load; the path ends where other shapes touch. All contacts are kept if loops of joints determine
    positions."""
    if system.contacts:
        free = dataclasses.replace(system, contacts=())
        program = Program(free)
        if not len(program.constraints):
            # contacts that do not touch at the start could only end the path; `meets` looks for them geometrically
            touching = [c for c in system.contacts if not apart(c, *(_begins(program, x.body) for x in (c.a, c.b)))]
            system = dataclasses.replace(system, contacts=tuple(touching)) if touching else free
    return Simulation(system, method=AtRest.name)


def _begins(program: Program, body: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the position and rotation of a body at the start."""
    R, p = program.poses_at_start(body)
    return p.astype(float), R.astype(float)


def _placed(system: System) -> System:
    """Return the system with speed-controlled drives replaced by drives with a prescribed position."""
    # a drive that controls speed holds no position; at rest only its commanded position counts
    drives = tuple(dataclasses.replace(d, kind="prescribed") if d.kind == "speed" else d for d in system.drives)
    return dataclasses.replace(system, drives=drives)
