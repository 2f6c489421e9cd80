"""Data of the checks of a lift, before and after a run, and of the notes of a run, shared by all packages.

A note belongs to one simulation time, as a sample does; its text does not depend on how a run is divided into calls.
"""

from collections.abc import Iterable
from typing import Any, Literal, NamedTuple, TypeAlias

import msgspec

State: TypeAlias = Literal["red", "undecided", "amber", "green", "none"]  # of a check, worst first
STATES: tuple[State, ...] = ("red", "undecided", "amber", "green", "none")
NOT_CHECKED, ASSUMED, UNKNOWN = "not checked", "assumed", "error unknown"  # kinds of amber
IN_A_RUN = "in a run"  # a row without colour: nothing is known of it at rest
RESTLESS = "finds no rest"  # a body, in the error of an equilibrium that is not found
WARNED, NOTED = "warning", "note"  # what was found besides limits
NOT_MODELLED = "not modelled"  # kind of the rows of what no check includes
LOADS = ("N", "kg", "N m", "Pa")  # units of values that grow with what is lifted


class Note(NamedTuple):
    """A message about a run, with its simulation time [ns]."""

    t_ns: int
    sentence: str


UNITS = (1, 10, 100, 1000)  # in a second, by the digits behind it


class Check(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """A row of the list of checks: quantity, subject, worst value and limit [unit], error of the value, state.

    Error None: unknown; `why`: the reason for amber, or the kind of finding if no limit is involved. `shown`,
    `allowed`: value and limit as text for people; `basis`: source of the limit; `sentence`: what was found, or what
    must be stated for the row to turn green.
    """

    quantity: str
    subject: str
    state: State
    why: str = ""
    value: float | None = None
    limit: float | None = None
    unit: str = ""
    use: float | None = None
    error: float | None = None
    t: float | None = None
    stage: str = ""
    basis: str = ""
    where: str = ""
    shown: str = ""
    allowed: str = ""
    sentence: str = ""

    @property
    def word(self) -> str:
        """The state of the check as a word, such as red; for amber, the reason."""
        return self.why or self.state

    @property
    def between(self) -> bool:
        """Whether the checked value must lie between a lower and an upper limit, so that no utilisation is defined."""
        return " to " in self.allowed

    @property
    def load(self) -> bool:
        """Whether the checked value is a load, moment or pressure, which can govern a lift."""
        return self.unit in LOADS or self.quantity in ("rope factor", "uplift")

    @property
    def found(self) -> bool:
        """Whether the check reports a finding: a limit exceeded, a warning, or a note."""
        return self.state == "red" or self.why in (WARNED, NOTED)

    @property
    def message(self) -> str:
        """The sentence of the check with time, stage and the key to change."""
        at = f", at {clock(self.t)}" if self.t is not None else ""
        stage = f" ({self.stage})" if self.stage else ""
        return f"{self.sentence}{at}{stage}" + (f" [{self.where}]" if self.where else "")


def finding(state: State, quantity: str, subject: str, sentence: str, **more: Any) -> Check:
    """Return a check for a finding without a limit: red, amber with a warning, or a note without colour."""
    why = {"amber": WARNED, "none": NOTED}.get(state, "")
    return Check(quantity=quantity, subject=subject, state=state, sentence=sentence, **{"why": why} | more)


def findings(checks: Iterable[Check]) -> tuple[Check, ...]:
    """Return the checks that report a finding: red ones, then warnings, then notes, each sorted by time (to 0.01 s)."""
    order = ("", WARNED, NOTED)
    return tuple(
        sorted(
            (x for x in checks if x.found),
            key=lambda x: (order.index("" if x.state == "red" else x.why), round(x.t or 0.0, 2), x.quantity, x.subject),
        )
    )


def clock(seconds: float, digits: int = 0) -> str:
    """Return a simulation time as text, such as 1:02 or 1:06:04; `digits`: decimals of the second, 1:02.5 with one."""
    unit = UNITS[digits]
    minutes, rest = divmod(round(seconds * unit), 60 * unit)
    hours, minutes = divmod(minutes, 60)
    message = f"{rest / unit:0{3 + digits if digits else 2}.{digits}f}"
    return f"{hours}:{minutes:02}:{message}" if hours else f"{minutes}:{message}"
