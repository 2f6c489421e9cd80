"""Uses of limits as sentences for planners: one row of `WORDS` per quantity, and how its values are written."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import degrees

from heavylift.nodes.plan.limit import TOUCHING, RatedLimit, Use
from heavylift.nodes.plan.spellings import BEAM_LOAD

NOISE = {
    "N": 1.0,
    "Pa": 1.0,
    "kg": 0.1,
    "rad": 1e-6,
    "m": 1e-6,
}  # by unit: values below it, and differences, are rounding


@dataclass(frozen=True)
class Words:
    """Wording of a quantity; `refused`: a scene beyond this limit at rest cannot be run."""

    kind: str
    sentence: Callable[[Use, bool], str]
    refused: bool = False


def percent(use: float) -> str:
    """Utilisation in per cent, with enough digits to show on which side of 100 % it is."""
    return f"{100 * use:.0f} %" if abs(use - 1.0) >= 5e-3 or abs(use - 1.0) < 5e-5 else f"{100 * use:.2f} %"


def shown(limit: RatedLimit, value: float | None) -> str:
    """A value of a limit's quantity for people."""
    if value is None:
        return ""
    match limit.unit:
        case "kg":
            return f"{value / 1e3:.1f} t"
        case "N":
            value = value if abs(value) >= NOISE[limit.unit] else 0.0
            return f"{value / 1e3:.4g} kN" if abs(value) < 1e6 else f"{value / 1e3:.0f} kN"
        case "Pa":
            return f"{value / 1e3:.0f} kPa"
        case "rad":
            return f"{degrees(value):.2f} deg"
        case "m":
            return f"{value:.2f} m"
        case "" if limit.quantity in ("signal", "uplift", "interlock"):
            return percent(value)
    if limit.quantity in TOUCHING:
        return f"{60.0 * value:.3g} m/min"
    return f"{value:.2f} {limit.unit}".strip()


def bound(use: Use) -> float:
    """The limit of a use; of two limits the one on its side."""
    limit = use.limit
    if limit.between is not None and use.value is not None:
        low, high = limit.between
        return low if use.value < (low + high) / 2.0 else high
    return use.bound if use.bound is not None else limit.at()


# sentences: `ran` says that it happened


def _carries(who: Callable[[str], str]) -> Callable[[Use, bool], str]:
    def sentence(use: Use, ran: bool) -> str:
        verb = "carried" if ran else "would carry"
        message = f"{who(use.limit.subject)} {verb} {(use.value or 0.0) / 1e3:.1f} t of {bound(use) / 1e3:g} t"
        return f"{message}, {use.limit.note}" if use.limit.note else message

    return sentence


def _trolley(subject: str) -> str:
    crane, which = subject.rsplit(" ", 1)
    return f"the {which.removesuffix('trolley')} trolley of {crane}".replace("  ", " ")


def _beam(use: Use, ran: bool) -> str:
    verb = "carried" if ran else "would carry"
    return f"the slings of {use.limit.subject} {verb} {shown(use.limit, use.value)} of {shown(use.limit, bound(use))}"


def _sling(use: Use, ran: bool) -> str:
    limit, value = use.limit, use.value or 0.0
    verb, much = "was" if ran else "would be", f"{percent(use.use or 0.0)} of its limit"
    message = f"the tension of the sling {limit.subject} {verb} {value / 1e3:.0f} kN, {much}"
    message = f"{message}: {limit.breaking / value:.2f} times below its breaking force"
    return f"{message}, {limit.factor:g} are needed ({limit.source})"


def _legs_together(use: Use, ran: bool) -> str:
    message = f"the slings of {use.limit.subject} {'carried' if ran else 'would carry'} {shown(use.limit, use.value)}"
    most = f"of {shown(use.limit, bound(use))} together" if bound(use) else "at an angle for which they are not rated"
    return f"{message} {most} ({use.limit.source})"


def _lands(use: Use, ran: bool) -> str:
    limit, verb = use.limit, "pressed" if ran else "would press"
    times = (use.value or 0.0) * limit.factor / bound(use)
    message = f"{limit.subject} {verb} on its supports with {shown(limit, use.value)}, {times:.1f} times its weight"
    return f"{message}; {limit.factor:g} times are allowed ({limit.source.partition(':')[0]})"


