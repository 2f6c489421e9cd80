"""Limits in the plan: one row for each subject and quantity, with the source of the number.

`check` evaluates the rows on the equilibrium path, `run` in the simulation; the report shows them with their highest
utilisation. A row without a value is an unknown limit: it is reported but not checked.
"""

from dataclasses import dataclass, replace
from itertools import pairwise
from math import inf
from typing import Literal, TypeAlias

import msgspec
from heavylift.kernel.description.signals import ScalarSignal
from heavylift.recordings.format.spellings import BeamLoad

from .factors import Factor

ROUNDING = 1e-9  # a use so little above 1 is 1
CLOSE = 1e-4  # by so much beyond a radius or an angle of a chart its value holds

Quantity: TypeAlias = Literal[
    "hook load",
    "trolley load",
    "crane load",
    "tandem load",
    BeamLoad,
    "frame load",
    "shackle load",
    "assembly load",
    "lug load",
    "support load",
    "impact",
    "sling tension",
    "sling peak",
    "rope tension",
    "rope factor",
    "rope peak",
    "drum pull",
    "off-lead",
    "off-lead along",
    "off-lead across",
    "off-lead in wind",
    "bridle angle",
    "side force",
    "drive moment",
    "brake moment",
    "hook height",
    "rope length",
    "rails",
    "girder",
    "clearance",
    "wind",
    "sharing",
    "heavy sling",
    "inputs",
    "factor",
    "hook design load",
    "sling design load",
    "shackle design load",
    "lug design load",
    "signal",
    "interlock",
    "lift-off speed",
    "landing speed",
    "ground pressure",
    "wheel load",
    "uplift",
    "relative heave",
    "slack sling",
    "splash load",
]
STANDING: tuple[Quantity, ...] = ("ground pressure", "wheel load", "uplift")  # of the footing of a machine
IN_WIND: Quantity = "off-lead in wind"  # at rest, of the wind of the factor sheet
TOUCHING: tuple[Quantity, ...] = ("lift-off speed", "landing speed")
SIMULATED, ORDERED = "as simulated", "as ordered"  # where the value of a use comes from


