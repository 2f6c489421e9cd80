"""Checks of a lift: each row of the table of limits, and every other finding, becomes a check with a state.

red        beyond the limit
undecided  the error interval of the value includes the limit
amber      not checked, assumed by heavylift, of unknown error, or a warning
green      checked: value and error within the limit
none       cannot occur in this scene: a row without a colour

`line_of` summarises the checks in one line, the verdict.
"""

from collections.abc import Iterable, Mapping, Sequence
from math import inf, isfinite

from heavylift.kernel.description.findings import (
    ASSUMED,
    IN_A_RUN,
    NOT_CHECKED,
    NOT_MODELLED,
    STATES,
    UNKNOWN,
    WARNED,
    Check,
    State,
    clock,
)
from heavylift.kernel.description.forces import Radiation
from heavylift.nodes.plan.limit import IN_WIND, ORDERED, ROUNDING, Use
from heavylift.nodes.plan.plan import Plan
from heavylift.nodes.plan.shapes import HULL, Shapes
from heavylift.recordings.format.spellings import BEAM_LOAD
from heavylift.recordings.sheets.sheet import Cell, Marked, Table, words
from msgspec.structs import replace

from .check_numbers import numbers_of
from .messages import NOISE, allowed, bound, name_of, percent, sentence, shown

Errors = Mapping[str, float]  # relative: of "peak tension ROPE", "smallest clearance", "use of SUBJECT QUANTITY"
ABSENT = ("wind", "ground pressure", "bridle angle")  # of nothing: there is no wind, no footing, no straight leg
NEAR = 0.1  # [m] errors of smaller clearances are relative to it
HEAD = ("state", "check", "worst of", "worst", "at", "limit", "used", "basis")
TOUCH = 0.01  # [m] what comes so near touches, as the sentences about clearances say
SAME = 1e-6  # of the worst value: what comes so close to it came to it first, or is reported first
SEA_STATE = "sea state"
SCOPE = "scope"  # quantity of what is not modelled
REMEDY = {
    UNKNOWN: ": the error of these values was not measured; `--accuracy 1%` measures it",
    ASSUMED: ": limits assumed by heavylift; state your own, or confirm them with 'assumed: accept'",
}
GOVERNING = 3  # checks with the highest utilisation that are printed
COUNTED = (NOT_CHECKED, ASSUMED, UNKNOWN, WARNED)  # kinds of amber, as the line counts them
UNCOLOURED = (IN_A_RUN, NOT_MODELLED)  # kinds of rows without a colour that it counts
LISTED: tuple[tuple[str, ...], ...] = (  # what each list has a row of, each with the quantities that check it
    ("hook load", "crane load"), ("rope factor", "rope tension"), ("drum pull",),
    ("sling tension", "assembly load", "heavy sling"), ("shackle load",), ("lug load",), ("frame load", BEAM_LOAD),
    ("support load",), ("ground pressure", "wheel load"), ("clearance",), ("off-lead", "off-lead along"),
    ("bridle angle",), ("tandem load",), ("wind",), ("uplift",), ("lift-off speed",), ("landing speed",),
    ("interlock",),
)  # fmt: skip


