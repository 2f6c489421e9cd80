"""A scene as a co-simulation unit of FMI 2.0: commands in; tensions, peaks and poses out at communication points.

    heavylift export-fmu lift -o lift.fmu

The unit runs the scene in the process of its master, by the protocol of any run: `doStep` executes everything before
its end and evaluates the outputs there from the dense output of the mechanics, so that communication points change no
integration step.

    command                  text; if it differs from that of the step before, it is given at the start of the step
    answer                   why the last command was refused
    tension.NAME, peak.NAME  of a rope now, and the largest so far [N]
    pose.BODY.x ... .qw      position [m] and quaternion of a body

A step beyond the end of the scene or of the experiment is discarded, as is one back in time or after the run has
failed, and the log says why: with fmi2Discard a slave ends early (FMI 2.0.4, section 4.2.2), and fmi2LastSuccessfulTime
is the start of the step, no part of which was executed. pythonfmu has no other refusal: an exception becomes fmi2Fatal,
after which a master may not even free the unit, and the inquiry fmi2Terminated returns fmi2Error in every unit that it
makes. The unit needs this heavylift in the Python that the master loads; its state cannot be saved.
"""

import re
import sys
import tempfile
import zipfile
from collections.abc import Callable
from copy import deepcopy
from functools import partial
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element

import msgspec
from heavylift.coordinator.live.command_queue import TimedCommand, command
from heavylift.coordinator.participants.kernel_node import KernelNode
from heavylift.coordinator.participants.session import Session
from heavylift.kernel.errors import HeavyliftError, ModelError, SceneError, path_text
from heavylift.kernel.simulation.native.samples import published
from heavylift.kernel.trust import demand
from heavylift.nodes.devs import FOREVER, Event, Tag, encode, seconds
from heavylift.nodes.models.parts.messages import OperatorAnswer, OperatorCommand
from heavylift.nodes.plan.plan import Plan, decode, encode as plan_bytes, functions
from heavylift.nodes.scene import LoadedScene, restored
from heavylift.nodes.scene.operator_command import spoken
from heavylift.recordings import SampleLayout
from heavylift.recordings.format.text import GENERATOR
from heavylift.recordings.write.partfile import PartFile
from pythonfmu import DefaultExperiment, Fmi2Causality, Fmi2Slave, Fmi2Variability, FmuBuilder, Real, String
from pythonfmu.enums import Fmi2Status

KEPT = "scene.heavylift"
CODE = """import ctypes

from heavylift.coordinator.run.unit import SceneUnit

ctypes.pythonapi.Py_IncRef(ctypes.py_object(globals()))  # pythonfmu gives back one that it has not taken, each time


class {name}(SceneUnit):
    pass
"""


class _UnitScene(msgspec.Struct):
    """The scene of a unit as stored in the FMU."""

    plan: bytes
    text: str
    merged: str
    name: str


class SteppableRun:
    """A run of a scene in this process that advances step by step; `now`: present time [ns]; `refused`: why the last
    command was refused."""

    def __init__(self, plan: Plan, words: Callable[[str], bytes]) -> None:
        """`words` parses a command into the encoded action of an OperatorCommand."""
        self._words, self.now, self.refused, self._over, self._failed = words, 0, "", False, ""
        self.stop = FOREVER.t
        """No step may go beyond [ns]."""
        end = FOREVER if plan.end is None else None
        self._session = Session(plan, lambda config: KernelNode(config, lambda batch: None), self._hear, end)
        self._kernel, self._core = self._session.kernel, self._session.core
        layout = msgspec.msgpack.decode(self._kernel.layout(), type=SampleLayout)
        self._at = {f"{c.topic}/{name}": c.start + i for c in layout.channels for i, name in enumerate(c.names)}
        ropes = [name.removeprefix("rope/tension/") for name in self._at if name.startswith("rope/tension/")]
        self.peaks = dict.fromkeys(ropes, 0.0)
        self._look()

    def _hear(self, event: Event) -> None:
        if isinstance(event.value, OperatorAnswer):
            self.refused = event.value.refused

    def order(self, text: str) -> None:
        """Give a command at the present time; `refused` says why if it is refused."""
        try:
            answer = encode(OperatorCommand(text, self._words(text)))
        except SceneError as error:
            self.refused = str(error).partition("\n")[0]
            return
        if self._core.over is None:
            self._core.inject(command(TimedCommand(Tag(self.now), answer)))

    def go(self, to_ns: int) -> None:
        """Advance to a time [ns]; raises HeavyliftError if the run fails, or if the time lies in the past or beyond the
        end."""
        if self._failed:
            raise ModelError(self._failed)
        if to_ns < self.now:
            raise ModelError(f"the unit is at {self.now / 1e9} s and cannot go back to {to_ns / 1e9} s")
        self._check_end(to_ns)
        try:
            over = self._session.advance(Tag(to_ns))
            self.now = min(to_ns, self._core.end.t)
            if over is not None and not self._over and self.now == self._core.end.t:
                self._kernel.finish(self._core.end)
                self._over = True
            self._look()
        except HeavyliftError as error:
            self._failed = str(error)
            raise
        self._check_end(to_ns)  # perhaps all its actions are done

    def _check_end(self, to_ns: int) -> None:
        """Raise ModelError for a time beyond the end of the scene or of the experiment."""
        ends = {"scene": self._core.end.t, "experiment": self.stop}
        what = min(ends, key=lambda x: ends[x])
        if to_ns > ends[what]:
            raise ModelError(f"the {what} ends at {ends[what] / 1e9:g} s, and no step may go to {to_ns / 1e9} s")

    def _look(self) -> None:
        """Update the values to the present time, or to the end of the run."""
        simulation = self._kernel.simulation
        shown = simulation.shown(simulation.epoch if self._over else max(self.now, simulation.epoch))
        self._row = published(simulation.method, shown[None])[0]
        _, _, most = self._kernel.said
        for rope, known in self.peaks.items():
            message = most[self._at[f"rope/peak/{rope}"]] if len(most) and f"rope/peak/{rope}" in self._at else 0.0
            self.peaks[rope] = max(known, float(message), self[f"rope/tension/{rope}"])

    def __getitem__(self, name: str) -> float:
        """Return the value of a sample column, such as "rope/tension/crane.H1"."""
        return float(self._row[self._at[name]])

    @property
    def poses(self) -> list[str]:
        """Names of the pose columns."""
        return [name for name in self._at if name.startswith("pose/")]