class RestLoad(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """The static load on a part when its utilisation is highest, or a clearance at rest.

    `bound`: the limit; `alone`: the limit already includes dynamics, so that it applies to the static load alone."""

    value: float
    bound: float
    stage: str = ""
    alone: bool = False


class RatedLimit(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, omit_defaults=True):
    """A limit: the value that a quantity of a subject may reach, and the source of this number.

    `value` [unit] is a single limit, `between` a lower and an upper one; `chart` holds points (x, value), where `over`
    names x, and the limit is interpolated between them unless x is a radius or an angle. Without any of these the limit
    is unknown. If `least`, the limit is a lower bound. A value above `warning` is reported though allowed. `factor`:
    design factor, or product of partial factors, between the limit and the `breaking` force [N]. `elements`: ropes,
    slings or bodies from which the quantity is evaluated. `spread`: increase of the static utilisation at the worst
    corner of uncertain `inputs`, as a fraction of it or, if `adds`, as a difference; for a clearance, its decrease [m].
    """

    subject: str
    quantity: Quantity
    unit: str
    value: float | None = None
    between: tuple[float, float] | None = None
    chart: tuple[tuple[float, float], ...] = ()
    over: str = ""
    least: bool = False
    warning: float | None = None
    factor: float = 1.0
    breaking: float = 0.0
    elements: tuple[str, ...] = ()
    signal: ScalarSignal | None = None  # that is checked, of the quantity "signal"
    source: str = ""
    rigging: float = 0.0  # mass of slings and shackles on the hooks that the model leaves out [kg]
    note: str = ""  # what a planner must know to read the row: assumptions, what a value was reduced for
    factors: tuple[Factor, ...] = ()  # by which what is read becomes a design load
    rest: RestLoad | None = None  # of a design load
    spread: float = 0.0
    adds: bool = False
    inputs: str = ""
    where: str = ""

    @property
    def loads(self) -> bool:
        """Whether the limited quantity is proportional to the lifted load."""
        return self.unit in ("N", "kg") or self.quantity == "rope factor"

    @property
    def known(self) -> bool:
        """Whether the limit has a value, a range or a chart."""
        return self.value is not None or self.between is not None or bool(self.chart)

    def at(self, x: float = 0.0) -> float:
        """Return the value of the limit at the argument x of its chart; raises ValueError if the limit is unknown.

        It is constant beyond the ends of the chart.

        A chart over a radius or an angle is not interpolated: the value at the next larger x applies, and the limit is
        0 beyond the last x.
        """
        if not self.chart:
            if self.value is None:
                raise ValueError(f"the {self.quantity} of {self.subject} has no limit")
            return self.value
        if self.over in ("radius", "angle"):
            return next((value for radius, value in self.chart if x <= radius * (1.0 + CLOSE)), 0.0)
        if x <= self.chart[0][0]:
            return self.chart[0][1]
        for (a, low), (b, high) in pairwise(self.chart):
            if x <= b:
                return low + (high - low) * (x - a) / (b - a)
        return self.chart[-1][1]

    def excess(self, value: float, x: float = 0.0) -> float:
        """Return the amount by which a value exceeds the limit, in the unit of the limit; negative within the limit."""
        if self.between is not None:
            return max(value - self.between[1], self.between[0] - value)
        return self.at(x) - value if self.least else value - self.at(x)

    def use(self, value: float, x: float = 0.0) -> float:
        """Return the utilisation of the limit by a value; 1 at the limit."""
        if self.between is not None:
            low, high = self.between
            return abs(2.0 * value - low - high) / (high - low)
        bound = self.at(x)
        if self.least:
            return bound / value if value > 0.0 and bound > 0.0 else inf if value < bound else 0.0
        return value / bound if bound else inf * value if value else 0.0

    def met(self, value: float | None = None, t: float | None = None) -> "Use":
        """Return the utilisation of this limit by a value at t [s]; without a value, by the clearance at rest."""
        value = self.rest.value if value is None and self.rest and self.quantity == "clearance" else value
        return Use(self, value, t, use=None if value is None else self.use(value))


@dataclass(frozen=True)
class Use:
    """The highest utilisation of a limit, with the value of its quantity, the time [s] and the stage. The value [unit
    of the limit] is None without data.

    `use` is 1 at the limit and larger beyond it; None if the limit is unknown.
    """

    limit: RatedLimit
    value: float | None
    t: float | None = None
    stage: str = ""
    use: float | None = None
    action: int = 0  # number of the action that led there, from 1; 0: the start, or not known
    bound: float | None = None  # the limit there, of a chart
    tolerance: float = 0.0  # so much beyond the limit is still at it [unit]
    source: str = ""  # where the value comes from: "as simulated", "as ordered"
    missing: bool = False  # nothing was recorded of which it could be found

    @property
    def beyond(self) -> bool:
        """Whether the limit is exceeded."""
        if self.use is None or self.value is None or self.use <= 1.0 + ROUNDING:
            return False
        return not self.tolerance or self.limit.excess(self.value) > self.tolerance

    @property
    def at_worst(self) -> "Use":
        """This utilisation of the limit at the worst corner of the uncertain inputs."""
        limit, value = self.limit, self.value
        if not limit.spread or value is None or self.use is None:
            return self
        if limit.quantity == "clearance":
            return replace(self, use=limit.use(value - limit.spread), value=value - limit.spread)
        use = self.use + limit.spread if limit.adds else self.use * (1.0 + limit.spread)
        if limit.between is not None:
            low, high = limit.between
            middle, half = (low + high) / 2.0, (high - low) / 2.0
            return replace(self, use=use, value=middle + (half if value >= middle else -half) * use)
        bound = limit.at() if self.bound is None else self.bound
        return replace(self, use=use, value=bound / use if limit.least else bound * use)

    @property
    def excess(self) -> float:
        """Amount by which the value exceeds limit and tolerance [unit of the limit]; negative within the limit."""
        if self.value is None or self.bound is None:
            return self.limit.excess(self.value or 0.0) - self.tolerance
        return (self.bound - self.value if self.limit.least else self.value - self.bound) - self.tolerance


class Reach(msgspec.Struct, frozen=True, kw_only=True):
    """Load on a hook [kg] at a radius [m] and a time [s], with the capacity by the radius chart [kg].

    The time is the beginning or end of a stage with load, or that of the highest utilisation."""

    hook: str
    stage: str
    when: str = ""
    t: float
    radius: float
    load: float
    capacity: float

    @property
    def use(self) -> float:
        """Utilisation of the radius chart; infinite beyond its largest radius."""
        return self.load / self.capacity if self.capacity else inf
