"""The state of the lift as the commander knows it from reports."""

from __future__ import annotations

from dataclasses import dataclass, field

from heavylift.nodes.models.parts import messages as m

OFF = "unhooked"


@dataclass
class ObservedState:
    """Observed ropes (taut, slack, unhooked), supported bodies, and thresholds."""

    ropes: dict[str, str] = field(default_factory=dict)
    bodies: dict[str, tuple[str, ...]] = field(default_factory=dict)  # bodies with supports, by model
    grounded: set[str] = field(default_factory=set)  # bodies that a support touches
    landed: set[str] = field(default_factory=set)  # bodies that stand on a whole face
    reached: set[str] = field(default_factory=set)  # thresholds
    parted: set[str] = field(default_factory=set)  # slings and ropes that broke
    tripped: set[str] = field(default_factory=set)  # interlocks
    begun: set[str] = field(default_factory=set)  # lifts whose lists the whole scene's has begun
    ended: set[str] = field(default_factory=set)  # lifts whose lists are done

    def on_ground(self, model: str) -> bool:
        """Whether a support touches a body of this model."""
        return any(body in self.grounded for body in self.bodies.get(model, ()))

    def note(self, report: m.Report) -> None:
        """Update the state by a report."""
        actor = report.actor
        match report:
            case m.RopeState():
                if self.ropes[actor] != OFF:
                    self.ropes[actor] = report.state
            case m.Hooked():
                self.ropes[actor] = "slack"
            case m.Unhooked():
                self.ropes[actor] = OFF
            case m.Touched():
                self.grounded.add(actor)
            case m.Landed():
                self.landed.add(actor)
            case m.Lifted():
                self.grounded.discard(actor)
                self.landed.discard(actor)
            case m.Reached():
                self.reached.add(actor)
            case m.Begun():
                self.begun.add(actor)
            case m.Ended():
                self.ended.add(actor)
            case m.Tripped():
                self.tripped = self.tripped | {actor} if report.over else self.tripped - {actor}
