"""Sentences for planners about the utilisation of limits, and the text form of values of every quantity."""

from math import degrees, inf

from heavylift.nodes.plan.limit import TOUCHING, Quantity, RatedLimit, Use

NOISE = {
    "N": 1.0,
    "N m": 10.0,
    "Pa": 1.0,
    "kg": 0.1,
    "rad": 1e-6,
    "m": 1e-6,
}  # by unit: values below it, and differences, are rounding
NOUNS: dict[Quantity, str] = {
    "rails": "place on its rails",
    "girder": "place on its girder",
    "uplift": "way to tipping",
}
REFUSED: tuple[Quantity, ...] = (  # a scene beyond them at rest cannot be run
    "hook load", "trolley load", "crane load", "tandem load", "frame load", "shackle load", "lug load", "sling tension",
    "rope tension", "rope factor", "drum pull", "hook height", "rope length", "rails", "girder",
)  # fmt: skip


def percent(use: float) -> str:
    """Return the utilisation in per cent as text, with enough digits to show on which side of 100 % it lies."""
    if use == inf:
        return "infinite"
    return f"{100 * use:.0f} %" if abs(use - 1.0) >= 5e-3 or abs(use - 1.0) < 5e-5 else f"{100 * use:.2f} %"


def shown(limit: RatedLimit, value: float | None) -> str:
    """Return a value as text, in the unit in which messages show the quantity of the limit."""
    if value is None:
        return ""
    match limit.unit:
        case "kg":
            return f"{value / 1e3:.1f} t"
        case "N" | "N m":
            value = value if abs(value) >= NOISE[limit.unit] else 0.0
            return f"{value / 1e3:.4g} k{limit.unit}" if abs(value) < 1e6 else f"{value / 1e3:.0f} k{limit.unit}"
        case "Pa":
            return f"{value / 1e3:.0f} kPa"
        case "rad":
            return f"{degrees(value):.2f} deg"
        case "m":
            return f"{value:.2f} m"
        case "" if limit.quantity in ("signal", "uplift", "interlock", "slack sling"):
            return percent(value)
    if limit.quantity in TOUCHING:
        return f"{60.0 * value:.3g} m/min"
    return f"{value:.2f} {limit.unit}".strip()


def bound(use: Use) -> float:
    """Return the limit value on which a utilisation is based: of a lower and an upper limit, the nearer one."""
    limit = use.limit
    if limit.between is not None and use.value is not None:
        low, high = limit.between
        return low if use.value < (low + high) / 2.0 else high
    return use.bound if use.bound is not None else limit.at()


def allowed(use: Use) -> str:
    """Return the allowed value or range of a limit as text."""
    limit = use.limit
    if not limit.known:
        return "not known"
    if limit.between is not None:
        return f"{limit.between[0]:.4g} to {limit.between[1]:.4g} {limit.unit}"
    return ("at least " if limit.least else "") + (shown(limit, bound(use)) if use.value is not None else "")


def sentence(use: Use, ran: bool) -> str:
    """Return a sentence about the utilisation of a limit: the value, the allowed value, and the source of the limit.

    The verb is "was" after a run (`ran`), and "would be" otherwise."""
    limit, load = use.limit, use.limit.unit in ("N", "kg")
    used = f", {percent(use.use or 0.0)}" if load and bound(use) else ""
    most = allowed(use) if bound(use) or not load else f"no load at that {limit.over or 'place'}"
    if not use.beyond and limit.warning is not None:
        most = f"more than {shown(limit, limit.warning)} needs a closer look"
    else:
        most = f"{most} is {'needed' if limit.least else 'allowed'}"
    at_rest = (
        limit.factors
        and limit.rest
        and " x ".join((shown(limit, limit.rest.value), *(f"{x.name} {x.value:.4g}" for x in limit.factors)))
    )
    basis = "; ".join(part for part in (limit.source, limit.note, use.source, at_rest) if part)
    message = f"{name_of(limit)} {'was' if ran else 'would be'} {shown(limit, use.value)}{used}"
    return f"{message}; {most}{f' ({basis})' if basis else ''}"


def name_of(limit: RatedLimit) -> str:
    """Return the subject of a limit in words."""
    noun = NOUNS.get(limit.quantity, limit.quantity)
    return limit.subject if noun == "signal" else noun if limit.subject == "all" else f"{noun} of {limit.subject}"
