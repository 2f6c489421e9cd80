"""Orders and conditions of the commander, and the actions that combine them.

Part of the plan (see `plan`): resolved names, SI units, one actuator per order, frozen msgspec data.
"""

from typing import Any, Literal, TypeAlias

import msgspec
from heavylift.kernel.algebra.elementary import cos, sin
from heavylift.kernel.description.mechanics import Threshold, Vector

from .verbs import MOTIONS


class Item(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, omit_defaults=True):
    """An item written in a scene; `where` is file:line:column."""

    where: str = ""


# conditions; `text` = the words of the scene ("all slings taut"), quoted in sentences


class Term(Item, frozen=True, kw_only=True):
    """A condition, or a part of one."""

    text: str = ""


class SlingsCondition(Term, frozen=True, kw_only=True, tag="slings"):
    """All or any of the hooked slings (or a mechanism's ropes) are taut or slack."""

    names: tuple[str, ...]
    each: Literal["all", "any"] = "all"
    state: Literal["taut", "slack"]


class MovesDone(Term, frozen=True, kw_only=True, tag="moves-done"):
    """The orders of the previous action are done (those of `verbs`, if given); with `stopped`, orders stopped by a
    limit switch or interlock count as done."""

    verbs: tuple[str, ...] = ()
    stopped: bool = False


class LiftedCondition(Term, frozen=True, kw_only=True, tag="lifted"):
    """No support of this block or mechanism is closed."""

    model: str = "block"


class LandedCondition(Term, frozen=True, kw_only=True, tag="landed"):
    """All supports of one face of this block are closed."""

    model: str = "block"


class CrossingCondition(Term, frozen=True, kw_only=True, tag="crossing"):
    """A measured quantity is at or beyond `value` (rising: >=, else <=).

    `threshold` has a name of its own in the plan (two conditions never share one); `model` watches it. Once reached, it
    stays reached for the action or move that waits for it.
    """

    model: str
    threshold: Threshold
    value: float
    rising: bool


class AfterCondition(Term, frozen=True, kw_only=True, tag="after"):
    """This many seconds have passed since the previous action (in `until`: the order) began."""

    seconds: float


class BegunCondition(Term, frozen=True, kw_only=True, tag="begun"):
    """The action list of the whole scene has begun the list of this lift."""

    lift: str


class EndedCondition(Term, frozen=True, kw_only=True, tag="ended"):
    """The action list of this lift is done."""

    lift: str


class And(Term, frozen=True, kw_only=True, tag="and"):
    """All of these conditions hold at the same time."""

    all: "tuple[Condition, ...]"


Condition: TypeAlias = (
    SlingsCondition
    | MovesDone
    | LiftedCondition
    | LandedCondition
    | CrossingCondition
    | AfterCondition
    | BegunCondition
    | EndedCondition
    | And
)


# orders


class Follow(Item, frozen=True, kw_only=True, tag="follow"):
    """An actuator follows k1 s + kc cos s + ks sin s of a master (turn or measured angle) that starts at `s`; `law`:
    the three coefficients [m/rad, m, m]."""

    model: str
    actuator: str
    master: str
    law: tuple[float, float, float]
    s: float = 0.0

    def value(self, s: float) -> float:
        """Return the value of the law at s."""
        k1, kc, ks = self.law
        return k1 * s + float(kc * cos(s) + ks * sin(s))


class Motion(Item, frozen=True, kw_only=True, tag="motion"):
    """Move by a signed distance, to a coordinate, or (both None) without end.

    Coordinates are the actuator's own: joint coordinate of a drive, UNSTRETCHED LENGTH of a winch (hoisting is
    negative). `speed` is a magnitude if a distance or goal is given, signed for an endless move. An actuator stops by
    itself at its end positions and reports the limit. `pulses`: number of pulses of ramps that leave no swing (see
    `pulses`); `periods`: of the load's swing when the move begins and when it stops [s].
    """

    speed: float
    accel: float
    by: float | None = None
    to: float | None = None
    pulses: int = 0
    periods: tuple[float, float] = (0.0, 0.0)


