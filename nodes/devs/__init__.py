"""Parallel DEVS with superdense integer time: atomic and coupled models, and the simulator that runs them.

Message              class Done(Message): id: int      frozen and typed; decode finds its subclasses by name
Atomic, In, Out      class Hoist(Atomic): done = Out(Done)      override start, external, internal, output
Coupled              yard = Coupled("yard"); hoist = yard.add(Hoist("hoist")); yard.connect(out_port, in_port)
Simulator            Simulator(yard, log=lines.append): start(), then run(until), or step by step as below
Trace                Simulator(yard, trace=Trace()): the same transitions, cheap to store and built when read
Steppable            interface of a node: next_time, outputs(), advance(tag, bag); exchanges Events
Tag                  logical time: whole nanoseconds and a microstep; succ and after return later ones; FOREVER: never
seconds, ms, us      nanoseconds of a time in these units, for waits and lookaheads: hold_in(seconds(1.5))

events                          logical times, and the events that pass between nodes
ports, messages, models         the parts of models
hybrid                          atomic models that follow a differential equation between their transitions
statistics                      tallies, means over time, streams of random numbers
references                      references to Python code in a scene or on a command line
execution                       the abstract simulator
"""

from heavylift.kernel.description import user_code as user_code  # from now on it sees what is imported
from heavylift.kernel.on_demand import face
from heavylift.nodes.devs.execution.simulator import Simulator
from heavylift.nodes.devs.execution.transitions import Trace, Transition

from .events import (
    FOREVER,
    NEVER,
    AtomicResult,
    Event,
    Keepable,
    Order,
    Slack,
    Steppable,
    Tag,
    after,
    ms,
    ns,
    seconds,
    succ,
    us,
)
from .messages import Message, decode, encode, message_type
from .models import Atomic, Coupled, Model
from .ports import Bag, In, InPort, Out, OutPort, Port
from .statistics import Tally, TimeWeighted, stream

__all__ = [
    "FOREVER", "NEVER", "Atomic", "AtomicResult", "Bag", "Coupled", "Event", "In", "InPort", "Keepable", "Message",
    "Model", "Order", "Out", "OutPort", "Port", "Simulator", "Slack", "Steppable", "Tag", "Tally", "TimeWeighted",
    "Trace", "Transition", "after", "decode", "encode", "message_type", "ms", "ns", "seconds", "stream", "succ", "us",
]  # fmt: skip

face(__name__)
