"""A spring as a co-simulation unit in a network with a source of pushes."""

from heavylift.nodes import Fmu, Signals
from heavylift.nodes.devs import Atomic, Coupled, In, Out, ms


class Pusher(Atomic):
    """Pushes against the velocity, which it takes from two places of the spring, at once or `late` [ns] later."""

    y, u = In(Signals), Out(Signals)

    def __init__(self, name: str, late: int) -> None:
        super().__init__(name)
        self.late = late

    def start(self) -> None:
        self.last, self.push = 1.0, 0.0

    def external(self, e, x) -> None:
        at = dict(x[self.y][-1].values)["x"]
        self.push, self.last = 20.0 * (self.last - at), at
        self.hold_in(self.late)

    def output(self) -> None:
        self.u.send(Signals((("f", self.push),)))

    def internal(self) -> None:
        self.passivate()


def network(file: str, late: int = ms(3)) -> Coupled:
    model = Coupled("network")
    spring = model.add(Fmu("spring", file, ms(10), ["x", "steps"], {"m": 0.5}))
    pusher = model.add(Pusher("pusher", late))
    model.connect(spring.y, pusher.y)
    model.connect(pusher.u, spring.u)
    return model
