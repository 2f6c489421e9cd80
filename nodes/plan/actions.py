"""Orders and conditions of the commander, and the actions that combine them.

They are part of the plan (see `plan`): frozen msgspec data with resolved names, SI units and one actuator for each
order.
"""

from typing import Any, ClassVar, Literal, TypeAlias

import msgspec
from heavylift.kernel.algebra.elementary import cos, sin
from heavylift.kernel.description.mechanics import Threshold, Vector

from .verbs import MOTIONS


class Item(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, omit_defaults=True):
    """Base class of everything that is written in a scene; `where` is the place in the scene, as file:line:column."""

    where: str = ""
    __fixed__: ClassVar[bool] = True  # models never change it: states with a plan are compared without its content


LANDS = 1e-3  # [m] between a block and what it has landed on

# conditions; `text` = the words of the scene ("all slings taut"), quoted in sentences


class Term(Item, frozen=True, kw_only=True):
    """Base class of conditions and their parts; `text` is the condition as written."""

    text: str = ""


class SlingsCondition(Term, frozen=True, kw_only=True, tag="slings"):
    """Condition: all or any of the hooked slings (or of a mechanism's ropes) are taut or slack."""

    names: tuple[str, ...]
    each: Literal["all", "any"] = "all"
    state: Literal["taut", "slack"]


class MovesDone(Term, frozen=True, kw_only=True, tag="moves-done"):
    """Condition: the orders of the previous action are done, or only those with the given verbs.

    If `stopped` is true, orders that a limit switch or interlock stopped count as done."""

    verbs: tuple[str, ...] = ()
    stopped: bool = False


class LiftedCondition(Term, frozen=True, kw_only=True, tag="lifted"):
    """Condition: this block or mechanism touches none of its supports."""

    model: str = "block"


class LandedCondition(Term, frozen=True, kw_only=True, tag="landed"):
    """Condition: all supports of one face of this block are in contact."""

    model: str = "block"


class CrossingCondition(Term, frozen=True, kw_only=True, tag="crossing"):
    """Condition: a measured quantity has reached `value`, from below if `rising`, else from above.

    Each condition has a threshold with a name of its own in the plan; `model` watches it. Once the value is reached,
    the condition stays true for the action or move that waits for it.
    """

    model: str
    threshold: Threshold
    value: float
    rising: bool


class AfterCondition(Term, frozen=True, kw_only=True, tag="after"):
    """Condition: `seconds` have passed since the beginning of the previous action or, in `until`, of the order."""

    seconds: float


class BegunCondition(Term, frozen=True, kw_only=True, tag="begun"):
    """Condition: an action of the whole scene has begun the action list of this lift."""

    lift: str


class EndedCondition(Term, frozen=True, kw_only=True, tag="ended"):
    """Condition: the action list of this lift is done."""

    lift: str


class And(Term, frozen=True, kw_only=True, tag="and"):
    """Condition: all of these conditions hold at the same time."""

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
    """Order to an actuator to follow the coordinate s of a master, with the reference k1 s + kc cos s + ks sin s.

    The master is a turn or a measured angle, which starts at `s`; `law`: the coefficients (k1 [m/rad], kc [m], ks
    [m])."""

    model: str
    actuator: str
    master: str
    law: tuple[float, float, float]
    s: float = 0.0

    def value(self, s: float) -> float:
        """Return the reference k1 s + kc cos s + ks sin s of the follower for the value s of the master."""
        k1, kc, ks = self.law
        return k1 * s + float(kc * cos(s) + ks * sin(s))


class Motion(Item, frozen=True, kw_only=True, tag="motion"):
    """A motion of an actuator: by a signed distance, to a coordinate or, if both are None, without end.

    Coordinates are those of the actuator: joint coordinate of a drive, UNSTRETCHED LENGTH of a winch's rope (hoisting
    is negative). `speed` is a magnitude if `by` or `to` is given, and signed otherwise. At its end positions an
    actuator stops by itself and reports the limit. `pulses`: number of acceleration pulses in ramps that leave no swing
    (see `pulses`); `periods` [s]: swing periods of the load at the start and at the end of the move.
    """

    speed: float
    accel: float
    by: float | None = None
    to: float | None = None
    pulses: int = 0
    periods: tuple[float, float] = (0.0, 0.0)