def checks_of(
    plan: Plan, uses: Sequence[Use], others: Iterable[Check], errors: Errors | None, shapeless: Iterable[str]
) -> list[Check]:
    """Return all checks of a run or an equilibrium path, the most severe first.

    Equally severe checks have the order of the table of limits, which goes from the hook down to the ground.

    `uses`: the highest utilisation of each limit; `others`: findings that have no limit; `errors`: error estimates of a
    run (None for an equilibrium path, which has none); `shapeless`: names of objects without a shape, whose clearance
    is unknown.
    """
    others = sorted(others, key=lambda x: (-_depth(x), round(x.t or 0.0, 2), x.quantity, x.subject))
    known = {(x.quantity, x.subject) for x in others}  # which has one row
    found = [_of_limit(plan, use, errors) for use in uses if (use.limit.quantity, use.limit.subject) not in known]
    found += others
    found += [
        Check(quantity="clearance", subject="", state="amber", why=NOT_CHECKED, sentence=what) for what in shapeless
    ]
    if any(m.hooks for m in plan.machines) and any(m.cargo for m in plan.machines) and not _factored(plan):
        message = "practice: none; write 'practice: 0027/ND', or 'factors: {...}'"
        found.append(Check(quantity="factor sheet", subject="all", state="amber", why=NOT_CHECKED, sentence=message))
    if (sea := sea_of(plan)) and not any(x.quantity == SEA_STATE for x in others):
        message = f"{sea}: one seed is no verdict; `heavylift run --replications 30` runs others"
        found.append(Check(quantity=SEA_STATE, subject="all", state="amber", why=NOT_CHECKED, sentence=message))
    radiating = [f for m in plan.machines for f in m.system.forces if isinstance(f, Radiation)]
    bodies = {x.body for f in radiating for x in (f.at, f.beside) if x}
    waters = {m.name: [f for f in m.system.forces if (x := getattr(f, "signal", None)) and (x.waves or x.wave)]
              for m in plan.machines if m.name in bodies}  # fmt: skip
    drift = f"{'slow' if sea else 'mean'} drift"
    open_ = [(drift, name, f"{drift} of {name}: not included; `heavylift hull --drift` adds its data")
             for name, loads in waters.items() if loads and not any(" drift" in x.name for x in loads)]  # fmt: skip
    afloat = [m.name for m in plan.machines if any(x.part == HULL for x in m.shapes)
              and any(j.kind == "free" and j.child == m.name for j in m.system.joints)]  # fmt: skip
    if len(afloat) - sum(1 for f in radiating if f.beside) > 1:
        # by Capytaine, a barge of 60 x 20 m changes sway loads of one of 36 x 14 m by 40 % at twenty beams
        message = (
            f"waves between {' and '.join(afloat)}: not included, each floats as if alone; they matter even twenty "
        )
        message += "beams apart: compute two hulls together and write 'floating: {beside: NAME}'"
        open_.append(("interaction", "all", message))
    found += [Check(quantity=x, subject=of, state="amber", why=NOT_CHECKED, sentence=y) for x, of, y in open_]
    return sorted(found, key=lambda check: STATES.index(check.state))


def uncoloured(plan: Plan, shapes: Shapes) -> list[Check]:
    """Return the checks without a colour, because no part has their quantity or the effect is not modelled."""
    quantities = {x.quantity for x in plan.limits}
    none = [first for first, *more in LISTED if not quantities & {first, *more}] if shapes.hooks else []
    found = [Check(quantity=x, subject="all", state="none", sentence=f"{x}: nothing of that kind") for x in none]
    each = (f"{NOT_MODELLED}: {what}" for what in shapes.not_modelled)
    return found + [Check(quantity=SCOPE, subject="all", state="none", why=NOT_MODELLED, sentence=x) for x in each]


def sea_of(plan: Plan) -> str:
    """Return a sentence about a plan's irregular waves, with the number of their components; "" without such waves."""
    of = [m.system for m in plan.machines]
    moved = [getattr(force, "signal", None) for x in of for force in x.forces] + [x for y in of for x in y.drives]
    n = len({w for x in moved if x and x.waves for w in x.waves.frequencies})
    return f"an irregular sea of {n} components at random frequencies, without a repeat time" if n else ""


def _factored(plan: Plan) -> bool:
    return any(limit.factors or limit.quantity == "factor" for limit in plan.limits)


def _of_limit(plan: Plan, use: Use, errors: Errors | None) -> Check:
    limit, met, use = use.limit, use, use.at_worst
    stated = limit.quantity == "wind" and limit.rest is not None and limit.rest.value == use.value
    exact = stated or limit.quantity == IN_WIND or use.source.startswith(ORDERED)
    error = 0.0 if errors is None or exact else error_of(use, errors)
    state, why, message = _state_of(use, error, plan.accepts_assumed, at_rest=errors is None)
    where = limit.where
    warned = limit.warning is not None and (use.value or 0.0) > limit.warning and state in ("green", "amber")
    if state == "red" or warned:
        message, why = sentence(use, ran=errors is not None), "" if state == "red" else WARNED
        message += f", at the worst of {limit.inputs}" if use is not met else ""
        where = (use.action and plan.actions[use.action - 1].where) or where
    inputs = f"at the worst of {limit.inputs}" if use is not met else ""
    basis = "; ".join(part for part in (limit.source, limit.note, use.source, inputs) if part)
    value = shown(limit, met.value) + (f", at worst {shown(limit, use.value)}" if inputs else "")
    return Check(
        quantity=limit.quantity, subject=limit.subject, state=state, why=why, value=use.value, unit=limit.unit,
        limit=bound(use) if limit.known and use.value is not None else limit.value, use=use.use, error=error, t=use.t,
        stage=use.stage, basis=basis, where=where, shown=value, allowed=allowed(use), sentence=message,
    )  # fmt: skip


