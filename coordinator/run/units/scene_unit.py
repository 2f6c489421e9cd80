"""The variables and the state of a scene as a co-simulation unit, whatever its version of FMI.

    command                  text; if it differs from that of the step before, it is given at the start of the step
    speed.NAME, wind         speeds of drives and winches [m/s or rad/s] and of the wind [m/s], if the export names them
    PATH                     parameter: an uncertain input of the scene, by its path, such as block.mass
    answer                   why the last command was refused
    events, event            number of events so far, and the last one: its source and port
    tension.NAME, peak.NAME  of a rope now, and the largest so far [N]
    pose.BODY.x ... .qw      position [m] and quaternion of a body
    TOPIC.NAME               each other signal, such as joint.position.rail.travel

A saved state lists all steps and settings of the unit; restoring repeats them, which gives equal bits and takes as long
as the steps did. The unit needs this version of heavylift in the Python that the importing program loads.
"""

import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import msgspec
from heavylift.kernel.description.forces import InputSignal, Wind
from heavylift.kernel.description.mechanics import JOINTS
from heavylift.kernel.errors import HeavyliftError, SceneError
from heavylift.kernel.trust import demand
from heavylift.nodes.devs import FOREVER, seconds
from heavylift.nodes.plan.plan import Plan, decode, functions
from heavylift.nodes.plan.user_models import UserModel
from heavylift.nodes.scene import LoadedScene, restored
from heavylift.nodes.scene.inputs import UncertainInput, uncertain_inputs, varied
from heavylift.nodes.scene.operator_command import spoken

from .steppable_run import SteppableRun

KEPT = "scene.heavylift"
SHORT = {"rope/tension": "tension", "rope/peak": "peak"}  # topics with names of their own


class UnitScene(msgspec.Struct):
    """The scene of a co-simulation unit as stored in its FMU.

    `masters`: models through which the importing program sets speeds of drives and winches; `wind`: whether that
    program also sets the wind speed.
    """

    plan: bytes
    text: str
    merged: str
    name: str
    masters: tuple[UserModel, ...] = ()
    wind: bool = False


class UnitVariable(NamedTuple):
    """A real variable of a unit, with its unit in SI."""

    name: str
    kind: str  # parameter, input, output
    unit: str
    get: Callable[[], float]
    set: Callable[[float], None] | None = None


