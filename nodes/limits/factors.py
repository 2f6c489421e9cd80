"""Factors that lead from the static load of each hook, sling, shackle and lug to its design load.

A practice (standard) supplies the factors that its clauses define. Every other factor that the lift needs and that is
not given becomes a limit without a value, whose check is amber. In a run, the simulated load, without the dynamic
factor, is used instead of the static load if it is larger.
"""

from collections.abc import Iterator, Mapping, Sequence
from math import prod, sqrt
from typing import NamedTuple

from heavylift.kernel.algebra.elementary import sin
from heavylift.nodes.plan.connections import lug_places, ties_on
from heavylift.nodes.plan.factors import Factor, Factors
from heavylift.nodes.plan.limit import Quantity, RatedLimit, RestLoad, Use
from heavylift.nodes.plan.plan import Plan
from heavylift.nodes.statics.aiming import world
from heavylift.nodes.statics.state import StaticState
from msgspec.structs import replace

from .standards import ND_0027, SHARING, daf

BASES: dict[Quantity, Quantity] = {
    "hook design load": "hook load",
    "sling design load": "sling tension",
    "shackle design load": "shackle load",
    "lug design load": "lug load",
}
NAMES = ("inputs", "weight", "cog", "dynamic", "tilt", "heights", "yaw", "skew", "consequence", "wind")  # in order
BELOW = ("yaw", "skew")  # that act below hooks alone
AIR = 1.25  # [kg/m3]
TILT, RISE, APART = 0.05233595624294383, 1.0, 0.08715574274765817  # sin 3 deg, [m], sin 5 deg
FOUR = 4  # slings from one hook whose shares follow from their lengths
Key = tuple[str, str]


class Clause(NamedTuple):
    """A clause of a standard that requires a load factor.

    `value` is None if the factor depends on the lift or must be confirmed."""

    source: str
    value: float | None = None


PRACTICES: dict[str, dict[str, Clause]] = {  # what was read in a public copy has a value
    "0027/ND": {
        "weight": Clause(f"{ND_0027} with 0001/ND, section 8"),
        "cog": Clause(f"{ND_0027}, 6.3.1 and 8.4.3"),
        "dynamic": Clause(f"{ND_0027}, table 5-1"),
        "tilt": Clause(f"{ND_0027}, 5.4.2 to 5.4.6"),
        "heights": Clause(f"{ND_0027}, 5.4.2, by analogy"),
        "yaw": Clause(f"{ND_0027}, 5.4.7", 1.05),
        "skew": Clause(f"{SHARING['four slings'].source}, matched pairs within +-2 d", SHARING["four slings"].factor),
        "consequence": Clause(f"{ND_0027}, table 11-1", 1.30),
    }
}


class LiftConditions(NamedTuple):
    """The properties of a lift on which the load factors for one of its parts depend."""

    weight: float  # of what is lifted [N]
    hooks: tuple[str, ...]  # that carry it
    cranes: int
    several: bool  # slings hang on the part's hook
    four: bool  # and hold one rigid body


def design_limits(
    plan: Plan,
    given: Factors,
    practice: str,
    uses: Sequence[Use],
    states: Sequence[StaticState],
    lateral: Mapping[Key, float],
    uncertain: Mapping[Key, tuple[float, str]],
) -> Iterator[RatedLimit]:
    """Yield the limit of the design load of each part, and a limit without a value for each missing factor.

    `uses`, `states`: utilisations and states of the equilibrium path; `lateral`: increase of utilisation when the
    centre of mass is at a corner of its uncertainty box; `uncertain`: increase at the worst corner of the uncertain
    inputs, with their names."""
    clauses, missing = PRACTICES.get(practice, {}), dict[str, str]()
    strengths = {x.subject: x for x in plan.limits if x.quantity == "sling peak"}
    for quantity, base in BASES.items():
        for use in (use for use in _rated(uses, base) if use.value):
            limit = use.limit
            lift = _lift(plan, limit)
            if lift is None or use.value is None:
                continue
            found = list[Factor]()
            for name in NAMES[1:]:
                if not _needed(name, quantity, lift):
                    continue
                value, source = _value(name, given, clauses, lift, plan, limit, states, lateral)
                if value is None:
                    missing[name] = source
                elif quantity != "hook design load" or name != "dynamic" or given.dynamics == "not included":
                    found.append(Factor(name=name, value=value, source=source))
            if (worst := uncertain.get((limit.subject, limit.quantity))) is not None:
                found.insert(0, Factor(name="inputs", value=worst[0], source=f"corners of {worst[1]}"))
            if (
                quantity == "hook design load"
                and limit.over == "radius"
                and not limit.rigging
                and given.rigging is None
            ):
                missing["rigging"] = (
                    "mass of slings and shackles: write 'factors: {rigging: 1 t}', or 'mass' of the gear"
                )
            if quantity == "hook design load" and not given.dynamics and "dynamic" not in missing:
                missing["dynamics"] = "whether capacities of hooks include dynamics: write 'dynamics: included'"
            alone = quantity == "hook design load" and given.dynamics != "not included"
            rest = RestLoad(
                value=use.value, bound=use.value / use.use if use.use else 0.0, stage=use.stage, alone=alone
            )
            row = replace(limit, quantity=quantity, factors=tuple(found), rest=rest, spread=0.0, adds=False, inputs="")
            if quantity == "sling design load" and limit.subject in strengths:
                most = strengths[limit.subject]
                row = replace(row, value=most.value, factor=most.factor, source=most.source, note=most.note)
            elif quantity == "shackle design load" and limit.value:
                more = next((x.value for x in found if x.name == "dynamic"), 1.0)
                row = replace(row, value=limit.value * more, note=f"WLL x {more:g} ({ND_0027}, 8.2.6)")
            if row.value:
                row = replace(row, rest=replace(rest, bound=row.value))
            yield row
    for name, source in missing.items():
        yield RatedLimit(subject=name, quantity="factor", unit="", note=source)