def _state_of(use: Use, error: float | None, accepted: bool, *, at_rest: bool) -> tuple[State, str, str]:
    """Return the state of a limit's check, the reason if the state is amber, and a sentence for the reader. `error`:
    error estimate of the value in its unit; `accepted`: whether the scene accepts assumed limits."""
    limit = use.limit
    name = name_of(limit)
    absent = limit.quantity in ABSENT and not limit.elements and not limit.rest
    if absent or not limit.known:
        message = f"{name}: {limit.note or 'no limit is known'}"
        return ("none", "", message) if absent else ("amber", NOT_CHECKED, message)
    if use.value is None and at_rest:
        return "none", IN_A_RUN, f"{name}: a run checks it"
    if use.value is None and use.missing:
        return "amber", NOT_CHECKED, f"{name}: the recording lacks what it is computed from; run the scene again"
    if use.value is None:
        return "none", "", f"{name}: it did not occur"
    if use.beyond and (error is None or use.excess > error):
        return "red", "", ""
    if error is None:
        return "amber", UNKNOWN, f"{name}: the error of its value was not measured"
    if use.excess > -error and error > ROUNDING * abs(use.value):
        needed = abs(use.excess / use.value) if use.value else 0.0
        message = f"{name}, {shown(limit, use.value)}, is accurate to {100.0 * error / abs(use.value or 1.0):.2g} %"
        return "undecided", "", f"{message}; an accuracy of {100.0 * needed:.2g} % would decide"
    if "assumed" in f"{limit.source} {limit.note}" and not accepted:
        return "amber", ASSUMED, f"{name}: a limit that heavylift assumes; confirm it, or write 'assumed: accept'"
    return "green", "", ""


def error_of(use: Use, errors: Errors) -> float | None:
    """Return the error estimate of the value of a `Use`, in the unit of its limit; None if the error is unknown.

    A measured error of the utilisation has precedence; otherwise, for a load carried by ropes, the errors of the rope
    tensions count."""
    limit, value = use.limit, abs(use.value or 0.0)
    if limit.quantity == "clearance" and "smallest clearance" in errors:
        return errors["smallest clearance"] * max(NEAR, value)
    measured = errors.get(f"use of {limit.subject} {limit.quantity}")
    if measured is None or use.use is None:
        ropes = [errors.get(f"peak tension {name}") for name in limit.elements]
        known = [e for e in ropes if e is not None]
        return max(known) * value if known and len(known) == len(ropes) and limit.unit in ("N", "kg") else None
    share = measured * max(1.0, use.use)
    if limit.between is not None:
        return share * (limit.between[1] - limit.between[0]) / 2.0
    return share * value / use.use if use.use else share * abs(bound(use))


def state_of(checks: Iterable[Check]) -> State:
    """Return the worst state of the checks, ignoring those without a colour; amber if none is left."""
    return min((c.state for c in checks if c.state != "none"), key=STATES.index, default="amber")


def line_of(checks: Sequence[Check]) -> str:
    """Return the verdict as one line: the worst state, the number of checks in each state, the worst check."""
    n = {state: sum(c.state == state for c in checks) for state in STATES}
    counts = [f"{n['green']} passed", f"{n['red']} red", f"{n['undecided']} undecided"]
    for why in COUNTED:
        if (many := sum(c.why == why and c.state == "amber" for c in checks)) or why in (NOT_CHECKED, ASSUMED):
            counts.append(f"{many} {why}{'s' * (why == WARNED and many > 1)}")
    for why in UNCOLOURED:
        counts += [f"{many} {why}"] if (many := sum(c.why == why for c in checks)) else []
    # what has no utilisation is a finding, such as a contact: worse than any load
    wrong = [c for c in checks if c.state in ("red", "undecided")]
    first = min(wrong, key=lambda c: (STATES.index(c.state), -inf if c.use is None else -round(c.use, 3)), default=None)
    worst = first.sentence if first else ""
    message = "" if any(c.basis for c in checks) else "; the scene has no limits to check: write 'limits'"
    message = f"; worst: {worst}" if worst else message
    return f"{state_of(checks).upper()}: {', '.join(counts)}{message}"


def table_of(checks: Sequence[Check], *notes: str, title: str = "Checks", every: bool = False) -> Table:
    """Return the table of checks, worst first. It shows only the subject with the highest utilisation for each quantity
    and state, or all subjects if `every` is true."""
    groups: dict[object, list[Check]] = {}
    for number, check in enumerate(checks):
        alone = every or check.quantity in ("factor", SCOPE)
        alike = (check.state, check.why, check.quantity, check.allowed if check.why else "")
        key: tuple[object, ...] = (number,) if alone else alike
        groups.setdefault(key, []).append(check)
    table = words(title, HEAD, map(_row, groups.values()), *notes)
    return replace(table, numbers=numbers_of(title, checks))


