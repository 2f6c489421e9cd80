"""An implicit method without solution up to the instant at which a rope tightens takes shorter steps and continues."""

from itertools import count
from random import Random

import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.description import Body, Joint, Line, Point, Rope, System
from heavylift.kernel.simulation import Integrator
from small_scenes import SECOND, G, cube, hand_over, started

IMPLICIT = {"radau5": 1e-5}


def falling(seed: int) -> System:
    """One to four bodies beneath each other, the last the heaviest, on ropes slack or stretched at random."""
    r = Random(seed)
    load, EA, length = r.uniform(1e3, 5e4), 10 ** r.uniform(7.0, 9.5), r.uniform(2.0, 20.0)
    n, z, above = r.randint(1, 4), 0.0, "world"
    bodies, joints, ropes = [], [], []
    for i in range(n):
        z -= length / n * r.uniform(0.3, 1.2)
        mass = load if i == n - 1 else load * 10 ** r.uniform(-3.0, -0.5)
        bodies.append(Body(f"b{i}", mass, inertia=cube(mass, 1.0)))
        joints.append(Joint(f"b{i}", "free", "world", f"b{i}", q0=(r.uniform(-1.0, 1.0), 0.0, z, 0.0, 0.0, 0.0, 1.0)))
        line = Line(Point(above), Point(f"b{i}"))
        ropes.append(Rope(f"r{i}", (line,), EA, length / n, damping=EA * r.choice([0.0, 0.001, 0.01])))
        above = f"b{i}"
    return System(tuple(bodies), tuple(joints), ropes=tuple(ropes), gravity=G)


def counted(monkeypatch, refused=lambda: False) -> list[bool]:
    """What becomes of each step to an event; `refused`: whether it has no solution whatever the method says."""
    forced, solved, message = Integrator.forced, Integrator._solved, []

    def seen(self, t):
        message.append(forced(self, t))
        return message[-1]

    monkeypatch.setattr(Integrator, "forced", seen)
    monkeypatch.setattr(Integrator, "_solved", lambda self, t: not refused() and solved(self, t))
    return message


def first_events(method: str, tolerance: float) -> list[int]:
    """When ropes first come taut or slack [ns]."""
    s = started(falling(1), method=method, tolerance=tolerance)
    hand_over(s, SECOND // 2)
    return [t for t, _ in s.log][:4]


@pytest.mark.parametrize("method", IMPLICIT)
@pytest.mark.large(beyond=2)
def test_if_an_implicit_method_cannot_solve_a_step_to_an_event_it_tries_shorter_steps(method, monkeypatch):
    """Whatever the method: of eight attempts three are refused, and no event is lost."""
    times, refusals = first_events(method, IMPLICIT[method]), count()
    message = counted(monkeypatch, lambda: next(refusals) % 8 < 3)
    assert first_events(method, IMPLICIT[method]) == pytest.approx(times, rel=1e-3)
    assert message.count(False) > 0


def test_an_implicit_integration_step_without_a_solution_ends_the_run_with_a_one_sentence_error(monkeypatch):
    counted(monkeypatch, lambda: True)
    with pytest.raises(KernelError, match="method 'radau5' finds no solution of its equations"):
        hand_over(started(falling(1), method="radau5"), 2 * SECOND)