class SceneUnit(Fmi2Slave):  # type: ignore[misc]
    """The slave that an exported FMU runs, for the scene stored next to its module."""

    def __init__(self, **given: object) -> None:
        super().__init__(**given)
        kept = msgspec.msgpack.decode((Path(str(self.resources)) / KEPT).read_bytes(), type=_UnitScene)
        plan = decode(kept.plan)
        demand(functions(plan), f"{kept.name}.fmu")
        self.author, self.description = GENERATOR, f"the scene {plan.name}"
        self.command = self._given = ""
        self.default_experiment = DefaultExperiment(0.0, plan.end, 1 / plan.samples_hz, plan.tolerance)

        def answer(text: str) -> bytes:
            return msgspec.msgpack.encode(spoken(restored(plan, kept.text, kept.merged, kept.name), text))

        self._run = SteppableRun(plan, answer)
        text = {"causality": Fmi2Causality.input, "variability": Fmi2Variability.discrete}
        self.register_variable(String("command", start="", **text))
        of_outputs = {**text, "causality": Fmi2Causality.output}
        self.register_variable(String("answer", getter=lambda: self._run.refused, **of_outputs))
        for rope in self._run.peaks:
            self._register(f"tension.{rope}", "[N]", partial(self._run.__getitem__, f"rope/tension/{rope}"))
            self._register(f"peak.{rope}", "[N], so far", partial(self._run.peaks.__getitem__, rope))
        for pose in self._run.poses:
            self._register(pose.replace("/", "."), "[m] or 1", partial(self._run.__getitem__, pose))

    def _register(self, name: str, unit: str, getter: Callable[[], float]) -> None:
        message = Real(name, causality=Fmi2Causality.output, description=unit, getter=getter)
        self.register_variable(message, nested=False)

    def to_xml(self, *given: Any, **more: Any) -> Element:
        """Return the model description, including what pythonfmu omits: names with hyphens, outputs that are unknown at
        the start."""
        root: Element = super().to_xml(*given, **more)
        root.set("variableNamingConvention", "flat")
        for structure in root.iter("ModelStructure"):
            structure.extend([deepcopy(node) for node in structure])
            structure[-1].tag = "InitialUnknowns"
        return root

    def setup_experiment(self, start_time: float, stop_time: float | None, tolerance: float | None) -> None:
        """Set start and end of the experiment [s]; raises SceneError unless it starts at 0, where the scene starts."""
        if start_time:
            raise SceneError(f"the scene begins at 0 s; set startTime to 0, not to {start_time:g}")
        self._run.stop = FOREVER.t if stop_time is None else seconds(stop_time)

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Make one communication step [s]; returns False to discard it."""
        if self.command != self._given and self.command:
            self._run.order(self.command)
        self._given = self.command
        try:
            self._run.go(seconds(current_time + step_size))
        except HeavyliftError as error:
            self.log(str(error), Fmi2Status.error)
            sys.stderr.write(f"heavylift: {error}\n")  # many masters drop the log, and take this for an early end
            return False
        return True


def export(scene: LoadedScene, output: Path, force: bool = False) -> Path:
    """Write the FMU of a scene and return its path."""
    name = "".join(word.capitalize() for word in re.findall(r"[A-Za-z0-9]+", scene.plan.name))
    name = name if name[:1].isalpha() else f"Scene{name}"
    kept = _UnitScene(plan_bytes(scene.plan), scene.text, scene.merged, path_text(scene.path.name))
    with PartFile(output, "a unit", (".fmu",), force) as file, tempfile.TemporaryDirectory() as folder:
        code, data, made = (Path(folder) / x for x in (f"heavylift_{name.lower()}.py", KEPT, f"{name}.fmu"))
        code.write_text(CODE.format(name=name), encoding="utf-8")
        data.write_bytes(msgspec.msgpack.encode(kept))
        FmuBuilder.build_FMU(code, dest=made, project_files=[data])
        with zipfile.ZipFile(made, "a") as archive:
            archive.comment = GENERATOR.encode()
        with file.writing():
            file.stream.write(made.read_bytes())
    return file.path