def _row(group: list[Check]) -> tuple[Cell, ...]:
    sizes = [_size(check) for check in group]
    most = max(sizes)
    least = most - SAME * abs(most) if isfinite(most) else most  # beyond a chart nothing may hang: infinite
    worst = next(check for check, size in zip(group, sizes, strict=True) if size >= least)
    many = len({check.subject for check in group})
    subject = worst.subject if many == 1 else f"{worst.subject} (of {many})"
    at = ", ".join(part for part in (clock(worst.t, 1) if worst.t else "", worst.stage) if part)
    state: Cell = worst.why if worst.state == "none" else Marked(worst.word, worst.state)
    used = "" if worst.use is None or worst.between else percent(worst.use)
    basis = worst.sentence.partition(": ")[2] if worst.state == "none" else worst.basis or worst.sentence
    return state, worst.quantity, subject, worst.shown, at, worst.allowed, used, basis


def _depth(check: Check) -> float:
    """Return the penetration [m] of a forbidden contact, at least 1 cm; 0 for all other checks."""
    touches = check.state == "red" and check.quantity == "clearance" and (check.value or 0.0) <= TOUCH
    return max(TOUCH, round(-(check.value or 0.0), 2)) if touches else 0.0


def _size(check: Check) -> float:
    """Return the number by which checks of the same kind are compared: the utilisation, or else the value; the
    smallest clearance is the worst."""
    value = -(check.value or 0.0) if check.quantity == "clearance" else check.value or 0.0
    if abs(value) < NOISE.get(check.unit, 0.0):
        return 0.0
    return value if check.use is None else check.use


def governing(checks: Sequence[Check]) -> list[str]:
    """Return a line of text for each quantity, on its check with the highest utilisation; loads come first."""
    found: dict[str, Check] = {}
    if any(check.state == "red" and check.use is None for check in checks):
        return []  # what has no utilisation, such as a contact, governs
    for check in sorted(checks, key=lambda c: (not c.load, -(c.use or 0.0))):
        if check.use and not check.between:
            found.setdefault(check.quantity, check)
    lines = []
    for check in [*found.values()][:GOVERNING]:
        at = ", ".join(part for part in (f"at {clock(check.t)}" if check.t else "", check.stage) if part)
        used = f"utilisation {percent(check.use or 0.0)}, limit {check.allowed}"
        lines.append(f"governs: {check.quantity} of {check.subject}, {check.shown}: {used}{f' ({at})' if at else ''}")
    return lines


def open_checks(checks: Sequence[Check]) -> list[str]:
    """Return one line of text for each kind of undecided or amber check, with the input that would decide it."""
    kinds: dict[str, list[Check]] = {}
    for check in checks:
        if check.state in ("undecided", "amber") and check.why != WARNED:
            kinds.setdefault(check.word, []).append(check)
    lines = []
    for kind, some in kinds.items():
        if kind in REMEDY:
            lines.append(f"{kind}: {', '.join(dict.fromkeys(check.quantity for check in some))}{REMEDY[kind]}")
            continue
        alike: dict[str, list[Check]] = {}
        for check in some:
            alike.setdefault(check.quantity, []).append(check)
        for first, *more in alike.values():
            lines.append(f"{kind}: {first.sentence}{f'; likewise {len(more)} more' if more else ''}")
    return lines


def scope(checks: Iterable[Check]) -> list[str]:
    """Return one line that lists the effects that are not modelled and are in no check; empty if there are none."""
    each = [x.sentence.partition(": ")[2] for x in checks if x.why == NOT_MODELLED]
    return [f"{NOT_MODELLED}: {'; '.join(each)}"] if each else []


def likewise(found: Iterable[Check]) -> list[Check]:
    """Merge findings that have the same quantity, limit and stage into one finding that names all subjects."""
    groups: dict[object, list[Check]] = {}
    for x in found:
        groups.setdefault((x.word, x.quantity, x.limit, x.unit, x.stage), []).append(x)
    return [_together(group) for group in groups.values()]


def _together(group: list[Check]) -> Check:
    first = max(group, key=_depth)
    others = list(dict.fromkeys(x.subject for x in group if x.subject != first.subject))
    return replace(first, sentence=f"{first.sentence}; likewise {', '.join(others)}") if others else first
