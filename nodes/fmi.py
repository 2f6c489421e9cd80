"""A co-simulation unit (FMU of FMI 2.0 or 3.0) as an atomic model: inputs are held constant during steps of a fixed
length, which is its lookahead.

    plant = yard.add(Fmu("plant", "units/plant.fmu", step=ms(10), outputs=["x", "v"], parameters={"m": 2.0}))
    yard.connect(controller.u, plant.u); yard.connect(plant.y, controller.y)

The model sends its outputs at t = 0, h, 2 h, ... An input at n h is applied in the step that begins then, an input
between two of these times in the next step. So an output at t does not depend on inputs after t - h, and all times are
exact: of the Jacobi schemes of co-simulation this is the one without extrapolation. A unit of FMI 3 with event mode may
return early: its outputs are then also sent at each of its events, rounded up to the nanosecond; inputs still act from
n h on, and the lookahead is a nanosecond. A unit that can save its state has checkpoints; if the process of a unit that
cannot is lost, the unit is replayed from the start, and a message says so.

A unit is machine code: it runs only from a folder that the user has trusted (`heavylift trust`). Standards: FMI 2.0.4
and 3.0.1, Modelica Association.
"""

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from math import ceil, inf
from pathlib import Path
from typing import Any

from heavylift.kernel.cache import cache_folder, kept_folder, unsafe_cache
from heavylift.kernel.errors import ModelError, extra
from heavylift.kernel.trust import refusal
from heavylift.nodes.devs import Atomic, Bag, In, Message, Out, OutPort

INTEGERS = {name: int for size in (8, 16, 32, 64) for name in (f"Int{size}", f"UInt{size}")}
KINDS = {"2": {"Real": float, "Integer": int, "Enumeration": int, "Boolean": bool}}  # type of a variable in Python
KINDS["3"] = {"Float64": float, "Float32": float, **INTEGERS, "Enumeration": int, "Boolean": bool}
ROUNDING = 1e-3  # [ns] of a time in seconds
NEAR = 0.5e-9  # [s]: nothing is left of a step
ENUMERATION = {"2": "Integer", "3": "Int64"}  # by whose calls it is read and set


class Signals(Message):
    """Message with values of FMU variables by name; integers and booleans are sent as numbers."""

    values: tuple[tuple[str, float], ...]


class Stepped(Atomic):
    """Base class of atomic models that advance an FMU by steps of `step` [ns].

    Subclasses declare the ports and send the outputs of the FMU, which are stored in `said`."""

    def __init__(
        self,
        name: str,
        file: str | Path,
        step: int,
        outputs: Sequence[str],
        parameters: Mapping[str, float] | None = None,
        who: str = "",
    ) -> None:
        """Create the model; raises ModelError for an invalid or untrusted file. `outputs`: variables to send;
        `parameters`: values set before the start; `who`: name in error messages."""
        super().__init__(name)
        if type(step) is not int or step <= 0:
            raise ModelError(f"{name}: step={step!r} must be a positive int in ns, such as ms(10)")
        self.unit = FmuUnit(Path(file).resolve(), who or name, tuple(outputs), dict(parameters or {}))
        self.step, self.number = step, 0
        for port in self.ports.values():
            if isinstance(port, OutPort):
                port.lookahead = 1 if self.unit.events else step

    def start(self) -> None:
        """Initialise the FMU; its outputs are sent at t = 0."""
        self.number = self.reached = 0
        self.unit.begin()
        self.said = Signals(self.unit.outputs())
        self.hold_in(0)

    def confluent(self, x: Bag) -> None:
        """Store the inputs that arrive at the beginning of a step, and then make this step with them."""
        self.external(0, x)
        self.internal()

    def internal(self) -> None:
        """Make the next step, up to its first event if it has one; the outputs are sent at the end of this step."""
        begin, end = self.number * self.step, (self.number + 1) * self.step
        reached = self.unit.advance(begin * 1e-9, self.step * 1e-9, fresh=self.reached == begin)
        then = min(end, max(ceil(reached * 1e9 - ROUNDING), self.reached + 1))
        self.number += then == end
        self.said = Signals(self.unit.outputs())
        self.hold_in(then - self.reached)
        self.reached = then


