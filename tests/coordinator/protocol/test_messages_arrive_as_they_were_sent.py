"""A field that is not of its type is refused when it is sent, in one sentence wherever sender and receiver run.

What is sent arrives equal, in a flat run as between nodes: the same types, to the last bit.
"""

import math
from enum import Enum
from random import Random
from typing import Annotated, Any, Literal

import msgspec
import numpy as np
import pytest
from heavylift.coordinator.protocol import Coordinator, Node
from heavylift.kernel import ModelError
from heavylift.nodes.devs import Atomic, Bag, Coupled, In, Message, Out, Simulator, ports
from in_memory import run_in_memory


class Side(Enum):
    WEST = "west"
    EAST = "east"


class Base(Message):
    n: int = 0


class Derived(Base):
    more: int = 1


class Point(msgspec.Struct, frozen=True):
    x: float = 0.0


class Everything(Message):
    whole: int = 0
    real: float = 0.0
    text: str = ""
    raw: bytes = b""
    flag: bool = False
    side: Side = Side.WEST
    way: Literal["up", "down"] = "up"
    positive: Annotated[int, msgspec.Meta(ge=0)] = 0
    maybe: float | None = None
    many: tuple[int, ...] = ()
    base: Base = Base()
    point: Point = Point()


class Speaker(Atomic):
    out = Out(Everything)

    def __init__(self, name: str, **fields: Any) -> None:
        super().__init__(name)
        self.said = Everything(**fields)

    def start(self) -> None:
        self.hold_in(1)

    def output(self) -> None:
        self.out.send(self.said)

    def internal(self) -> None:
        self.passivate()


class Ear(Atomic):
    into = In(Everything)

    def external(self, e: int, x: Bag) -> None:
        heard.extend(x[self.into])


heard: list[Message] = []


def pair(fields: dict[str, Any]) -> Coupled:
    root = Coupled("r")
    a, b = root.add(Speaker("a", **fields)), root.add(Ear("b"))
    root.connect(a.out, b.into)
    return root


def flat(fields: dict[str, Any]) -> str:
    """What is heard in one simulator, or the sentence that it ends with."""
    heard.clear()
    simulator = Simulator(pair(fields))
    simulator.start()
    try:
        simulator.run()
    except ModelError as error:
        return str(error)
    return repr(heard)


def apart(fields: dict[str, Any]) -> str:
    """The same of two nodes."""
    heard.clear()
    root = pair(fields)
    wires = [("a", "out", "b", "into")]
    nodes = [Node(child.name, Simulator(child, wires=wires)) for child in root.children.values()]
    try:
        run_in_memory(Coordinator(["a", "b"], wires), nodes)
    except ModelError as error:
        return str(error)
    return repr(heard)


