"""Models written by users, as nodes of a scene beside the kernel: any atomic or coupled model, or an FMU.

    class Damper(Atomic):                               models:
        swing, speed = In(Sample), Out(SetPoint)          damper:
                                                            model: anti_sway.py:Damper
        def __init__(self, name, gain): ...                 period: 100 ms
                                                            signals: {swing: swing along of fall}
                                                            orders: {speed: trolley}
                                                            parameters: {gain: 10 m/s}

The constructor of the model gets the name "model" and the parameters. Set-points take effect after the delay given in
the scene, which is the lookahead of the port; for an FMU the step is added to the lookahead.
"""

from heavylift.kernel.description.mechanics import System
from heavylift.kernel.description.user_code import raised
from heavylift.kernel.errors import HeavyliftError, ModelError
from heavylift.kernel.trust import foreign, refusal
from heavylift.nodes.devs import Atomic, Bag, Coupled, In, InPort, Model, Out, OutPort
from heavylift.nodes.devs.references import imported, read
from heavylift.nodes.fmi import Stepped
from heavylift.nodes.models.parts.messages import Sample, SetPoint
from heavylift.nodes.plan.user_models import UserModel

OUTSIDE = f"{__name__}:Outside"
MOST = 100  # periods of a delay: so many set-points can be on their way


def sample_port(model: str, port: str) -> str:
    """Return the name of the kernel's output port that sends the signal to a port of a user model."""
    return f"sample_{model}_{port}"


def aim_port(model: str, port: str) -> str:
    """Return the name of the commander's input port for the set-points from a user model's port."""
    return f"aim_{model}_{port}"


class UserModelNode(Coupled):
    """The node that runs one user model of the plan; raises ModelError if the model is invalid or not trusted."""

    def __init__(self, own: UserModel) -> None:
        super().__init__(own.name)
        if not 0 <= own.delay <= MOST * own.period or not own.period:
            raise ModelError(f"{own.name}: the delay exceeds {MOST} periods; lengthen the period")
        inner = self.add(_made(own))
        for port in own.signals:
            self.connect(self.add_in(port, Sample), _port(own, inner, port, InPort, Sample))
        for led in own.leads:
            source = _port(own, inner, led.port, OutPort, SetPoint)
            out, n = self.add_out(led.port, SetPoint), own.delay // own.period + 1
            for i in range(n if own.delay else 0):
                late = self.add(SetPointDelay(f"{led.port}-delay-{i + 1}", own.delay, i, n))
                self.connect(source, late.into)
                self.connect(late.out, out)
            if not own.delay:
                self.connect(source, out)

    def declare(self) -> System:
        """Return an empty mechanical system, because a user model declares no mechanics."""
        return System()


class Outside(Atomic):
    """Placeholder for a user model in a scene exported as FMU or environment; the host program gives the set-points."""

    def __init__(self, name: str, ports: str) -> None:
        super().__init__(name)
        for port in ports.split():
            self.add_out(port, SetPoint)


class SetPointDelay(Atomic):
    """Atomic model that passes on every nth set-point after a fixed delay [ns], which is its lookahead.

    It holds a single set-point, because an output with a lookahead must be scheduled when its input arrives."""

    into, out = In(SetPoint), Out(SetPoint)

    def __init__(self, name: str, wait: int, number: int, of: int) -> None:
        super().__init__(name)
        self.wait = self.out.lookahead = wait
        self.number, self.of = number, of

    def start(self) -> None:
        """Start the set-point delay without a stored set-point."""
        self.heard = 0
        self.point: SetPoint | None = None

    def external(self, e: int, x: Bag) -> None:
        """Store every nth set-point, to be sent after the delay; skip the others."""
        for point in x[self.into]:
            if self.heard % self.of == self.number:
                if self.point is not None:
                    raise ModelError(
                        "set-points come more often than once in a period; send fewer, or shorten the period"
                    )
                self.point = point
                self.hold_in(self.wait)
            self.heard += 1

    def output(self) -> None:
        """Send the delayed set-point."""
        if self.point is not None:
            self.out.send(self.point)

    def internal(self) -> None:
        """Forget the set-point that was sent, and wait for the next one."""
        self.point = None
        self.passivate()


class _Unit(Stepped):
    """An FMU as an atomic model: its inputs are signals, its outputs are set-points, and its step is the period."""

    def __init__(self, own: UserModel) -> None:
        given = {key: x for key, x in own.parameters.items() if not isinstance(x, str)}
        if text := sorted(own.parameters.keys() - given.keys()):
            raise ModelError(f"{own.name}: the parameter '{text[0]}' of an FMU must be a number, true or false")
        super().__init__("model", own.model, own.period, [led.port for led in own.leads], given, own.name)
        self.heard = {port: self.add_in(port, Sample) for port in own.signals}
        self.says = {led.port: self.add_out(led.port, SetPoint, own.period) for led in own.leads}
        self.unit.check(own.signals)

    def external(self, e: int, x: Bag) -> None:
        """Store the signals that arrive, as inputs of the FMU's next step."""
        self.unit.hold((name, value.value) for name, port in self.heard.items() for value in x.get(port, ()))

    def output(self) -> None:
        """Send each output of the FMU on its port."""
        for name, value in self.said.values:
            self.says[name].send(SetPoint(value))


def _made(own: UserModel) -> Model:
    if own.unit:
        return _Unit(own)
    if own.model == OUTSIDE:
        return Outside("model", *(str(x) for x in own.parameters.values()))
    where, name, arguments, _ = read(own.model)
    if why := refusal(where, own.model):
        raise ModelError(f"{own.name}: {why}")
    make, file = getattr(imported(where), name, None), where.rpartition("/")[2]
    if not callable(make):
        raise ModelError(f"{own.name}: {file} has no model {name}; define a class or a function with that name")
    if why := foreign(make, own.model):
        raise ModelError(f"{own.name}: {name} of '{file}' must not be called: {why}")
    try:
        model = make("model", *arguments, **own.parameters)
    except HeavyliftError:
        raise
    except Exception as error:
        raise ModelError(f"{own.name}: {name}() of {file} raised {raised(error)}") from error
    if not isinstance(model, Model) or model.name != "model":
        raise ModelError(f"{own.name}: {name}() of {file} must return a DEVS model with the name that it gets")
    return model


def _port(own: UserModel, model: Model, name: str, kind: type, carries: type) -> InPort[Sample] | OutPort[SetPoint]:
    """Return the port of the model that the scene refers to; raises ModelError if it is missing or has another
    direction or type."""
    port = model.ports.get(name)
    if port is None or not isinstance(port, kind) or port.type is not carries:
        direction, file = "input" if kind is InPort else "output", own.model.rpartition("/")[2]
        known = ", ".join(p.name for p in model.ports.values() if isinstance(p, kind) and p.type is carries) or "none"
        raise ModelError(
            f"{own.name}: {file} has no {direction} port '{name}' for a {carries.__name__}; it has {known}"
        )
    return port  # type: ignore[return-value]