class Fmu(Stepped):
    """An atomic model that advances an FMU by steps of `step` [ns]; its inputs are at port u, its outputs at port y."""

    u, y = In(Signals), Out(Signals)

    def external(self, e: int, x: Bag) -> None:
        """Store the inputs for the next step; if several values arrive for one variable, the last one counts."""
        for signals in x[self.u]:
            self.unit.hold(signals.values)

    def output(self) -> None:
        """Send the outputs of the FMU at the present time."""
        self.y.send(self.said)


class FmuUnit:
    """An instance of an FMU with its state, which is saved as bytes if the FMU supports it."""

    def __init__(self, file: Path, name: str, text: tuple[str, ...], parameters: dict[str, float]) -> None:
        self.file, self.name, self.said, self.parameters = file, name, text, parameters
        self._fmu: Any = None
        self._state: bytes | None = None  # of the last step
        self._waiting: dict[str, float] = {}  # inputs of the next step
        self._now = 0.0  # where the last step ended [s]
        self._next = inf  # time event that the unit has announced [s]
        if why := refusal(str(file)):
            raise ModelError(f"{name}: {why}")
        self._look(description(file, name))

    def _look(self, message: Any) -> None:
        """Read the variables and capabilities of the FMU from its model description."""
        self._message = message
        self._version = message.fmiVersion[0]
        self._variables = {v.name: v for v in message.modelVariables}
        unit = message.coSimulation
        self.keeps = bool(unit.canGetAndSetFMUstate and unit.canSerializeFMUstate)
        self.events = self._version == "3" and bool(unit.hasEventMode)
        for name in (*self.said, *self.parameters):
            self._kind(name)

    def _kind(self, name: str) -> tuple[Any, str, Any]:
        """Return a variable, the suffix of its getter and setter, and its Python type; raises ModelError if there is no
        such variable."""
        found = self._variables.get(name)
        if found is None:
            known = ", ".join(v for v, x in self._variables.items() if x.causality in ("input", "output", "parameter"))
            raise ModelError(f"{self.name}: {self.file.name} has no variable {name}; it has {known}")
        kind, python = found.type, KINDS[self._version].get(found.type)
        if python is None or found.dimensions:
            what = "an array" if found.dimensions else f"of type {kind}"
            raise ModelError(f"{self.name}: variable {name} of {self.file.name} is {what}, not a number")
        return found, ENUMERATION[self._version] if kind == "Enumeration" else kind, python

    def check(self, names: Iterable[str]) -> None:
        """Raise ModelError if one of these variables cannot be set during a run."""
        for name in names:
            found, _, _ = self._kind(name)
            if found.causality != "input" and (found.causality, found.variability) != ("parameter", "tunable"):
                raise ModelError(
                    f"{self.name}: {name} of {self.file.name} is not an input but {found.causality}; the inputs are "
                    f"{', '.join(v for v, x in self._variables.items() if x.causality == 'input') or 'none'}"
                )

    def begin(self) -> None:
        """Create a new instance of the FMU, and initialise it at time 0 with the parameters."""
        self._made()
        if self._version == "2":
            self._fmu.setupExperiment(startTime=0.0)
        self._set(self.parameters.items())
        self._fmu.enterInitializationMode()
        self._fmu.exitInitializationMode()
        self._waiting, self._now, self._next = {}, 0.0, inf
        if self.events:
            self._update()

    def _made(self) -> None:
        if self._fmu is not None:
            self._fmu.freeInstance()
        more = {"event_mode_used": True, "early_return_allowed": True} if self.events else {}
        folder = str(unpacked(self.file))
        self._fmu = library(self.name).instantiate_fmu(folder, self._message, "CoSimulation", **more)

    def hold(self, values: Iterable[tuple[str, float]]) -> None:
        """Store values of input variables, which the next step sets in the FMU."""
        given = dict(values)
        self.check(given)
        self._waiting |= given

    def _update(self) -> None:
        """Update all discrete states and leave event mode; raises ModelError if the unit terminates meanwhile."""
        again = True
        while again:
            again, over, _, _, timed, then = self._fmu.updateDiscreteStates()
            if over:
                raise ModelError(f"{self.name}: {self.file.name} asks for the end of the simulation at {self._now:g} s")
            self._next = then if timed else inf
        self._fmu.enterStepMode()

    def _set(self, values: Iterable[tuple[str, float]]) -> None:
        self._state = None
        for name, value in values:
            found, kind, python = self._kind(name)
            if python is not float and python(value) != value:
                raise ModelError(
                    f"{self.name}: {name} of {self.file.name} is of type {found.type}, and cannot be {value!r}"
                )
            getattr(self._fmu, f"set{kind}")([found.valueReference], [python(value)])

    def advance(self, begin: float, h: float, fresh: bool = True) -> float:
        """Step the FMU to begin + h [s], or to its first event before that; return the time reached [s].

        `fresh`: a new step begins, so the stored inputs are applied first. Raises ModelError if the FMU terminates
        during the step."""
        self._state, end = None, begin + h
        if fresh:
            self._now = begin
            if self._waiting and self.events:
                self._fmu.enterEventMode()
            self._set(self._waiting.items())
            if self._waiting and self.events:
                self._update()
            self._waiting = {}
        while True:
            whole = self._now == begin and self._next >= end
            length = h if whole else min(self._next, end) - self._now
            event, self._now = self._step(self._now, length)
            timed = self._next <= self._now
            if event or timed:
                self._fmu.enterEventMode()
                self._update()
            if event or timed or end - self._now < NEAR:
                return self._now

    def _step(self, t: float, h: float) -> tuple[bool, float]:
        """Make a step of h [s] from t [s]; return whether the unit needs an event update, and the time reached [s]."""
        try:
            done = self._fmu.doStep(t, h)  # in FMI 3: event, end, early return, time
        except Exception as error:
            stop = getattr(self._message.defaultExperiment, "stopTime", None)
            message = f"; its default experiment stops at {stop} s" if stop else ""
            raise ModelError(
                f"{self.name}: {self.file.name} refuses the step of {h:g} s at {t:g} s ({error}){message}"
            ) from None
        if done and done[1]:
            raise ModelError(f"{self.name}: {self.file.name} asks for the end of the simulation at {done[3]:g} s")
        early = self.events and done[2]
        return self.events and bool(done[0]), done[3] if early else t + h

    def outputs(self) -> tuple[tuple[str, float], ...]:
        """Return the present values of the output variables of the FMU."""
        found = []
        for name in self.said:
            variable, kind, _ = self._kind(name)
            found.append((name, float(getattr(self._fmu, f"get{kind}")([variable.valueReference])[0])))
        return tuple(found)

    def __getstate__(self) -> tuple[object, ...]:
        if not self.keeps:
            raise TypeError(f"{self.file.name} does not support saving its state")
        if self._fmu is not None and self._state is None:
            state = self._fmu.getFMUState()
            self._state = bytes(self._fmu.serializeFMUState(state))
            self._fmu.freeFMUState(state)
        return str(self.file), self.name, self.said, self.parameters, self._state, self._waiting, self._now, self._next

    def __setstate__(self, kept: tuple[Any, ...]) -> None:
        file, name, text, parameters, data, *more = kept
        self.__init__(Path(file), name, text, parameters)  # type: ignore[misc]
        if data is not None:
            self.begin()
            state = self._fmu.deserializeFMUState(data)
            self._fmu.setFMUState(state)
            self._fmu.freeFMUState(state)
            self._state = data
        self._waiting, self._now, self._next = more