def _line(use: Use, ran: bool) -> str:
    verb, limit = "carried" if ran else "would carry", use.limit
    message = f"the rope {limit.subject} {verb} {shown(limit, use.value)}, {percent(use.use or 0.0)} of its limit"
    return f"{message} of {shown(limit, bound(use))} ({limit.source})"


def _rope(use: Use, ran: bool) -> str:
    limit, value = use.limit, use.value or 1.0
    pull = limit.breaking / value / 1e3
    message = f"the rope {limit.subject} {'had' if ran else 'has'} too little safety: its most loaded part"
    message += f" {'carried' if ran else 'carries'} {pull:.1f} kN, {value:.2f} times below its breaking force"
    return f"{message}, {limit.at():g} are needed ({limit.note})"


def _peak(use: Use, ran: bool) -> str:
    limit, value = use.limit, use.value or 0.0
    message = f"the largest tension of {limit.subject}, {value / 1e3:.0f} kN, is beyond {bound(use) / 1e3:.0f} kN"
    return f"{message}: breaking force over the partial factors of {limit.factor:.3g} ({limit.source})"


def _drum(use: Use, ran: bool) -> str:
    limit = use.limit
    verb = "pulled" if ran else "would pull"
    message = f"the rope {limit.subject} {verb} {shown(limit, use.value)} at its drum"
    return f"{message}, which may pull {shown(limit, bound(use))}"


def _leads(way: str) -> Callable[[Use, bool], str]:
    def sentence(use: Use, ran: bool) -> str:
        limit, verb = use.limit, "led" if ran else "would lead"
        message = f"the rope {limit.subject} {verb} {degrees(use.value or 0.0):.1f} degrees off the vertical{way}"
        return f"{message}, {degrees(bound(use)):g} degrees are allowed ({limit.source})"

    return sentence


def _legs(use: Use, ran: bool) -> str:
    limit, verb = use.limit, "stood" if ran else "would stand"
    most = bound(use) if use.beyond else limit.warning or 0.0
    message = f"the sling {limit.subject} {verb} {degrees(use.value or 0.0):.1f} degrees off the vertical"
    return f"{message}, more than {degrees(most):g} degrees ({limit.source})"


def _pushed(use: Use, ran: bool) -> str:
    limit, verb = use.limit, "pulled" if ran else "would pull"
    what = "rails" if limit.over == "along" else "girder"
    message = f"the ropes {verb} {limit.subject} along its {what} with {shown(limit, use.value)}"
    return f"{message}, {limit.note} {shown(limit, bound(use))}"


def _high(use: Use, ran: bool) -> str:
    message = f"the hook {use.limit.subject} {'was' if ran else 'would be'} at z = {use.value:.2f} m"
    return f"{message}, its upper limit is {bound(use):g} m"


def _long(use: Use, ran: bool) -> str:
    low, high = use.limit.between or (0.0, 0.0)
    rope, length, would = use.limit.subject, use.value or 0.0, "was" if ran else "would be"
    if length < (low + high) / 2:
        return f"the rope {rope} {would} wound to {length:g} m, its minimum is {low:g} m"
    return f"the rope {rope} {would} {length:g} m long, its drum holds {high:g} m"


def _ends(what: str, axis: str) -> Callable[[Use, bool], str]:
    def sentence(use: Use, ran: bool) -> str:
        return past_the_end(use.limit.subject, axis, use.value or 0.0, what, use.limit.between or (0.0, 0.0))

    return sentence


def past_the_end(subject: str, axis: str, at: float, what: str, between: tuple[float, float]) -> str:
    """Sentence for a crane or trolley beyond the end of its rails or girder [m]."""
    who = _trolley(subject) if " " in subject else subject
    return f"{who} at {axis} = {at:g} m is past the end of its {what}, {between[0]:g} to {between[1]:g} m"