class Move(Motion, frozen=True, kw_only=True, tag="move"):
    """Move one actuator; without `by` and `to` until a condition holds.

    `left`: swing that pulses leave because the period changes meanwhile [rad]. `together`: actuators that all stop when
    one of them is stopped. `above`: lugs above which it ends; `to` is computed from their position when the action list
    is followed. `trims`: it may have nothing to do. `keeps`: winches that keep the height of their hooks while it luffs
    a boom.
    """

    verb: str
    model: str
    actuator: str
    until: Condition | None = None
    left: float = 0.0
    together: tuple[str, ...] = ()
    above: tuple[str, ...] = ()
    trims: bool = False
    keeps: tuple[Follow, ...] = ()

    def __post_init__(self) -> None:
        if self.verb not in MOTIONS:
            raise ValueError(f"no drive or winch can {self.verb}")


class Turn(Item, frozen=True, kw_only=True, tag="turn"):
    """Turn the block to the angle `to` [rad] at `rate` [rad/s], with ramps `accel` [rad/s2]. The commander computes the
    references of every trolley and winch that carries slings."""

    block: str = "block"
    rate: float
    accel: float
    to: float
    until: Condition | None = None


class Hookup(Item, frozen=True, kw_only=True, tag="hook"):
    """Hook a sling to a `lug` at `p` [m] in its body's frame, or, without, a mechanism's rope to its end point."""

    sling: str
    lug: str = ""
    p: Vector | None = None


class UnhookSling(Item, frozen=True, kw_only=True, tag="unhook"):
    """Unhook a sling; `parted`: it breaks and cannot be hooked again."""

    sling: str
    parted: bool = False


class BrakeOrder(Item, frozen=True, kw_only=True, tag="brake"):
    """Engage or release a brake, a joint's lock or a beam's hinge lock, or activate or bypass an interlock."""

    model: str
    brake: str
    engaged: bool


class StopOrder(Item, frozen=True, kw_only=True, tag="stop"):
    """Stop an actuator with `accel` [m/s2 or rad/s2]; None: that of its move."""

    model: str
    actuator: str
    accel: float | None = None


class Wait(Item, frozen=True, kw_only=True, tag="wait"):
    """Wait for this many seconds."""

    seconds: float


class Begin(Item, frozen=True, kw_only=True, tag="begin"):
    """Begin the action list of a lift."""

    lift: str


Order: TypeAlias = Move | Turn | Hookup | UnhookSling | BrakeOrder | StopOrder | Wait | Begin


# what an actor is sent: an order without what the commander alone looks after, or one that it gives by itself


class WatchThreshold(Item, frozen=True, kw_only=True, tag="watch"):
    """Watch a threshold, and report once when it reaches `value`."""

    value: float
    rising: bool


class EndOrder(Item, frozen=True, kw_only=True, tag="end"):
    """End an order: a move ramps down, a follower holds (its master is at `s`), a threshold is disarmed."""

    s: float = 0.0


ActorCommand: TypeAlias = Motion | Follow | StopOrder | Hookup | UnhookSling | BrakeOrder | WatchThreshold | EndOrder


def for_actor(order: Move | Follow | StopOrder | Hookup | UnhookSling | BrakeOrder, **more: Any) -> ActorCommand:
    """Return the part of an order that its actor needs, with the fields `more`, and without the line of the scene, on
    which a run must not depend."""
    kind = Motion if isinstance(order, Move) else type(order)
    return kind(**{name: getattr(order, name) for name in kind.__struct_fields__ if name != "where"} | more)


class Touch(Item, frozen=True, kw_only=True):
    """Two things that may touch, by name ("world": the ground); `stays`: also after this stage."""

    names: tuple[str, str]
    stays: bool = False


class Action(Item, frozen=True, kw_only=True):
    """An action of the commander: orders given at the same time.

    It begins when `when` holds (None: the orders of the previous action are done). `timeout` [s] bounds the wait,
    counted from the beginning of the previous action; if it expires, the run ends with an error.
    """

    stage: str = ""
    when: Condition | None = None
    timeout: float | None = None
    orders: tuple[Order, ...]
    may_touch: tuple[Touch, ...] = ()


def parts(action: Action) -> bool:
    """Return whether a sling or rope breaks in this action."""
    return any(isinstance(order, UnhookSling) and order.parted for order in action.orders)