def _rated(uses: Sequence[Use], base: Quantity) -> Iterator[Use]:
    """Yield the utilisations of the limits on which design loads of a kind are based: for hooks that share a load, of
    their reduced capacity."""
    shared = {x.limit.subject: x for x in uses if x.limit.quantity == "tandem load" and base == "hook load"}
    yield from (shared.get(x.limit.subject, x) for x in uses if x.limit.quantity == base)


def _lift(plan: Plan, limit: RatedLimit) -> LiftConditions | None:
    """Return the properties of the lift whose load a part carries; None if the part carries no load."""
    for machine in plan.machines:
        for cargo in machine.cargo:
            held: dict[str, list[str]] = {}
            cranes = set[str]()
            for crane in plan.machines:
                for hook in crane.hooks:
                    ties = [*ties_on(plan.machines, hook)]
                    if any(tie.lug in cargo.lugs or (tie.lower and tie.lower.body == cargo.body) for tie in ties):
                        held[hook.rope] = [tie.rope for tie in ties]
                        cranes.add(crane.name)
            own = [ropes for hook, ropes in held.items() if {hook, *ropes} & {*limit.elements}]
            if own:
                bent = any(b.flexible for m in plan.machines for b in m.system.bodies if b.name == cargo.body)
                direct = [x for m in plan.machines for x in m.ties if any(x.rope in ropes for ropes in own)]
                to = [x for x in direct if x.lug in cargo.lugs or (x.lower and x.lower.body == cargo.body)]
                four = any(sum(y.upper == x.upper for y in to) >= FOUR for x in to) and not bent
                several = any(len(ropes) > 1 for ropes in own)
                return LiftConditions(cargo.mass * plan.gravity, tuple(held), len(cranes), several, four)
    return None


def _needed(name: str, quantity: str, lift: LiftConditions) -> bool:
    if name in BELOW and quantity == "hook design load":
        return False
    return {
        "tilt": len(lift.hooks) == 2, "heights": len(lift.hooks) > 3, "yaw": len(lift.hooks) == 2 and lift.several,
        "skew": lift.four, "consequence": quantity == "lug design load",
    }.get(name, True)  # fmt: skip


def _value(
    name: str,
    given: Factors,
    clauses: Mapping[str, Clause],
    lift: LiftConditions,
    plan: Plan,
    limit: RatedLimit,
    states: Sequence[StaticState],
    lateral: Mapping[Key, float],
) -> tuple[float | None, str]:
    """Return a factor and its source; if the factor is missing, None and a sentence that says how to supply it."""
    clause = clauses.get(name, Clause("no practice"))
    own = getattr(given, f"{name}_factor" if name in ("cog", "tilt") else name)
    if name == "wind":
        return _wind(given, lift)
    if name == "cog" and given.cog is not None:
        box = ", ".join(f"{x:g}" for x in given.cog)
        radius = ", with the radius that goes with each" if limit.over == "radius" else ""
        return lateral.get((limit.subject, limit.quantity)), f"corners of a box of +- {box} m, at rest{radius}"
    if name == "tilt" and own is None and given.tilt is not None:
        return tilted(plan, lift.hooks, limit, states, float(sin(given.tilt)), 0.0), "the scene"
    if name == "tilt" and own is None and clauses and plan.place in ("inshore", "offshore"):
        if lift.cranes == 1:
            return tilted(plan, lift.hooks, limit, states, TILT, RISE), f"{clause.source}, 3 degrees or 1 m"
        return tilted(plan, lift.hooks, limit, states, APART, 0.0), f"{clause.source}, 5 degrees"
    if own is not None:
        return own, "the scene"
    if name == "dynamic" and clauses and (required := daf(plan.place, lift.weight / plan.gravity)):
        return required
    if clause.value is not None:
        return clause.value, clause.source
    key = {"cog": "cog: [0.5 m, 0.5 m, 0 m]", "tilt": "tilt: 3 deg"}.get(name, f"{name}: 1.05")
    return None, f"to be confirmed ({clause.source}): write 'factors: {{{key}}}'"


