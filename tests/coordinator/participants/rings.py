"""Models that tests distribute: each function builds the same one at each call."""

from heavylift.nodes.devs import Atomic, Coupled, In, Out, ms, seconds
from heavylift.nodes.zoo import Job, ring, workshop


def tokens() -> Coupled:
    return ring(stations=4, tokens=2, hold=ms(5))


def work() -> Coupled:
    return workshop(period=ms(10), duration=ms(25), span=ms(200))


class Divider(Atomic):
    """Fails at its third job."""

    into, done = In(Job), Out(Job)

    def external(self, e, x):
        self.shares = 1 / (2 - x[self.into][0].number)


def failing() -> Coupled:
    model = workshop(period=seconds(1), duration=seconds(2.5), span=seconds(20))
    divider = model.add(Divider("divider"))
    model.connect(model.children["frame"].ports["job"], divider.into)
    return model
