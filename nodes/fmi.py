"""A co-simulation unit (FMI 2.0 or 3.0) as an atomic: inputs held, steps of a fixed length, which is its lookahead.

    plant = yard.add(Fmu("plant", "units/plant.fmu", step=ms(10), outputs=["x", "v"], parameters={"m": 2.0}))
    yard.connect(controller.u, plant.u); yard.connect(plant.y, controller.y)

At t = 0, h, 2 h, ... it says its outputs.  What it hears at n h enters the step that begins then, what it hears between
two of them the next one.  So what is said at t cannot come of anything heard after t - h, and all times are exact: of
the Jacobi schemes of co-simulation this is the one without extrapolation.  A unit that can save its state has
checkpoints; the process of one that cannot is replayed from the start if it is lost, as the run says.

A unit is machine code: it runs only from a folder that the user has trusted (`heavylift trust`).
Standards: FMI 2.0.4 and 3.0.1, Modelica Association.
"""

from __future__ import annotations

import hashlib
import os
import shutil
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any
from uuid import uuid4

from heavylift.kernel.cache import cache_folder, unsafe_cache
from heavylift.kernel.errors import ModelError
from heavylift.kernel.trust import refusal
from heavylift.nodes.devs import Atomic, Bag, In, Message, Out

__all__ = ["Fmu", "Signals", "Stepped"]

KINDS = {  # type of a variable in either standard -> the end of its getter and setter, and how Python has it
    "Real": ("Real", float),
    "Float64": ("Float64", float),
    "Float32": ("Float32", float),
    "Integer": ("Integer", int),
    "Int32": ("Int32", int),
    "Int64": ("Int64", int),
    "Boolean": ("Boolean", bool),
}


class Signals(Message):
    """Values by the names of variables; integers and truth values as numbers."""

    values: tuple[tuple[str, float], ...]


class Stepped(Atomic):
    """The unit of a file, stepped by `step` [ns]; who derives from it has the ports and says what was `said`."""

    def __init__(
        self,
        name: str,
        file: str | Path,
        step: int,
        outputs: Sequence[str],
        parameters: Mapping[str, float] | None = None,
        who: str = "",
    ) -> None:
        """`outputs`: variables that it says; `parameters`: their values before it starts. ModelError says what is
        wrong with the file, or that it is not trusted, of `who` it is if that is not its name."""
        super().__init__(name)
        if type(step) is not int or step <= 0:
            raise ModelError(f"{name}: step={step!r} must be an int > 0 in ns, use ms(10)")
        self.unit = Unit(Path(file).resolve(), who or name, tuple(outputs), dict(parameters or {}))
        self.step, self.number = step, 0

    def start(self) -> None:
        """At t = 0 it says what it has after its initialisation."""
        self.number = 0
        self.unit.begin()
        self.said = Signals(self.unit.outputs())
        self.hold_in(0)

    def confluent(self, x: Bag) -> None:
        """What arrives when a step begins belongs to that step."""
        self.external(0, x)
        self.internal()

    def internal(self) -> None:
        """Do the next step now: its result is what will be said at its end."""
        self.unit.advance(self.number * self.step * 1e-9, self.step * 1e-9)
        self.number += 1
        self.said = Signals(self.unit.outputs())
        self.hold_in(self.step)


class Fmu(Stepped):
    """The unit of a file, stepped by `step` [ns]; its port y has that lookahead."""

    u, y = In(Signals), Out(Signals)

    def __init__(
        self,
        name: str,
        file: str | Path,
        step: int,
        outputs: Sequence[str],
        parameters: Mapping[str, float] | None = None,
    ) -> None:
        super().__init__(name, file, step, outputs, parameters)
        self.y.lookahead = step

    def external(self, e: int, x: Bag) -> None:
        """Hold the inputs; of two for one variable the later one."""
        for signals in x[self.u]:
            self.unit.hold(signals.values)

    def output(self) -> None:
        """The outputs at this time."""
        self.y.send(self.said)