def _blown(use: Use, ran: bool) -> str:
    verb = "was" if ran else "would be"
    return f"the wind {verb} {shown(use.limit, use.value)}, lifting is allowed up to {shown(use.limit, bound(use))}"


def _pressed(use: Use, ran: bool) -> str:
    verb = "pressed" if ran else "would press"
    message = f"{use.limit.subject} {verb} on the ground with {shown(use.limit, use.value)}"
    return f"{message}, {shown(use.limit, bound(use))} are allowed"


def _touches(use: Use, ran: bool) -> str:
    verb = "moved" if ran else "would move"
    message = f"hooks {verb} with {shown(use.limit, use.value)} as {use.limit.subject} lifts off or lands"
    return f"{message}, up to {shown(use.limit, bound(use))} is allowed ({use.limit.source})"


def _trips(use: Use, ran: bool) -> str:
    verb = "came" if ran else "would come"
    message = f"the interlock {use.limit.subject} {verb} to {shown(use.limit, use.value)}"
    return f"{message}, it trips at {shown(use.limit, bound(use))}"


def _lifted(use: Use, ran: bool) -> str:
    verb = "came" if ran else "would come"
    return f"{use.limit.subject} {verb} {shown(use.limit, use.value)} of the way to where it tips ({use.limit.note})"


def _designed(use: Use, ran: bool) -> str:
    limit = use.limit
    part, factors = limit.quantity.partition(" ")[0], " x ".join(f"{x.name} {x.value:.4g}" for x in limit.factors)
    message = f"the design load of the {part} {limit.subject}, {shown(limit, use.value)}, is beyond"
    return f"{message} {shown(limit, bound(use))}: {shown(limit, limit.rest.value if limit.rest else None)} x {factors}"


def _measured(use: Use, ran: bool) -> str:
    limit, verb = use.limit, "was" if ran else "would be"
    most = "at least" if limit.least else "at most"
    return f"{limit.subject} {verb} {shown(limit, use.value)}, {most} {shown(limit, bound(use))} is allowed"


WORDS: dict[str, Words] = {
    "hook load": Words("overload", _carries(lambda hook: f"the hook {hook}"), refused=True),
    "trolley load": Words("overload", _carries(_trolley), refused=True),
    "crane load": Words("overload", _carries(str), refused=True),
    "tandem load": Words("overload", _carries(str), refused=True),
    BEAM_LOAD: Words("overload", _beam),
    "frame load": Words("overload", _carries(str), refused=True),
    "shackle load": Words("overload", _carries(lambda sling: f"each shackle of {sling}"), refused=True),
    "assembly load": Words("overload", _legs_together),
    "lug load": Words("overload", _carries(lambda lug: f"the lug {lug}"), refused=True),
    "support load": Words("overload", _carries(lambda block: f"a support of {block}")),
    "impact": Words("impact", _lands),
    "sling tension": Words("overload", _sling, refused=True),
    "sling peak": Words("overload", _peak),
    "rope tension": Words("overload", _line, refused=True),
    "rope factor": Words("overload", _rope, refused=True),
    "rope peak": Words("overload", _peak),
    "drum pull": Words("overload", _drum, refused=True),
    "off-lead": Words("off-lead", _leads("")),
    "off-lead along": Words("off-lead", _leads(" along the rails")),
    "off-lead across": Words("off-lead", _leads(" across the rails")),
    "bridle angle": Words("bridle", _legs),
    "side force": Words("side force", _pushed),
    "hook height": Words("two-blocked", _high, refused=True),
    "rope length": Words("drum", _long, refused=True),
    "rails": Words("end", _ends("rails", "x"), refused=True),
    "girder": Words("end", _ends("girder", "y"), refused=True),
    "wind": Words("wind", _blown),
    **{f"{part} design load": Words("design load", _designed) for part in ("hook", "sling", "shackle", "lug")},
    "signal": Words("signal", _measured),
    "interlock": Words("interlock", _trips),
    **dict.fromkeys(TOUCHING, Words("speed", _touches)),
    "ground pressure": Words("ground", _pressed),
    "wheel load": Words("overload", _carries(lambda corner: f"a wheel at {corner}")),
    "uplift": Words("uplift", _lifted),
}