def description(file: Path, name: str) -> Any:
    """Return the model description of an FMU; raises ModelError if it does not support co-simulation."""
    try:
        message = library(name).read_model_description(str(file))
    except Exception as error:
        raise ModelError(f"{name}: {file} cannot be read as an FMU ({' '.join(str(error).split())})") from None
    if message.fmiVersion.partition(".")[0] not in ("2", "3") or message.coSimulation is None:
        raise ModelError(
            f"{name}: {file.name} is for FMI {message.fmiVersion}; it must be for co-simulation by FMI 2 or 3"
        )
    return message


def unpacked(file: Path) -> Path:
    """Return the folder of the unpacked FMU, cached by the hash of its bytes."""
    if why := unsafe_cache():
        raise ModelError(f"{file.name} cannot be unpacked: {cache_folder()} {why}")
    unit = library(file.name)
    name = f"fmu-{hashlib.sha256(file.read_bytes()).hexdigest()[:32]}"
    return kept_folder(name, lambda fresh: unit.extract(str(file), str(fresh)))


def library(name: str) -> Any:
    """Return the imported library FMPy; raises ModelError, with the command that installs it, if it is missing."""
    return extra("fmpy", ModelError(f"{name}: an FMU needs FMPy: pip install 'heavylift[fmi]'"))
