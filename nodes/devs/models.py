"""Atomic and coupled models: Parallel DEVS (Chow and Zeigler 1994; Zeigler et al. 2000).

    X, Y    the ports In, Out                            delta_ext   external(e, x)
    S       the attributes, set by start()               delta_int   internal()
    ta      hold_in(ns), passivate()                     delta_con   confluent(x)
    lambda  output(): sends, and changes nothing            result()     its result at the end of a run

`hold_in` counts from the tag of the transition that calls it; in `start()` it counts from before (0, 0), so that
`hold_in(0)` there sends at (0, 0). An `external` that calls neither leaves the schedule unchanged; `internal` must call
one of them. A coupled model has children and couplings only; flattening dissolves it.
"""

import re
from collections.abc import Callable
from functools import lru_cache
from typing import Any, TypeVar

from heavylift.kernel.errors import ModelError

from .events import NEVER, Instant, Tag, beyond
from .messages import Message
from .ports import Bag, In, InPort, M, Out, OutPort, Port, checked_type

_NAME = re.compile(r"[A-Za-z0-9_-]+")
Child = TypeVar("Child", bound="Model")


class Present:
    """State shared by a simulator and its models: logical time, active model, outputs, requested structure changes."""

    __slots__ = ("busy", "changes", "live", "node", "now", "sources", "speaker", "values")

    def __init__(self, live: bool = False, node: bool = False) -> None:
        self.live = live
        self.node = node  # whether a model without a parent is one node, and no whole model
        self.busy = False  # in the middle of a tag, or of a start
        self.now: Instant = (0, 0)
        self.speaker: Model | None = None  # whose output() runs
        self.sources: list[Port[Message]] = []  # of the messages of this tag, and
        self.values: list[Message] = []  # the messages
        self.changes: list[tuple[Coupled, Callable[[], None]]] = []  # of the structure, after this tag


IDLE = Present()  # of models that no simulator has


def out_of_reach(path: str, name: str) -> ModelError:
    """Return the error for access to an attribute that models must not use during a run."""
    root = path.partition(".")[0]
    return ModelError(
        f"{path}.{name} cannot be accessed: in a run each child of {root} is a separate node; send messages, or put "
        "models that need each other into one Coupled"
    )


_DECLARED: dict[type, list[tuple[str, In[Message] | Out[Message]]]] = {}


def _declared(cls: type["Model"]) -> list[tuple[str, In[Message] | Out[Message]]]:
    """Return the ports declared by a class and its base classes, with their names."""
    if cls not in _DECLARED:
        found = ((key, x) for base in reversed(cls.__mro__) for key, x in vars(base).items())
        _DECLARED[cls] = [(key, x) for key, x in found if isinstance(x, In | Out)]
    return _DECLARED[cls]


class Model:
    """A named model with ports; its path consists of the names from the root, joined by dots."""

    __slots__ = ("__dict__", "_path", "_present", "name", "parent", "ports")

    def __init__(self, name: str) -> None:
        if not _NAME.fullmatch(name):
            raise ModelError(f"{name!r} is not a valid name of a model: use letters, digits, _ and - only")
        self.name = name
        self.parent: Coupled | None = None
        self._path = ""  # known while it runs
        self._present = IDLE
        self.ports: dict[str, Port[Message]] = {}
        for key, declared in _declared(type(self)):
            if isinstance(declared, In):
                setattr(self, key, self.add_in(key, declared.type))
            else:
                setattr(self, key, self.add_out(key, declared.type, declared.lookahead))

    @property
    def path(self) -> str:
        """The names from the root down to this model, joined by dots."""
        path, known, above = self._path or self.name, self._path, self.parent
        while not known and above is not None:  # no recursion: nests may be deep
            path, known, above = f"{above._path or above.name}.{path}", above._path, above.parent
        return path

    def add_in(self, name: str, type: type[M]) -> InPort[M]:
        """Add an input port to this instance of the model, not to its class, and return the port."""
        port: InPort[M] = InPort(self, self._port_name(name), checked_type(type))
        self.ports[name] = port
        return port

    def add_out(self, name: str, type: type[M], lookahead: int = 0) -> OutPort[M]:
        """Add an output port with a lookahead [ns] to this instance, not to its class, and return the port."""
        if not isinstance(lookahead, int) or not 0 <= lookahead <= NEVER:
            big = isinstance(lookahead, int) and lookahead > 0
            message = (
                "of 2**63 ns or more is longer than the largest time"
                if big
                else f"{lookahead!r} is not a number of ns >= 0"
            )
            raise ModelError(f"{self.path}: port {name}: lookahead {message}")
        port: OutPort[M] = OutPort(self, self._port_name(name), checked_type(type), lookahead)
        self.ports[name] = port
        return port

    def _port_name(self, name: str) -> str:
        if wrong := _wrong(name):
            raise ModelError(f"{self.path}: {wrong}")
        if name in self.ports:
            raise ModelError(f"{self.path}: port {name} is declared twice")
        return name


