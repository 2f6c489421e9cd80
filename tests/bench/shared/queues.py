"""M/M/c with feedback: served jobs return with a probability; one seed gives the same numbers in every engine."""

from random import Random

from heavylift.nodes.devs import Atomic, Bag, Coupled, In, Message, Out, seconds


class Job(Message):
    number: int
    born: int


class Source(Atomic):
    out = Out(Job)

    def __init__(self, name: str, rate: float, seed: int) -> None:
        super().__init__(name)
        self.rate, self.seed = rate, seed

    def start(self) -> None:
        self.random, self.n = Random(self.seed), 0
        self.hold_in(seconds(self.random.expovariate(self.rate)))

    def output(self) -> None:
        self.out.send(Job(self.n, self.now.t))

    def internal(self) -> None:
        self.n += 1
        self.hold_in(seconds(self.random.expovariate(self.rate)))


class Station(Atomic):
    """One queue, c servers."""

    into, out = In(Job), Out(Job)

    def __init__(self, name: str, c: int, rate: float, seed: int) -> None:
        super().__init__(name)
        self.c, self.rate, self.seed = c, rate, seed

    def start(self) -> None:
        self.random, self.queue, self.busy = Random(self.seed), list[Job](), list[tuple[int, int, Job]]()

    def external(self, e: int, x: Bag) -> None:
        self.queue += x[self.into]
        self.serve()

    def output(self) -> None:
        self.out.send(self.busy[0][2])

    def internal(self) -> None:
        del self.busy[0]
        self.serve()

    def serve(self) -> None:
        while self.queue and len(self.busy) < self.c:
            job = self.queue.pop(0)
            self.busy.append((self.now.t + seconds(self.random.expovariate(self.rate)), job.number, job))
        self.busy.sort(key=lambda entry: entry[:2])
        if self.busy:
            self.hold_in(self.busy[0][0] - self.now.t)
        else:
            self.passivate()


class Router(Atomic):
    into, again, leave = In(Job), Out(Job), Out(Job)

    def __init__(self, name: str, p: float, seed: int) -> None:
        super().__init__(name)
        self.p, self.seed = p, seed

    def start(self) -> None:
        self.random, self.jobs = Random(self.seed), list[tuple[bool, Job]]()

    def external(self, e: int, x: Bag) -> None:
        self.jobs += [(self.random.random() < self.p, job) for job in x[self.into]]
        self.hold_in(0)

    def output(self) -> None:
        for back, job in self.jobs:
            (self.again if back else self.leave).send(job)

    def internal(self) -> None:
        self.jobs = []
        self.passivate()


class Sink(Atomic):
    into = In(Job)

    def start(self) -> None:
        self.n, self.sojourn = 0, 0

    def external(self, e: int, x: Bag) -> None:
        for job in x[self.into]:
            self.n, self.sojourn = self.n + 1, self.sojourn + self.now.t - job.born


def build(c: int = 3, arrivals: float = 2.0, service: float = 1.2, p: float = 0.25, seed: int = 1) -> Coupled:
    net = Coupled("net")
    source, station = net.add(Source("source", arrivals, seed)), net.add(Station("station", c, service, seed + 1))
    router, sink = net.add(Router("router", p, seed + 2)), net.add(Sink("sink"))
    net.connect(source.out, station.into)
    net.connect(station.out, router.into)
    net.connect(router.again, station.into)
    net.connect(router.leave, sink.into)
    return net