class Unit:
    """An instance of a unit with its state; as bytes if it can save that."""

    def __init__(self, file: Path, name: str, said: tuple[str, ...], parameters: dict[str, float]) -> None:
        self.file, self.name, self.said, self.parameters = file, name, said, parameters
        self._fmu: Any = None
        self._state: bytes | None = None  # of the last step
        if why := refusal(str(file)):
            raise ModelError(f"{name}: {why}")
        self._look(description(file, name))

    def _look(self, told: Any) -> None:
        """Variables and abilities."""
        self._told = told
        self._variables = {v.name: v for v in told.modelVariables}
        unit = told.coSimulation
        self.keeps = bool(unit.canGetAndSetFMUstate and unit.canSerializeFMUstate)
        self.check((*self.said, *self.parameters))

    def _kind(self, name: str) -> tuple[Any, str, Any]:
        """Reference, name and Python type of a variable."""
        found = self._variables.get(name)
        if found is None:
            known = ", ".join(v for v, x in self._variables.items() if x.causality in ("input", "output", "parameter"))
            raise ModelError(f"{self.name}: {self.file.name} has no variable {name}; it has {known}")
        if found.type not in KINDS:
            raise ModelError(f"{self.name}: variable {name} of {self.file.name} is a {found.type}, and no number")
        return found.valueReference, *KINDS[found.type]

    def check(self, names: Iterable[str]) -> None:
        """ModelError if one of these is no variable."""
        for name in names:
            self._kind(name)

    def begin(self) -> None:
        """A new instance, initialised at time 0 with the parameters."""
        self._made()
        if self._told.fmiVersion == "2.0":
            self._fmu.setupExperiment(startTime=0.0)
        self.hold(self.parameters.items())
        self._fmu.enterInitializationMode()
        self._fmu.exitInitializationMode()

    def _made(self) -> None:
        if self._fmu is not None:
            self._fmu.freeInstance()
        self._fmu = library(self.name).instantiate_fmu(str(unpacked(self.file)), self._told, "CoSimulation")

    def hold(self, values: Any) -> None:
        """Set variables, which keep these values."""
        self._state = None
        for name, value in values:
            reference, kind, python = self._kind(name)
            getattr(self._fmu, f"set{kind}")([reference], [python(value)])

    def advance(self, t: float, h: float) -> None:
        """One step [s]."""
        self._state = None
        self._fmu.doStep(t, h)

    def outputs(self) -> tuple[tuple[str, float], ...]:
        """What it says now."""
        found = []
        for name in self.said:
            reference, kind, _ = self._kind(name)
            found.append((name, float(getattr(self._fmu, f"get{kind}")([reference])[0])))
        return tuple(found)

    def __getstate__(self) -> tuple[object, ...]:
        if not self.keeps:
            raise TypeError(f"{self.file.name} cannot save its state")
        if self._fmu is not None and self._state is None:
            state = self._fmu.getFMUState()
            self._state = bytes(self._fmu.serializeFMUState(state))
            self._fmu.freeFMUState(state)
        return str(self.file), self.name, self.said, self.parameters, self._state

    def __setstate__(self, kept: tuple[Any, ...]) -> None:
        file, name, said, parameters, data = kept
        self.__init__(Path(file), name, said, parameters)  # type: ignore[misc]
        if data is not None:
            self.begin()
            state = self._fmu.deserializeFMUState(data)
            self._fmu.setFMUState(state)
            self._fmu.freeFMUState(state)
            self._state = data


def description(file: Path, name: str) -> Any:
    """What a unit tells of itself; ModelError if it is none for co-simulation."""
    try:
        told = library(name).read_model_description(str(file))
    except Exception as error:
        raise ModelError(f"{name}: {file} is no unit that can be read ({' '.join(str(error).split())})") from None
    if told.fmiVersion.partition(".")[0] not in ("2", "3") or told.coSimulation is None:
        raise ModelError(f"{name}: {file.name} is of FMI {told.fmiVersion} and must be of 2 or 3, for co-simulation")
    return told


def unpacked(file: Path) -> Path:
    """The folder of an unpacked unit, kept for the next run under the hash of its bytes."""
    if why := unsafe_cache():
        raise ModelError(f"{file.name} cannot be unpacked: {cache_folder()} {why}")
    there = cache_folder() / f"fmu-{hashlib.sha256(file.read_bytes()).hexdigest()[:32]}"
    if not there.is_dir():
        fresh = there.with_name(f"{there.name}-{uuid4().hex}")
        library(file.name).extract(str(file), str(fresh))
        try:
            os.rename(fresh, there)
        except OSError:  # another process was quicker
            shutil.rmtree(fresh)
    return there


def library(name: str) -> Any:
    """FMPy; ModelError says how to get it."""
    try:
        import fmpy
    except ImportError:
        raise ModelError(f"{name}: a unit of FMI needs FMPy: pip install 'heavylift[fmi]'") from None
    return fmpy