REFUSED = [
    ("whole", "text", "the str 'text' does not arrive unchanged as int; convert it to int first"),
    ("whole", 1.0, "the float 1.0 does not arrive unchanged as int; convert it to int first"),
    ("whole", True, "the bool True does not arrive unchanged as int; convert it to int first"),
    ("whole", math.nan, "the float nan does not arrive unchanged as int; convert it to int first"),
    ("whole", 2**64, "the int of 65 bits does not arrive unchanged as int; an int has at most 64"),
    ("whole", -(10**1000), "the int of 3322 bits does not arrive unchanged as int; an int has at most 64"),
    ("whole", np.int64(3), "the int64 np.int64(3) does not arrive unchanged as int; convert it to int first"),
    ("real", 2**53 + 1, "the int 9007199254740993 does not arrive unchanged as float; convert it to float first"),
    (
        "real",
        np.float64(1.5),
        "the float64 np.float64(1.5) does not arrive unchanged as float; convert it to float first",
    ),
    ("real", "1.5", "the str '1.5' does not arrive unchanged as float; convert it to float first"),
    ("text", Side.WEST, "the Side <Side.WEST: 'west'> does not arrive unchanged as str; convert it to str first"),
    ("text", "\ud800", r"the str '\ud800' does not arrive unchanged as str; convert it to str first"),
    ("flag", 1, "the int 1 does not arrive unchanged as bool; convert it to bool first"),
    ("flag", np.True_, "the bool np.True_ does not arrive unchanged as bool; convert it to bool first"),
    ("side", "west", "the str 'west' does not arrive unchanged as Side; convert it to Side first"),
    ("way", "left", "the str 'left' does not arrive unchanged as typing.Literal['up', 'down']; convert it to "),
    (
        "positive",
        -1,
        "the int -1 does not arrive unchanged as typing.Annotated[int, msgspec.Meta(ge=0)]; convert it to ",
    ),
    ("maybe", "none", "the str 'none' does not arrive unchanged as float | None; convert it to float | None first"),
    (
        "many",
        (1, "2"),
        "the tuple (1, '2') does not arrive unchanged as tuple[int, ...]; convert it to tuple[int, ...] first",
    ),
    (
        "base",
        Derived(1),
        "the Derived Derived(n=1, more=1) does not arrive unchanged as Base; convert it to Base first",
    ),
    ("base", Base("x"), "the str 'x' does not arrive unchanged as int; convert it to int first"),  # type: ignore[arg-type]
]


@pytest.mark.parametrize(("field", "value", "why"), REFUSED, ids=[f"{row[0]}-{i}" for i, row in enumerate(REFUSED)])
def test_a_value_of_a_wrong_type_gives_the_same_error_in_the_flat_simulator_and_between_nodes(
    field: str, value: Any, why: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    place = "base.n" if value == Base("x") else field  # type: ignore[arg-type]
    message = flat({field: value})
    assert message.startswith(f"r.a at (0.000000001 s, 0): port out: message Everything, field {place}: {why}")
    assert apart({field: value}) == message
    monkeypatch.setattr(ports, "travelling", lambda value, port: value)
    assert flat({field: value}) == repr([Everything(**{field: value})]), "without the rule it arrives in one simulator"
    assert apart({field: value}) != flat({field: value}), "and not so between nodes"


def anything(r: Random) -> dict[str, Any]:
    """A field or two, mostly with values of some other field's type."""
    values: list[Any] = [
        *(r.randrange(-3, 4), 2 ** r.randrange(50, 70), r.choice([0.0, -0.0, 1.5, math.nan, math.inf]), r.random()),
        *("west", "up", "é", b"a", True, False, None, Side.EAST, (1, 2), (), (1, 2.0), Base(3), Derived(4)),
        *(Point(1.0), Point(2), np.float64(2.0), np.int32(2), np.str_("up")),  # type: ignore[arg-type]
    ]
    fields = r.sample(Everything.__struct_fields__, r.choice([1, 1, 1, 2]))
    return {field: r.choice(values) for field in fields}


def test_any_value_in_a_message_field_arrives_unchanged_or_is_refused_with_the_same_error() -> None:
    r, arrived, refused = Random(1), 0, 0
    for _ in range(500):
        fields = anything(r)
        message = flat(fields)
        assert message == apart(fields), fields
        arrived, refused = arrived + message.startswith("["), refused + message.startswith("r.a at ")
    assert min(arrived, refused) > 30
    assert arrived + refused == 500


def test_an_integer_in_a_message_field_of_type_float_arrives_as_a_float() -> None:
    assert flat({"real": 3, "point": Point(2)}) == apart({"real": 3, "point": Point(2)})
    assert [(type(x.real), type(x.point.x)) for x in heard if isinstance(x, Everything)] == [(float, float)]


def test_a_message_type_that_cannot_be_decoded_is_refused_with_the_port_that_uses_it() -> None:
    class Level(Enum):
        LOW = 0.5

    class Vague(Message):
        level: Level

    with pytest.raises(ModelError, match=r"^message Vague cannot be read from its bytes: Enums must contain either"):
        Out(Vague)
