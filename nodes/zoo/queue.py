"""Generator, processor and transducer: jobs arrive, are processed or lost, and are counted (Zeigler et al. 2000, 4.2).

frame(period, span) sends jobs and counts for `span`; couple its `job` to a processor and that back to `solved`
"""

from heavylift.nodes.devs import Atomic, Bag, Coupled, In, Message, Out, Tag, seconds, stream


class Job(Message):
    """A job with its number."""

    number: int


class ObservationEnd(Message):
    """Message to the generator that the observation has ended."""


class Counted(Message):
    """Numbers of jobs that arrived and that were solved during the observation."""

    arrivals: int
    solutions: int


class Generator(Atomic):
    """Sends job 0 at once and a further job every `period` [ns], until it is stopped."""

    stop, job = In(ObservationEnd), Out(Job)

    def __init__(self, name: str, period: int) -> None:
        super().__init__(name)
        self.period = period

    def start(self) -> None:
        """Schedule job 0 of the generator at time 0."""
        self.number = 0
        self.hold_in(0)

    def output(self) -> None:
        """Send the generator's next job."""
        self.job.send(Job(self.number))

    def internal(self) -> None:
        """Count the job that the generator has sent, and wait for one period."""
        self.number += 1
        self.hold_in(self.period)

    def external(self, e: int, x: Bag) -> None:
        """Stop the generator, because the observation has ended."""
        self.passivate()


class PoissonGenerator(Generator):
    """Sends jobs at random times with a mean `rate` [1/s], the first one after a random time."""

    def __init__(self, name: str, rate: float, seed: int) -> None:
        super().__init__(name, 0)
        self.rate, self.seed = rate, seed

    def start(self) -> None:
        """Create the generator's random stream anew from its seed, and draw the time of the first job."""
        self.number, self.random = -1, stream(self.seed, self.path)
        self.internal()

    def internal(self) -> None:
        """Count the job that the generator has sent, and wait for an exponentially distributed time."""
        self.number += 1
        self.hold_in(seconds(self.random.expovariate(self.rate)))


class Processor(Atomic):
    """Processes one job for `duration` [ns]; jobs that arrive meanwhile are lost."""

    into, done = In(Job), Out(Job)

    def __init__(self, name: str, duration: int) -> None:
        super().__init__(name)
        self.duration = duration

    def start(self) -> None:
        """Start the processor with no job."""
        self.job: Job | None = None

    def external(self, e: int, x: Bag) -> None:
        """Accept the first arriving job if the processor is idle."""
        if self.job is None:
            self.job = x[self.into][0]
            self.hold_in(self.duration)

    def output(self) -> None:
        """Send the job that the processor has finished."""
        if self.job is not None:
            self.done.send(self.job)

    def internal(self) -> None:
        """Make the processor idle after it has sent the finished job."""
        self.job = None
        self.passivate()


class Transducer(Atomic):
    """Counts jobs that arrive and jobs that are solved for `span` [ns], then sends a stop message."""

    arrived, solved, stop = In(Job), In(Job), Out(ObservationEnd)

    def __init__(self, name: str, span: int) -> None:
        super().__init__(name)
        self.span = span

    def start(self) -> None:
        """Start the transducer with both counts at zero."""
        self.arrivals, self.solutions, self.last = 0, 0, Tag(0)
        self.hold_in(self.span)

    def external(self, e: int, x: Bag) -> None:
        """Count jobs that have arrived and jobs that have been solved."""
        self.arrivals += len(x.get(self.arrived, []))
        self.solutions += len(x.get(self.solved, []))
        self.last = self.now

    def result(self) -> Counted:
        """Return the transducer's numbers of arrived and solved jobs."""
        return Counted(self.arrivals, self.solutions)

    def output(self) -> None:
        """Send the message that the observation has ended."""
        self.stop.send(ObservationEnd())

    def internal(self) -> None:
        """Make the transducer passive after the end of the observation."""
        self.passivate()


def frame(period: int, span: int) -> Coupled:
    """Return the experimental frame: a generator and a transducer, with the ports `job` and `solved`."""
    model = Coupled("frame")
    generator, transducer = model.add(Generator("generator", period)), model.add(Transducer("transducer", span))
    model.connect(generator.job, transducer.arrived)
    model.connect(transducer.stop, generator.stop)
    model.connect(generator.job, model.add_out("job", Job))
    model.connect(model.add_in("solved", Job), transducer.solved)
    return model


def workshop(period: int, duration: int, span: int) -> Coupled:
    """Return a processor in its experimental frame; `period`, `duration` and `span` are in ns."""
    model = Coupled("workshop")
    around, processor = model.add(frame(period, span)), model.add(Processor("processor", duration))
    model.connect(around.ports["job"], processor.into)
    model.connect(processor.done, around.ports["solved"])
    return model
