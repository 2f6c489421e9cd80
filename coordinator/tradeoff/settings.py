"""What a scene can be run with: rungs of the ladder, methods, and the steps or tolerances of each, cheapest first.

The ladder is that of the yard's models from rigid ropes to heavy ones on a soft girder; the rungs that the
scene's questions would be given (`nodes.fidelity`) come on top.  A mechanism has one rung: it is what its file says.
"""

from __future__ import annotations

import shlex
from dataclasses import dataclass

import msgspec
from heavylift.nodes.fidelity import Question, choose
from heavylift.nodes.fidelity.lifts import lift_of
from heavylift.nodes.plan.fidelity import Asked
from heavylift.nodes.plan.plan import Fidelity, Plan
from heavylift.nodes.plan.planar import planar
from heavylift.nodes.scene import LoadedScene

TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
STEPS = (0.05, 0.02, 0.01, 0.005, 0.002, 0.001)  # [s]
METHODS = (
    {"semi-implicit-euler": STEPS, "rk4": STEPS}
    | dict.fromkeys(("dopri5", "dop853"), TOLERANCES)
    | {"radau5": (1e-2, *TOLERANCES)}
)
FIXED = ("semi-implicit-euler", "rk4")
AS_WRITTEN, ALL = "as written", "all asked"
SPOKEN = ("ropes", "slings", "girder", "motion")  # named in every rung, whatever is the default
LUMPS = (2, 4)  # of heavy ropes; twice as many as the last show whether the reference has converged


@dataclass(frozen=True)
class Rung:
    """A name for people and what is modelled; None: as the scene says."""

    name: str
    fidelity: Fidelity | None

    @property
    def words(self) -> str:
        """The rung as a setting of the scene, which takes the place of all that the scene names of it; "" for what the
        scene says itself."""
        if self.fidelity is None:
            return ""
        spoken = {*SPOKEN, *(["lumps"] if self.fidelity.ropes == "massive" else [])}
        fields = (f for f in msgspec.structs.fields(Fidelity) if f.name != "where")
        values = ((f, getattr(self.fidelity, f.name)) for f in fields)
        named = (f"{f.name.replace('_', ' ')}: {_written(x)}" for f, x in values if f.name in spoken or x != f.default)
        return f"fidelity={{{', '.join(named)}}}"


@dataclass(frozen=True)
class Setting:
    """One way to run a scene: by a tolerance, or by fixed steps [s]."""

    rung: Rung
    method: str
    tolerance: float | None = None
    step: float | None = None

    @property
    def how(self) -> str:
        """Tolerance or step, as people write it."""
        return f"{self.step * 1e3:g} ms" if self.step is not None else f"{self.tolerance:.0e}".replace("e-0", "e-")

    def __str__(self) -> str:
        return f"{self.rung.name}, {self.method} at {self.how}"

    def words(self, scene: LoadedScene) -> str:
        """What a user types to run a scene so: whatever it asks or names itself, nothing is chosen anew."""
        plan = self.plan(scene.plan)
        sets = [*scene.settings, *(["ask=[]"] if scene.scene.ask else []), *([self.rung.words] * bool(self.rung.words))]
        if self.step is None or scene.scene.ask or scene.scene.tolerance:
            sets.append(f"tolerance={plan.tolerance!r}")
        if self.step is None and scene.plan.step is not None:
            sets.append("step=null")
        given = [x for words in sets for x in ("--set", words)] + ["--method", self.method]
        given += ["--step", self.how] if self.step is not None else []
        return shlex.join(["heavylift", "run", scene.typed, *given])

    def plan(self, plan: Plan) -> Plan:
        """The plan of a scene in this setting."""
        fidelity = self.rung.fidelity or plan.fidelity
        tolerance = self.tolerance if self.tolerance is not None else plan.tolerance
        steps = {"method": self.method, "tolerance": tolerance, "step": self.step}
        return msgspec.structs.replace(plan, fidelity=fidelity, **steps)


def ladder(scene: LoadedScene) -> tuple[list[Rung], Rung | None]:
    """The rungs of a scene, poorest first, and the one above the richest; none for a mechanism."""
    plan = scene.plan
    if lift_of(plan).block is None or scene.followed is None:
        return [Rung(AS_WRITTEN, None)], None
    rungs = [
        Rung("rigid", Fidelity(ropes="rigid", slings="rigid")),
        Rung("elastic ropes", Fidelity(slings="rigid")),
        Rung("+ elastic slings", Fidelity()),
        Rung("+ girder", Fidelity(girder="elastic")),
        *(_massive(n) for n in LUMPS),
    ]
    return rungs, _massive(2 * LUMPS[-1])


def chosen(scene: LoadedScene, ask: tuple[Asked, ...], limit: float) -> list[Rung]:
    """The rungs that a scene would be given if it asked each quantity alone, and all, and named nothing itself; none
    for a mechanism."""
    plan = msgspec.structs.replace(scene.plan, fidelity=Fidelity())
    if lift_of(plan).block is None or scene.followed is None:
        return []
    found: dict[Fidelity, list[str]] = {}
    for question in dict.fromkeys((*((quantity,) for quantity in ask), ask)):
        verdict = choose(plan, scene.followed, Question(question, limit), frozenset())
        fidelity = planar(verdict.fidelity, plan.machines)
        found.setdefault(fidelity, []).append(question[0] if len(question) == 1 else ALL)
    return [Rung(f"chosen for {ALL if ALL in names else _listed(names)}", f) for f, names in found.items()]


def _listed(names: list[str]) -> str:
    *first, last = names
    return f"{', '.join(first)} and {last}" if first else last


def _written(value: object) -> str:
    """A value of the fidelity as a scene file has it."""
    return f"[{', '.join(map(str, value))}]" if isinstance(value, tuple) else str(value)


def _massive(lumps: int) -> Rung:
    return Rung(f"+ rope mass, {lumps} lumps", Fidelity(ropes="massive", lumps=lumps, girder="elastic"))


def settings(rung: Rung, method: str) -> list[Setting]:
    """Every step or tolerance of a method, cheapest first."""
    if method in FIXED:
        return [Setting(rung, method, step=h) for h in METHODS[method]]
    return [Setting(rung, method, tolerance=x) for x in METHODS[method]]