@lru_cache(4096)
def _wrong(name: str) -> str:
    """Return why a name is invalid for a port; "" if it is valid."""
    if not _NAME.fullmatch(name):
        return f"{name!r} is not a valid name of a port: use letters, digits, _ and - only"
    if hasattr(Atomic, name) or name in ("name", "parent", "ports", "children", "couplings"):
        return f"a port cannot be named {name}: every model has an attribute of this name"
    return ""


class Atomic(Model):
    """Base class of atomic DEVS models.

    A subclass overrides `start`, `external`, `output`, `internal`, and if needed `confluent`."""

    __slots__ = ("_index", "_last", "_more", "_place", "_plain", "_port", "_set", "_t", "_value", "_wait")

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self._index = 0  # rank of the path among all atomics
        self._t = NEVER  # [ns] of the next internal transition
        self._last = 0  # [ns] of the last transition
        self._set = 0  # [ns] of the transition that made the present schedule
        self._wait: int | None = None  # [ns] what the running transition asked for
        self._port: InPort[Message] | None = None  # the bag of this tag: its first message in port, place and value,
        self._place = 0
        self._value: Any = None
        self._more: list[tuple[int, InPort[Message], Message]] | None = None  # then the others as (place, port, value)
        self._plain = type(self).confluent is Atomic.confluent

    @property
    def now(self) -> Tag:
        """The present logical time (time and microstep)."""
        return Tag(*self._present.now)

    def hold_in(self, wait: int) -> None:
        """Schedule the next internal transition `wait` [ns] after now (0: at the next microstep)."""
        if type(wait) is not int:
            raise ModelError(f"hold_in({wait!r}): the wait must be an int in ns, such as seconds(1.5)")
        if not 0 <= wait <= NEVER:
            if wait < 0:
                raise ModelError(f"negative time advance: hold_in({wait}) [ns]; the wait must be >= 0")
            raise ModelError(beyond(wait))
        self._wait = wait

    def passivate(self) -> None:
        """Cancel the next internal transition: the model waits for input."""
        self._wait = NEVER

    def start(self) -> None:
        """Set the model's initial state at logical time (0, 0); a model that schedules nothing here waits for input."""

    def external(self, e: int, x: Bag) -> None:
        """Make the external transition: handle the bag x of inputs, which arrives e [ns] after the last transition."""
        raise ModelError("an input arrived, but the model defines no external(); define it")

    def output(self) -> None:
        """Send the model's outputs at the present logical time; must not change the state.

        The simulator calls it before `internal`, possibly twice."""

    def internal(self) -> None:
        """Make the internal transition at the scheduled logical time."""
        raise ModelError("the scheduled time came, but the model defines no internal(); define it")

    def result(self) -> Message | None:
        """Return the model's result at the end of a run, or None if it has none; must not change the state."""
        return None

    def confluent(self, x: Bag) -> None:
        """Make the transition for inputs at an internal transition; by default `internal`, then `external`."""
        self.internal()
        self.external(0, x)


