"""M/M/c queue with feedback: one queue for c servers, to which a served job returns with a given probability.

This is the simplest Jackson network (Jackson 1957): its effective arrival rate is arrivals / (1 - again), and its mean
length is that of an M/M/c queue with this rate.
"""

from bisect import insort

from heavylift.nodes.devs import Atomic, Bag, Coupled, In, Message, Out, Tally, TimeWeighted, seconds, stream
from heavylift.nodes.zoo.queue import Job, PoissonGenerator


class QueueStatistics(Message):
    """Number of jobs that left, their mean time in the station [s], and the mean number of jobs in it."""

    units = {"stay": "s", "length": "1"}  # noqa: RUF012 (never changed)
    left: int
    stay: float
    length: float


class Station(Atomic):
    """One queue with c servers, each of which serves jobs at a `rate` [1/s].

    A served job returns to the queue with the probability `again` [1]."""

    into, left = In(Job), Out(Job)

    def __init__(self, name: str, c: int, rate: float, again: float, seed: int) -> None:
        super().__init__(name)
        self.c, self.rate, self.again, self.seed = c, rate, again, seed

    def start(self) -> None:
        """Start with no job in the station."""
        self.random, self.stays, self.length = stream(self.seed, self.path), Tally(), TimeWeighted()
        self.queue, self.busy = list[tuple[int, Job]](), list[tuple[int, bool, tuple[int, Job]]]()

    def external(self, e: int, x: Bag) -> None:
        """Queue the jobs that arrive at the station, with their arrival time [ns]."""
        self.serve([(self.now.t, job) for job in x[self.into]])

    def output(self) -> None:
        """Send the job that is finished first, if it leaves the station."""
        if self.busy[0][1]:
            self.left.send(self.busy[0][2][1])

    def internal(self) -> None:
        """Free the server whose job is finished, and serve the next job in the queue."""
        _, leaves, job = self.busy.pop(0)
        if leaves:
            self.stays.add((self.now.t - job[0]) / 1e9)
        self.serve([] if leaves else [job])

    def serve(self, more: list[tuple[int, Job]]) -> None:
        """Assign waiting jobs to free servers; draw at random when each job is finished and whether it leaves."""
        self.queue += more
        while self.queue and len(self.busy) < self.c:
            ready = self.now.t + seconds(self.random.expovariate(self.rate))
            insort(self.busy, (ready, self.random.random() >= self.again, self.queue.pop(0)), key=lambda job: job[0])
        self.length.set(len(self.queue) + len(self.busy), self.now)
        self.hold_in(self.busy[0][0] - self.now.t) if self.busy else self.passivate()

    def result(self) -> QueueStatistics:
        """Return the measured statistics of the station."""
        return QueueStatistics(self.stays.count, self.stays.mean, self.length.mean(self.now))


def mmc(c: int = 3, arrivals: float = 2.0, service: float = 1.2, again: float = 0.25, seed: int = 1) -> Coupled:
    """Return a network in which jobs arrive at random (Poisson, [1/s]) at a station with c servers."""
    net = Coupled("net")
    source, station = PoissonGenerator("source", arrivals, seed), Station("station", c, service, again, seed)
    net.connect(net.add(source).job, net.add(station).into)
    return net