class SteppedScene:
    """The scene of an FMU, read from a folder and run step by step; `command`: the text of the last command."""

    def __init__(self, folder: Path) -> None:
        self._kept = msgspec.msgpack.decode((folder / KEPT).read_bytes(), type=UnitScene)
        plan = decode(self._kept.plan)
        demand(functions(plan), f"{self._kept.name}.fmu")
        self._scene: LoadedScene = restored(plan, self._kept.text, self._kept.merged, self._kept.name)
        self._uncertain: dict[str, UncertainInput] = {x.name: x for x in uncertain_inputs(self._scene)}
        self._values: dict[str, float] = {}
        self.command = self._said = ""
        self._begin()

    @property
    def plan(self) -> Plan:
        """The plan of the scene, with the parameter values that were set."""
        changed = [self._uncertain[name] for name in sorted(self._values)]
        scene = varied(self._scene, changed, [self._values[x.name] for x in changed]) if changed else self._scene
        return led(scene.plan, self._kept.masters, self._kept.wind)

    def _begin(self) -> None:
        """Begin the run again."""
        plan, kept = self.plan, self._kept

        def answer(text: str) -> bytes:
            return msgspec.msgpack.encode(spoken(restored(plan, kept.text, kept.merged, kept.name), text))

        self.run, self._stale = SteppableRun(plan, answer), False

    def declared(self, text: Any, real: Any, causality: Any, discrete: object, variability: Any) -> list[Any]:
        """Return the variables of the unit as objects of an FMI library: the command, its answer, the last event, and
        all numbers.

        `text`, `real`: the library's classes of variables; `variability`: that of each kind of number.
        """
        give, answers = partial(setattr, self, "command"), {"answer": "refused", "event": "event"}
        made = [text("command", start="", causality=causality.input, variability=discrete,
                     getter=partial(getattr, self, "command"), setter=give)]  # fmt: skip
        for name, of in answers.items():
            get = partial(lambda x: getattr(self.run, x), of)  # of the present run, which may begin again
            made.append(text(name, getter=get, causality=causality.output, variability=discrete))
        for x in self.variables():
            more = {"causality": causality[x.kind], "variability": variability.get(x.kind), "getter": x.get}
            made.append(real(x.name, setter=x.set, **more))
        return made

    def variables(self) -> Iterator[UnitVariable]:
        """Yield all real variables of the unit: parameters, inputs, outputs."""
        for name, one in self._uncertain.items():
            unit = next((u for u, factor in one.units.items() if factor == 1), "") or "1"
            get = partial(self._value, one)
            yield UnitVariable(name, "parameter", unit, get, partial(self._set_value, one))
        turning = _turning(self._scene.plan)
        tugs = {line.name for machine in self._scene.plan.machines for line in machine.system.tugger_lines}
        for actuator in self.run.speeds:
            unit = "rad/s" if actuator in turning else "N/s" if actuator in tugs else "m/s"
            get = partial(lambda name: self.run.speeds[name], actuator)
            yield UnitVariable(f"speed.{actuator}", "input", unit, get, partial(self._set_speed, actuator))
        if self._kept.wind:
            yield UnitVariable("wind", "input", "m/s", lambda: self.run.wind, lambda v: self.run.set_wind(v))
        yield UnitVariable("events", "output", "1", lambda: float(self.run.events))
        for column, unit in self.run.columns.items():
            topic, name = column.rsplit("/", 1)
            if topic == "rope/peak":
                continue
            shown = f"{SHORT.get(topic, topic.replace('/', '.'))}.{name}"
            yield UnitVariable(shown, "output", unit, partial(lambda x: self.run[x], column))
        for rope in self.run.peaks:
            yield UnitVariable(f"peak.{rope}", "output", "N", partial(lambda x: self.run.peaks[x], rope))

    def _value(self, one: UncertainInput) -> float:
        return self._values.get(one.name, one.value)

    def _set_value(self, one: UncertainInput, value: float) -> None:
        if value != self._value(one):
            self._values[one.name], self._stale = value, True

    def _set_speed(self, actuator: str, value: float) -> None:
        self.run.set_speed(actuator, value)

    def ready(self) -> None:
        """Begin the run with the parameters and inputs that were set during initialisation."""
        if self._stale:
            speeds, wind = self.run.speeds, self.run.wind
            self._begin()
            for actuator, speed in speeds.items():
                self.run.set_speed(actuator, speed)
            self.run.set_wind(wind)

    def start(self, start_time: float, stop_time: float | None) -> None:
        """Set start and end of the experiment [s]; raises SceneError unless it starts at 0, where the scene starts."""
        if start_time:
            raise SceneError(f"the scene begins at 0 s; set startTime to 0, not to {start_time:g}")
        self.run.stop = FOREVER.t if stop_time is None else seconds(stop_time)

    def step(self, to: float, log: Callable[[str], object], events: bool = False) -> bool | None:
        """Advance to a time [s], or with `events` to the first event before it; return whether an event ended the step.

        None: the step is refused, with the reason in the log.
        """
        if self.command != self._said and self.command:
            self.run.order(self.command)
        self._said = self.command
        try:
            return self.run.go(seconds(to), events)
        except HeavyliftError as error:
            log(str(error))
            sys.stderr.write(f"heavylift: {error}\n")  # many masters drop the log, and take this for an early end
            return None

    def state(self) -> dict[str, Any]:
        """Return the state of the unit as JSON: all its steps and settings so far."""
        given, values = [*self.run.given], {**self._values}
        return {"given": given, "seen": self.run.seen, "values": values, "command": self._said, "stop": self.run.stop}

    def restore(self, state: dict[str, Any]) -> None:
        """Restore a saved state of the unit."""
        self._values, self.command = dict(state["values"]), state["command"]
        self._begin()
        self._said, self.run.stop = self.command, state["stop"]
        self.run.repeat([tuple(x) for x in state["given"]], state["seen"])


def led(plan: Plan, masters: tuple[UserModel, ...], wind: bool) -> Plan:
    """Return the plan with the models `masters`, through which an importing program orders speeds, and with settable
    wind if `wind`."""
    plan = msgspec.structs.replace(plan, models=(*plan.models, *masters))
    if not wind:
        return plan
    machines = []
    for machine in plan.machines:
        forces = tuple(_from_outside(f) if isinstance(f, Wind) else f for f in machine.system.forces)
        machines.append(msgspec.structs.replace(machine, system=replace(machine.system, forces=forces)))
    return msgspec.structs.replace(plan, machines=tuple(machines))


def _from_outside(wind: Wind) -> Wind:
    """Return a wind force whose speed is set during the run."""
    first = wind.signal.values[0] if wind.signal.times else wind.signal.value
    return msgspec.structs.replace(wind, signal=InputSignal(first, driven=True))


def _turning(plan: Plan) -> set[str]:
    """Return the drives of joints that turn."""
    systems = [machine.system for machine in plan.machines]
    kinds = {joint.name: JOINTS[joint.kind] for system in systems for joint in system.joints}
    found = set()
    for drive in (drive for system in systems for drive in system.drives):
        if (kind := kinds.get(drive.joint)) is not None:
            names = list(kind.coordinates)
            if kind.turns(names.index(drive.coordinate) if drive.coordinate else 0):
                found.add(drive.name)
    return found
