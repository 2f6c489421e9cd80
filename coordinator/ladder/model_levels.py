"""Candidates for modelling a plan: model level, integration method, and tolerance of a step.

A level that models everything that another level leaves out can be its witness, with which it is compared; the
difference between two levels that leave out the same effect says nothing about that effect. Settings that the scene
fixes are kept in its own runs, but not in runs of witnesses.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import msgspec
from heavylift.kernel.description.mechanics import System
from heavylift.nodes.models import system
from heavylift.nodes.models.levels.listing import left_out
from heavylift.nodes.plan.fidelity import planar
from heavylift.nodes.plan.plan import Fidelity, Plan

LADDER = (
    Fidelity(),
    Fidelity(girder="elastic", rope_mass="lumped"),
    *(Fidelity(ropes="massive", lumps=n, rope_mass="lumped", girder="elastic") for n in (2, 4, 8, 16)),
)
WATERS: dict[Literal["motion given", "one frequency"], str] = {
    "motion given": "motion of vessels given",
    "one frequency": "water at one frequency",
}  # coarsest first
TOLERANCES = {"radau5": (3, 8), "dop853": (6, 11)}  # exponents of the loosest and of the tightest decade
OTHERS = (5, 10)
DECADE = 2  # candidates of a level from one tolerance to a tenth of it
FINEST = 1e-12  # tolerance of a step


def levels(plan: Plan) -> list[Fidelity]:
    """Return the model levels of a plan, coarsest first, without levels that give the same system of equations."""
    found: dict[str, Fidelity] = {}
    for each in LADDER:
        fidelity = msgspec.structs.replace(planar(each, plan.machines), islands=plan.fidelity.islands)
        found.setdefault(repr(system(at_level(plan, fidelity))), fidelity)
    return list(found.values())


def at_level(plan: Plan, fidelity: Fidelity) -> Plan:
    """Return the plan at another model level; lifts that state a level of their own keep it."""
    own = msgspec.structs.replace(fidelity, islands=plan.fidelity.islands)
    lists = tuple(
        msgspec.structs.replace(each, fidelity=own) if each.fidelity == plan.fidelity else each for each in plan.lists
    )
    return msgspec.structs.replace(plan, fidelity=own, lists=lists)


def stiff(mechanics: System) -> bool:
    """Return whether a system has elastic parts (ropes, pads, springs, servos, laws), which may make it stiff."""
    soft = (mechanics.laws, mechanics.rigid_ropes, mechanics.contacts, mechanics.drives)
    return any(soft) or any(body.flexible for body in mechanics.bodies)


def undamped(mechanics: System) -> bool:
    """Return whether some elastic element has no damping of its own; a stiff integration method would then damp it
    numerically."""
    elastic = (*mechanics.laws, *(body.flexible for body in mechanics.bodies))
    return any(getattr(x, "damping", 1.0) == 0.0 for x in elastic)


@dataclass(frozen=True)
class ModelLevel:
    """A model level together with integration method and time steps: a candidate in the choice of a model level."""

    plan: Plan

    @property
    def key(self) -> tuple[Fidelity, str, float, float | None]:
        """Key that is equal for equal fidelity, integration method, tolerance and time step."""
        return self.plan.fidelity, self.plan.method, self.plan.tolerance, self.plan.step

    @property
    def name(self) -> str:
        """The model level and the time steps in words."""
        return f"{self.level}, {self.how}"

    @property
    def level(self) -> str:
        """The effects that the model level includes, in words."""
        at = self.plan.fidelity
        if at.water != "memory":
            return f"{self.on(msgspec.structs.replace(at, water='memory')).level}, {WATERS[at.water]}"
        if not left_out(at_level(self.plan, LADDER[0])):
            return "as it is written"
        ropes = f"ropes of {at.lumps} lumps" if at.ropes == "massive" else f"{at.ropes} ropes"
        mass = ", their mass at the ends" if at.ropes != "massive" and at.rope_mass == "lumped" else ""
        return f"{ropes}{mass}, {at.girder} girder"

    @property
    def how(self) -> str:
        """The integration method and the time steps in words."""
        steps = (
            f"steps of {self.plan.step:g} s" if self.plan.step else f"{self.plan.tolerance:.0e}".replace("e-0", "e-")
        )
        return f"{self.plan.method} at {steps}" if not self.plan.step else f"{self.plan.method}, {steps}"

    @property
    def left_out(self) -> tuple[str, ...]:
        """The effects that the model level leaves out, in words."""
        return left_out(self.plan)

    @property
    def tighter(self) -> "ModelLevel":
        """The same model level with a tenth of the tolerance, or half the fixed time step."""
        if self.plan.step is not None:
            return ModelLevel(msgspec.structs.replace(self.plan, step=0.5 * self.plan.step))
        return ModelLevel(msgspec.structs.replace(self.plan, tolerance=max(FINEST, 0.1 * self.plan.tolerance)))

    def within(self, tolerance: float) -> "ModelLevel":
        """Return the same model level with a tolerance that is at most this one."""
        return ModelLevel(msgspec.structs.replace(self.plan, tolerance=min(self.plan.tolerance, tolerance)))

    def on(self, level: Fidelity) -> "ModelLevel":
        """Return the same integration method and time steps at another model level."""
        return ModelLevel(at_level(self.plan, level))

    @property
    def settings(self) -> list[str]:
        """The scene settings that select this model level and these time steps."""
        fields = (f for f in msgspec.structs.fields(Fidelity) if f.name != "where")
        values = ((f, getattr(self.plan.fidelity, f.name)) for f in fields)
        written = [f"{f.name.replace('_', ' ')}: {_written(x)}" for f, x in values if x != f.default]
        steps = [f"step={1e3 * self.plan.step!r} ms"] if self.plan.step else [f"tolerance={self.plan.tolerance!r}"]
        steps += [f"samples={self.plan.samples_hz!r} Hz"] if self.plan.samples_hz != Plan.samples_hz else []
        return ["ask=[]", f"fidelity={{{', '.join(written)}}}", f"method={self.plan.method}", *steps]


@dataclass(frozen=True)
class Ladder:
    """All combinations of model level and time steps for a plan; the scene's own settings `named` stay fixed."""

    plan: Plan
    named: Sequence[str] = ()

    @cached_property
    def full(self) -> list[Fidelity]:
        """All model levels of the plan, including levels that the scene's settings exclude."""
        return levels(self.plan)

    @property
    def compared(self) -> list[Fidelity]:
        """All model levels; for vessels in waves also the finest one with each simpler model of the water."""
        finest = self.full[-1]
        flat = [msgspec.structs.replace(finest, water=water) for water in WATERS]
        whole = system(at_level(self.plan, finest))
        return [*(x for x in flat if system(at_level(self.plan, x)) != whole), *self.full]

    @cached_property
    def levels(self) -> list[Fidelity]:
        """The model levels that agree with the settings of the scene."""
        keep = {key: getattr(self.plan.fidelity, key) for key in Fidelity.__struct_fields__ if key in self.named}
        parts = self.plan.machines
        own = [planar(msgspec.structs.replace(each, **keep), parts) for each in self.full] if keep else self.full
        return list(dict.fromkeys(own))

    @property
    def plausible(self) -> list[Fidelity]:
        """The model levels among which the choice is made, coarsest first.

        With the implicit method the coarsest level is left out: it costs as much as the next one, since implicit steps
        do not resolve the fast motion of a girder.
        """
        return self.levels[1:] if self.method == self.own == "radau5" and len(self.levels) > 1 else self.levels

    @cached_property
    def whole(self) -> list[Fidelity]:
        """Model levels with all effects of the finest one; they differ only in the lumps per rope, finest last."""
        finest = self.full[-1]
        return [x for x in self.full if msgspec.structs.replace(x, lumps=finest.lumps) == finest]

    def waves(self, level: Fidelity) -> bool:
        """Return whether waves run along the ropes of a level."""
        return len(self.whole) > 1 and level in self.whole

    def witnesses(self, level: Fidelity) -> list[Fidelity]:
        """Return the model levels that include every effect which `level` leaves out, cheapest first; empty for the
        finest level."""
        if len(self.full) == 1 and level in self.levels:
            return []
        return self.whole[self.whole.index(level) + 1 :] if level in self.whole else self.whole

    @property
    def poorer(self) -> Fidelity | None:
        """The model level just below the finest one, for the error estimate of the finest; None if there is only one
        level."""
        return (self.whole if len(self.whole) > 1 else self.full)[-2] if len(self.full) > 1 else None

    @cached_property
    def own(self) -> str:
        """The default integration method of the plan: radau5 for stiff systems, otherwise dop853."""
        mechanics = system(self.plan)
        return "radau5" if stiff(mechanics) and not undamped(mechanics) else "dop853"

    @property
    def method(self) -> str:
        """The integration method for all model levels: that of the scene, or else the default."""
        return self.plan.method if {"method", "step"} & {*self.named} else self.own

    def in_own_steps(self, candidate: ModelLevel) -> ModelLevel:
        """Return the same model level with the default integration method, for runs that measure the error of the
        level.

        The level error does not depend on the steps, and other methods may be slow at a finer level.
        """
        if (candidate.plan.method, candidate.plan.step) == (self.own, None):
            return candidate
        tolerance = 0.1 ** (TOLERANCES[self.own][0] + 1)
        return ModelLevel(msgspec.structs.replace(candidate.plan, method=self.own, tolerance=tolerance, step=None))

    def candidates(self, level: Fidelity) -> list[ModelLevel]:
        """Return the time steps to try at a model level, the cheapest first; only one if the scene fixes them."""
        loosest, tightest = TOLERANCES.get(self.method, OTHERS)
        tolerances = tuple(x * 10.0**-k for k in range(loosest, tightest + 1) for x in (1.0, 0.3))
        if {"tolerance", "step"} & {*self.named}:
            tolerances = (self.plan.tolerance,)
        step = self.plan.step if "step" in self.named else None
        at = at_level(self.plan, level)
        steps = ({"method": self.method, "tolerance": x, "step": step} for x in tolerances)
        return [ModelLevel(msgspec.structs.replace(at, **each)) for each in steps]


def _written(value: object) -> str:
    """Return a value of the fidelity as written in a scene file."""
    return f"[{', '.join(map(str, value))}]" if isinstance(value, tuple) else str(value)