class Coupled(Model):
    """A coupled DEVS model: `add` its children and `connect` their ports."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.children: dict[str, Model] = {}
        self._coupled: dict[tuple[Port[Message], Port[Message]], None] = {}  # in the order of connection

    @property
    def couplings(self) -> list[tuple[Port[Message], Port[Message]]]:
        """The couplings as pairs (source port, target port), in the order in which they were connected."""
        return list(self._coupled)

    def add(self, child: Child) -> Child:
        """Add a child model and return it; its name must be new in this model."""
        self._change("add", lambda: self._add(child))
        return child

    def remove(self, name: str) -> None:
        """Remove a child model, with all couplings to and from it."""
        self._change("remove", lambda: self._remove(name))

    def _reachable(self, name: str) -> None:
        """Raise ModelError if a running model tries to access a model that is not part of its node."""
        present = self._present
        if self.parent is None and not present.node and (present.busy or present.speaker is not None):
            raise out_of_reach(self.path, name)

    def _change(self, name: str, change: Callable[[], None]) -> None:
        """Apply a change of the model structure: at once or, in a running model, after all transitions of the present
        logical time."""
        if self._present is IDLE and self.parent is None:
            change()
            return
        self._reachable(name)
        root: Model = self
        while not root._present.live and root.parent is not None:
            root = root.parent
        present = root._present
        if not present.live:
            change()
        elif present.speaker is None:
            present.changes.append((self, change))
        else:
            raise ModelError(f"output() must not change the structure of {self.path}: do that in a transition")

    def _add(self, child: Model) -> None:
        if not hasattr(child, "ports"):
            raise ModelError(f"{self.path}: {type(child).__name__}.__init__ must call super().__init__(name)")
        if child.name in self.children:
            raise ModelError(f"{self.path}: two children are named {child.name}; rename one of them")
        if child.parent is not None or child is self:
            raise ModelError(f"{self.path}: {child.path} already has a parent and cannot be added here")
        child.parent = self
        self.children[child.name] = child

    def _remove(self, name: str) -> None:
        child = self.children.pop(name, None)
        if child is None:
            raise ModelError(f"{self.path}: there is no child {name} to remove; it has {', '.join(self.children)}")
        self._coupled = {c: None for c in self._coupled if child not in (c[0].owner, c[1].owner)}
        child.parent, child._path, child._present = None, "", IDLE

    def add_in(self, name: str, type: type[M]) -> InPort[M]:
        """Add an input port to the coupled model and return the port."""
        self._reachable("add_in")
        return super().add_in(name, type)

    def add_out(self, name: str, type: type[M], lookahead: int = 0) -> OutPort[M]:
        """Add an output port to the coupled model and return it; the atomic models that feed it determine its
        lookahead."""
        self._reachable("add_out")
        if lookahead:
            raise ModelError(f"{self.path}: port {name}: declare the lookahead on the atomic that sends")
        return super().add_out(name, type)

    def connect(self, source: Port[Message], target: Port[Message]) -> None:
        """Couple a port of a child or of this model to another such port."""
        self._change("connect", lambda: self._connect(source, target))

    def disconnect(self, source: Port[Message], target: Port[Message]) -> None:
        """Remove the coupling from `source` to `target`."""
        self._change("disconnect", lambda: self._disconnect(source, target))

    def _disconnect(self, source: Port[Message], target: Port[Message]) -> None:
        if (source, target) not in self._coupled:
            raise ModelError(f"{self.path}: there is no coupling {source!r} -> {target!r} to remove")
        del self._coupled[source, target]

    def _connect(self, source: Port[Message], target: Port[Message]) -> None:
        wrong = self._fault(source, target)
        if wrong:
            raise ModelError(f"{self.path}: coupling {source!r} -> {target!r}: {wrong}")
        self._coupled[source, target] = None

    def _fault(self, source: Port[Message], target: Port[Message]) -> str:
        """Return the reason why a coupling is invalid, or "" if it is valid."""
        for port in (source, target):
            if port.owner is not self and port.owner.parent is not self:
                return f"{port!r} is neither a port of {self.path} nor of its children"
            if port.owner.ports.get(port.name) is not port:
                return f"{port!r} is not a port of {port.owner.path}"
        if isinstance(source, InPort) != (source.owner is self):
            return f"{source!r} cannot be a source here; use an output port of a child"
        if isinstance(target, OutPort) != (target.owner is self):
            return f"{target!r} cannot be a target here; use an input port of a child"
        if source.owner is target.owner:
            through = (
                "it connects an input directly to an output"
                if source.owner is self
                else "it connects a model to itself"
            )
            return f"{through}, which the formalism excludes; put an atomic model in between"
        if source.type is not target.type and not issubclass(source.type, target.type):
            return f"{source.type.__name__} does not fit a port of {target.type.__name__}"
        if (source, target) in self._coupled:
            return "it exists already; a second one would duplicate every message"
        return ""
