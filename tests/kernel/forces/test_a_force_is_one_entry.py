"""The recipe for a force: a description and a law, one entry of the force table; an eddy-current brake slows a disc."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from heavylift.kernel.description import Body, Element, Joint, System, field_types, mechanics
from heavylift.kernel.forces import FORCES, ForceLaw, LawOutput, Poses, SampledQuantity
from small_scenes import SECOND, column, hand_over, started

LARGEST, CRITICAL, INERTIA, BEGINS = 400.0, 12.0, 80.0, 30.0  # [N m], [rad/s], [kg m2], [rad/s]
CLOSE = 1e-9  # relative, at a step tolerance of 1e-11


class EddyBrake(Element, frozen=True, tag=True):
    """Eddy-current brake on a joint: torque 2 T u/(1 + u^2), u = speed over the critical speed (Wouterse 1991)."""

    name: str
    joint: str
    largest: float  # torque [N m], at the critical speed
    critical: float  # speed [rad/s]


class EddyBrakeLaw(ForceLaw):
    def numbers(self, f: EddyBrake, poses: Poses) -> list[float]:
        return [f.largest, f.critical]

    def answer(self, f: EddyBrake, p: Any, ends: list[Any], signal: Any, joint: Any, t: Any) -> LawOutput:
        u = joint[1] / p[1]
        torque = 2.0 * p[0] * u / (1.0 + u * u)
        return LawOutput(effort=-torque, heat=torque * joint[1], shown=[torque])

    def shows(self, f: EddyBrake) -> list[SampledQuantity]:
        return [("eddy/torque", f.name, "N m")]


@pytest.fixture(autouse=True)
def _eddy_brake(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setattr(mechanics, "Force", mechanics.Force | EddyBrake)
    monkeypatch.setitem(FORCES, EddyBrake, EddyBrakeLaw())
    field_types._hints.cache_clear()
    yield
    field_types._hints.cache_clear()


def test_a_rotating_disc_with_eddy_current_brake_slows_as_the_closed_form_says() -> None:
    """ln(u0/u) + (u0^2 - u^2)/2 = 2 T t/(I w0)."""
    disc = Body("disc", 100.0, inertia=tuple(tuple(INERTIA * (i == j) for j in range(3)) for i in range(3)))
    hinge = Joint("hinge", "revolute", "world", "disc", v0=(BEGINS,))
    s = started(System((disc,), (hinge,), forces=(EddyBrake("brake", "hinge", LARGEST, CRITICAL),)), tolerance=1e-11)
    hand_over(s, 3 * SECOND)
    s.settle()
    times, speed = column(s, "joint/velocity")
    u, u0 = speed[:, 0] / CRITICAL, BEGINS / CRITICAL
    want = 2.0 * LARGEST * times / (INERTIA * CRITICAL)
    assert np.log(u0 / u) + 0.5 * (u0 * u0 - u * u) == pytest.approx(want, rel=CLOSE, abs=CLOSE)
    shown = column(s, "eddy/torque")[1][:, 0]
    assert shown == pytest.approx(2.0 * LARGEST * u / (1.0 + u * u), rel=CLOSE)