def _wind(given: Factors, lift: LiftConditions) -> tuple[float | None, str]:
    """Return the wind factor of a load, which is the resultant of wind force and weight divided by the weight, and its
    source; None and the remedy if no wind is given."""
    if given.wind is None or (given.wind and not given.area):
        return None, "to be confirmed: write 'factors: {wind: 10 m/s, area: 100 m2}', in no wind 'wind: 0 m/s'"
    if not given.wind:
        return 1.0, "no wind on the load"
    force, message = wind_force(given)
    return sqrt(1.0 + (force / lift.weight) * (force / lift.weight)), message


def wind_force(given: Factors) -> tuple[float, str]:
    """Return the force [N] of the stated wind on the load, and its formula; 0 if no wind or no area is given."""
    wind = given.wind or 0.0
    force = 0.5 * AIR * given.drag * given.area * wind * wind
    return force, f"0.5 x {AIR:g} kg/m3 x {given.drag:g} x {given.area:g} m2 x ({wind:g} m/s)2 = {force / 1e3:.4g} kN"


def tilted(
    plan: Plan, hooks: Sequence[str], limit: RatedLimit, states: Sequence[StaticState], sine: float, rise: float
) -> float | None:
    """Return the factor by which the load on a part increases when the block tilts between two hooks (0027/ND, B.1.2).

    The state is the one with the largest static load on the part. `sine`: sine of the tilt angle; `rise` [m]: height by
    which one hook is hoisted more than the other; the larger tilt of the two counts (plumb ropes)."""
    most: tuple[float, float] | None = None
    for state in (x for x in states if not x.grounded):
        ends = [_end(plan, state, hook) for hook in hooks]
        if None in ends:
            continue
        (first, g), (second, _) = (end for end in ends if end is not None)
        distance = [second[i] - first[i] for i in (0, 1)]
        apart = sqrt(distance[0] * distance[0] + distance[1] * distance[1])
        mine = next((i for i, hook in enumerate(hooks) if _on(plan, hook) & {*limit.elements}), 0)
        load = state.tensions.get(hooks[mine], 0.0)
        if apart == 0.0 or (most is not None and load <= most[0]):
            continue
        s = max(sine, rise / apart)
        c = sqrt(1.0 - s * s)
        x = [sum((p[i] - g[i]) * distance[i] for i in (0, 1)) / apart for p in (first, second)]
        z = [p[2] - g[2] for p in (first, second)]
        other, sign = (x[1], 1.0) if mine == 0 else (x[0], -1.0)
        level = sign * other / (x[1] - x[0])
        shares = []
        for lean in (s, -s):
            a, b = (x[i] * c + z[i] * lean for i in (0, 1))
            shares.append(sign * (b if mine == 0 else a) / (b - a))
        most = load, max(shares) / level if level else 1.0
    return None if most is None else max(1.0, most[1])


def _on(plan: Plan, rope: str) -> set[str]:
    """Return the names of a hook rope and of the slings on its hook."""
    hook = next(hook for machine in plan.machines for hook in machine.hooks if hook.rope == rope)
    return {rope, *(tie.rope for tie in ties_on(plan.machines, hook))}


Vector = tuple[float, float, float]


def _end(plan: Plan, state: StaticState, rope: str) -> tuple[Vector, Vector] | None:
    """Return the suspension point of a load on a hook and the load's centre of mass, in the world frame [m]. The
    suspension point is the common upper point of its slings, or else the mean of its lugs."""
    lugs, places = lug_places(plan.machines), list[tuple[Vector, Vector]]()
    hook = next(hook for machine in plan.machines for hook in machine.hooks if hook.rope == rope)
    body = ""
    for tie in ties_on(plan.machines, hook):
        lug = lugs.get(state.hooked.get(tie.rope, "")) or tie.lower
        if lug is not None and lug.body in {p.body for p in lugs.values()} and state.tensions.get(tie.rope, 0.0) > 0.0:
            upper, lower = world(state, tie.upper.body, tie.upper.p), world(state, lug.body, lug.p)
            places.append((upper, lower))
            body = lug.body
    if not places:
        return None
    com = next(cargo.com for machine in plan.machines for cargo in machine.cargo if cargo.body == body)
    meet = len(places) > 1 and all(a == places[0][0] for a, _ in places)
    points = [places[0][0]] if meet else [b for _, b in places]
    x, y, z = (sum(p[i] for p in points) / len(points) for i in range(3))
    return (x, y, z), world(state, body, com)


def product(limit: RatedLimit, *, dynamic: bool) -> float:
    """Return the product of a limit's load factors, without the dynamic factor if the load is already `dynamic`."""
    return prod(x.value for x in limit.factors if not (dynamic and x.name == "dynamic"))