class Move(Motion, frozen=True, kw_only=True, tag="move"):
    """Order to move one actuator; without `by` and `to`, until a condition holds.

    `left` [rad]: swing that the pulses leave because the period changes during the ramp. `together`: actuators that all
    stop when one of them is stopped. `above`: lugs above which the move ends; then `to` is computed from the position
    of the lugs when the order is given. `trims`: the move may have nothing to do. `keeps`: winches that keep their
    hooks at the same height while a boom luffs.
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
            raise ValueError(f"'{self.verb}' is not a motion of a drive or winch; use {', '.join(MOTIONS)}")


class Turn(Item, frozen=True, kw_only=True, tag="turn"):
    """Order to turn the block to the angle `to` [rad] at `rate` [rad/s], with ramps `accel` [rad/s2].

    The commander computes the references of all trolleys and winches that carry slings."""

    block: str = "block"
    rate: float
    accel: float
    to: float
    until: Condition | None = None


class Hookup(Item, frozen=True, kw_only=True, tag="hook"):
    """Order to hook a sling to the lug `lug` at the point `p` [m] in the frame of the lug's body.

    If both are omitted, a mechanism's rope is hooked to its declared end point."""

    sling: str
    lug: str = ""
    p: Vector | None = None


class UnhookSling(Item, frozen=True, kw_only=True, tag="unhook"):
    """Order to unhook a sling; if `parted`, the sling breaks and cannot be hooked again."""

    sling: str
    parted: bool = False


class BrakeOrder(Item, frozen=True, kw_only=True, tag="brake"):
    """Order to engage or release a brake or lock, or to activate or bypass an interlock."""

    model: str
    brake: str
    engaged: bool


class StopOrder(Item, frozen=True, kw_only=True, tag="stop"):
    """Order to stop an actuator with the deceleration `accel` [m/s2 or rad/s2]; None: the deceleration of its move."""

    model: str
    actuator: str
    accel: float | None = None


class Wait(Item, frozen=True, kw_only=True, tag="wait"):
    """Order to wait for this many seconds."""

    seconds: float


class Begin(Item, frozen=True, kw_only=True, tag="begin"):
    """Order to begin the action list of a lift."""

    lift: str


Order: TypeAlias = Move | Turn | Hookup | UnhookSling | BrakeOrder | StopOrder | Wait | Begin


# what an actor is sent: an order without what the commander alone looks after, or one that it gives by itself


class WatchThreshold(Item, frozen=True, kw_only=True, tag="watch"):
    """Order to watch a threshold and to report once when it reaches `value`."""

    value: float
    rising: bool


class EndOrder(Item, frozen=True, kw_only=True, tag="end"):
    """Order to end another order: a move ramps down, a follower holds its position, a threshold is no longer watched.

    `s`: present value of the master, for a follower."""

    s: float = 0.0


ActorCommand: TypeAlias = Motion | Follow | StopOrder | Hookup | UnhookSling | BrakeOrder | WatchThreshold | EndOrder


def for_actor(order: Move | Follow | StopOrder | Hookup | UnhookSling | BrakeOrder, **more: Any) -> ActorCommand:
    """Return a copy of an order for its actor, without its place in the scene; `more`: values of further fields."""
    kind = Motion if isinstance(order, Move) else type(order)
    return kind(**{name: getattr(order, name) for name in kind.__struct_fields__ if name != "where"} | more)


class Touch(Item, frozen=True, kw_only=True):
    """Two objects that are allowed to touch, by name ("world" is the ground).

    `stays`: the permission also holds after this stage."""

    names: tuple[str, str]
    stays: bool = False


class Action(Item, frozen=True, kw_only=True):
    """An action of the commander: orders that are given at the same time.

    It begins when the condition `when` holds (None: when the orders of the previous action are done). `timeout` [s]
    limits the wait for this, counted from the beginning of the previous action; if it expires, the run ends with an
    error.
    """

    stage: str = ""
    when: Condition | None = None
    timeout: float | None = None
    orders: tuple[Order, ...]
    may_touch: tuple[Touch, ...] = ()


def parts(action: Action) -> bool:
    """Return whether this action orders a sling or rope to part (to break)."""
    return any(isinstance(order, UnhookSling) and order.parted for order in action.orders)
