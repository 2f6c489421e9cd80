"""The action list followed statically, with a cache for the plan and the code.

The result is plain data: a second load of the same scene reads it from the cache.
"""

import hashlib
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import msgspec
from heavylift.kernel.cache import contents, remembered, sources
from heavylift.kernel.description.findings import Check
from heavylift.nodes.plan import plan

from .state import Acted, StaticState


@dataclass(frozen=True)
class Followed:
    """The equilibrium path along an action list: all states, the state at the beginning of each action, and notes with
    their times [s].

    `why`: why the path ended before the list was completed, or ""; `unstable`: time from which the equilibrium is
    unstable [s]; `cut`: what the list still waits for when the scene ends; `tripped`: times [s] and names of tripped
    interlocks; `goals`, `found`: states at the ends of moves and findings, for several lifts.
    """

    states: tuple[StaticState, ...]
    acted: tuple[Acted, ...]
    notes: tuple[tuple[float, str], ...]
    why: str
    unstable: float | None
    cut: str
    tripped: tuple[tuple[float, str], ...] = ()
    goals: tuple[StaticState, ...] = ()
    found: tuple[Check, ...] = ()

    @property
    def known(self) -> bool:
        """Whether the whole action list could be followed statically."""
        return not self.why


def follow(built: plan.Plan, keep: bool = True) -> Followed:
    """Return the equilibrium path of a plan along its action list; it does not depend on the plan's model level.

    If `keep`, use a cached result or store the result in the cache."""
    whole = at_rest(built)
    return remembered(f"{plan_key(whole)}.path", Followed, lambda: _walked(whole)) if keep else _walked(whole)


def first_rest(built: plan.Plan) -> StaticState:
    """Return the equilibrium of a plan at the start; raises KernelError if there is none."""
    from .static_run import StaticRun

    run = StaticRun(at_rest(built))
    found = run.rest()
    run.models.give_back()
    return found


def _walked(whole: plan.Plan) -> Followed:
    from .static_run import StaticRun  # compiles, which what is kept does not need

    r = StaticRun(whole)
    r.walk()
    unstable = r.path.unstable_since
    notes = tuple((note.t_ns * 1e-9, note.sentence) for note in r.path.notes)
    since = None if unstable is None else unstable * 1e-9
    if not r.why:
        r.models.give_back()
    return Followed(tuple(r.states), tuple(r.acted), notes, r.why, since, r.cut, tuple(r.tripped))


def at_rest(built: plan.Plan) -> plan.Plan:
    """Return the plan for static calculations: elastic ropes without lumped masses, all supports, no user models."""
    # statics at the full level: the path must not depend on the level that is chosen by means of it
    fidelity = plan.Fidelity(girder=built.fidelity.girder)
    usual = plan.Plan(name=built.name)
    steps = {key: getattr(usual, key) for key in ("method", "tolerance", "step", "samples_hz")}
    return msgspec.structs.replace(built, fidelity=fidelity, models=(), **steps)


def plan_key(built: plan.Plan) -> str:
    """Return the cache key for a plan and for the code that computes its equilibrium path."""
    return hashlib.sha256(_sources() + plan.encode(built)).hexdigest()


@cache
def _sources() -> bytes:
    here = Path(__file__).parent.parent
    layers = ("fidelity", "statics", "models", "devs", "plan")
    return hashlib.sha256(sources() + b"".join(contents(here / layer, ".py") for layer in layers)).digest()
