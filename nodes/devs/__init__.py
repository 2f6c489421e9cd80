"""Parallel DEVS with superdense integer time.

message:   class HoistDone(Message): id: int                      frozen, typed, immutable all the way down
atomic:    class Hoist(Atomic): done = Out(HoistDone)             start, external, output, internal,
confluent coupled:   yard = Coupled("yard"); yard.add(Hoist("hoist")); yard.connect(source_port,
target_port) run:       Simulator(yard, log=lines.append): start(), then run(until) or the two-phase face
of `Steppable`
"""

from .events import Delivery, Event, Order, Steppable
from .messages import Message, decode, encode, message_type
from .models import Atomic, Coupled, Model
from .ports import Bag, In, InPort, Out, OutPort, Port
from .simulator import Simulator, Transition
from .tags import FOREVER, NEVER, Tag, after, ms, ns, succ, us

__all__ = [
    "FOREVER",
    "NEVER",
    "Atomic",
    "Bag",
    "Coupled",
    "Delivery",
    "Event",
    "In",
    "InPort",
    "Message",
    "Model",
    "Order",
    "Out",
    "OutPort",
    "Port",
    "Simulator",
    "Steppable",
    "Tag",
    "Transition",
    "after",
    "decode",
    "encode",
    "message_type",
    "ms",
    "ns",
    "succ",
    "us",
]
