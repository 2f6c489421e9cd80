"""Flexible bodies beyond small deflections or their buckling load: noted, then refused, in runs and in statics."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.analysis import equilibrium
from heavylift.kernel.description import (
    Beam,
    Body,
    Flexible,
    InputSignal,
    Joint,
    Line,
    Load,
    Nodal,
    Point,
    Rope,
    System,
)
from heavylift.kernel.multibody.flexible import beam_matrices, nodes_of
from small_scenes import SECOND, Y, hand_over, started

L, EI, PER_LENGTH = 10.0, 1e6, 100.0
BEAM = Beam(L, PER_LENGTH, EI_y=EI, EI_z=EI, elements=20)
EULER = pi**2 * EI / (4.0 * L * L)  # of a cantilever [N]
NEAR = 0.02  # part by which the places that are looked at may miss the largest deflection
CLOSE = 5e-3  # part by which loads between nodes move the buckling load
STANDING = ((0.0, 0.0, -1.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0))  # x upwards


def scene(flexible=None, force=(0.0, 0.0, 0.0), at=L, gravity=0.0, moment=(0.0, 0.0, 0.0), **more) -> System:
    body = Body("jib", 0.0, flexible=flexible or Flexible(3, BEAM, damping=1.0, loads=(at,)))
    push = Load("push", Point("jib", (at, 0.0, 0.0)), force, moment, **more)
    return System((body,), (Joint("root", "fixed", "world", "jib"),), forces=(push,), gravity=gravity)


def matrices(beam: Beam, frame: str) -> Flexible:
    """The same beam as a finite-element model."""
    M, K = beam_matrices(beam)
    last = len(M) - 6
    held = {"clamped": (*range(6),), "simply supported": (0, 1, 2, 3, last + 1, last + 2)}[frame]
    stiff = tuple(d for d in range(len(M)) if d % 6 in (0, 3))
    rows = [tuple(map(tuple, x.tolist())) for x in (M, K)]
    nodes = tuple(map(tuple, nodes_of(beam).tolist()))
    return Flexible(4, nodal=Nodal(nodes, *rows, held=tuple(sorted({*held, *stiff}))), damping=1.0)


def told(system: System, statics: bool, seconds: int = 10) -> str:
    """What is said of a scene: nothing, its note, or how it ends."""
    s = started(system, method="radau5", tolerance=1e-6, sample_ns=SECOND // 20)
    try:
        if statics:
            equilibrium(s)
        else:
            hand_over(s, seconds * SECOND)
            s.settle()
    except KernelError as error:
        return f"ends: {error}"
    assert len(s.notes) <= 1
    return s.notes[0].sentence if s.notes else ""


def said(system: System, seconds: int = 10) -> str:
    """The same, in a run and in statics, but for the time and the part that is then reached."""
    run, rest = (told(system, statics, seconds) for statics in (False, True))
    assert bool(run) == bool(rest)
    assert run.startswith("ends") == rest.startswith("ends")
    return run


CASES = [  # frame, place of the load, deflection under a force of one newton
    ("clamped", L, L**3 / (3.0 * EI)),
    ("clamped", 0.5 * L, (0.5 * L) ** 2 * 2.5 * L / (6.0 * EI)),
    ("simply supported", 0.5 * L, L**3 / (48.0 * EI)),
    ("simply supported", 0.3 * L, 0.3 * 0.91**1.5 / (9.0 * 3.0**0.5) * L**3 / EI),  # largest beside the load
]


@pytest.mark.parametrize(("given", "direction"), [("beam", 1.0), ("matrices", -1.0)])
@pytest.mark.parametrize(("frame", "at", "softness"), CASES)
@pytest.mark.large(beyond=2)
def test_a_beam_deflection_gives_a_note_at_5_percent_of_the_length_and_an_error_at_25_percent(
    given, frame, at, softness, direction
):
    def bent(part: float) -> str:
        flexible = matrices(BEAM, frame) if given == "matrices" else None
        flexible = flexible or Flexible(4, BEAM, frame=frame, damping=1.0, loads=(at,))
        return said(scene(flexible, (0.0, 0.0, direction * part * L / softness), at))

    assert bent(0.05 * (1.0 - 2.0 * NEAR)) == ""
    noted = bent(0.05 * (1.0 + 2.0 * NEAR))
    assert noted.startswith("body 'jib' on joint 'root' at ")
    assert "beyond what the theory of small deflections covers well" in noted
    ended = bent(0.25 * (1.0 + 2.0 * NEAR))
    assert ended.startswith("ends: body 'jib' on joint 'root' at ")
    assert "where the theory of small deflections means nothing" in ended


def test_a_deflection_note_appears_once_and_at_one_time_however_time_grants_divide_the_run():
    system = scene(force=(0.0, 0.0, 1800.0))
    whole, cut = (started(system, tolerance=1e-8) for _ in range(2))
    hand_over(whole, 3 * SECOND)
    for n in range(1, 31):
        cut.run(n * SECOND // 10)
    again = started(system, tolerance=1e-8)
    again.restore(cut.snapshot())
    hand_over(again, 3 * SECOND)
    assert len(whole.notes) == 1
    assert whole.notes == cut.notes == again.notes


def test_the_twist_of_a_beam_is_limited_like_its_bending_rotation():
    """GJ theta / L = moment, which turns with the end: 0.225 rad are noted, 1.125 rad refused."""
    GJ, SEEN = 2e5, 8.0 / pi**2 * (1.0 + 1.0 / 9.0)  # what two modes show of the linear twist
    flexible = Flexible(2, Beam(L, PER_LENGTH, GJ=GJ, polar=50.0), damping=1.0)
    for angle, what in ((0.22, ""), (0.24, "degrees within itself, beyond"), (2.0, "means nothing")):
        sentence = said(scene(flexible, moment=(angle * GJ / L / SEEN, 0.0, 0.0)))
        assert what in sentence
        assert bool(sentence) == bool(what)


def test_a_bending_moment_beyond_small_deflections_ends_the_run():
    """100 kN at the tip of 10 m make at most 1000 kN m, however the beam bends: refused long before."""
    assert "means nothing" in said(scene(force=(0.0, 0.0, 1e5)))


def test_a_beam_bent_by_more_than_5_percent_of_its_length_at_the_start_gives_a_note():
    s = started(scene(Flexible(1, BEAM, start=(0.08 * L,))))
    s.run(1)
    assert [n.t_ns for n in s.notes] == [0]


def column(flexible: Flexible, **more) -> System:
    """The same on end: x points up."""
    system = scene(flexible, **more)
    return replace(system, joints=(replace(system.joints[0], R_PJ=STANDING),))


def upright(system: System) -> str:
    """Said within a second."""
    return said(system, seconds=1)


def on_tip(part: float) -> tuple[float, float, float]:
    return (0.0, 0.0, -part * EULER)


@pytest.mark.parametrize("modes", [1, 4])
@pytest.mark.parametrize(("frame", "times"), [("clamped", 1.0), ("simply supported", 4.0)])
@pytest.mark.large(beyond=1)
def test_a_straight_column_beyond_its_euler_load_is_refused(frame, times, modes):
    flexible = Flexible(modes, BEAM, frame=frame, damping=1.0)
    assert upright(column(flexible, force=on_tip(0.45 * times))) == ""
    assert "is compressed to 60 % of its buckling load; make" in upright(column(flexible, force=on_tip(0.6 * times)))
    assert "99.5 %" in upright(column(flexible, force=on_tip(0.995 * times)))
    for part in (1.005, 1.1):
        sentence = upright(column(flexible, force=on_tip(part * times)))
        assert sentence.startswith("ends: body 'jib' on joint 'root' at 0.")
        assert f"compressed to {100.0 * part:.3g} % of its buckling load" in sentence
    assert upright(column(flexible, force=on_tip(-3.0 * times))) == "", "pulled"


def test_a_column_buckles_under_its_own_weight_and_under_loads_along_it():
    """q L = 7.837 EI/L^2 (Timoshenko, Gere 1961, 2.12), and a load at half the height: four Euler loads."""
    flexible = Flexible(2, BEAM, damping=1.0)
    weight = 7.837347 * EI / L**2 / (PER_LENGTH * L)
    for part in (1.0 - CLOSE, 1.0 + CLOSE):
        own = upright(column(flexible, gravity=part * weight))
        assert own.startswith("ends") == (part > 1.0)
        half = upright(column(flexible, force=on_tip(4.0 * part), at=0.5 * L))
        assert half.startswith("ends") == (part > 1.0)


def test_a_flexible_body_given_by_matrices_reports_that_compression_is_ignored():
    flexible = matrices(BEAM, "clamped")
    assert upright(column(flexible, force=on_tip(0.04))) == ""
    noted = upright(column(flexible, force=on_tip(0.2)))
    assert "is compressed to 20 % of its buckling load, an effect that its matrices do not include" in noted
    assert "lateral deflections are about 25 % too small" in noted
    assert upright(column(flexible, force=on_tip(1.1))).startswith("ends: body 'jib'")


def test_a_column_supported_by_another_body_is_not_refused():
    """Guyed at its top it carries more; how much more its frame cannot say."""
    system = column(Flexible(3, BEAM, damping=1.0), force=on_tip(1.5))
    feet = ((8.0, 0.0), (-8.0, 0.0), (0.0, 8.0), (0.0, -8.0))
    top = Point("jib", (L, 0.0, 0.0))
    guys = tuple(
        Rope(f"guy{n}", (Line(top, Point("world", (x, y, 0.0))),), 1e7, 0.9999 * np.hypot(L, 8.0))
        for n, (x, y) in enumerate(feet)
    )
    sentence = told(replace(system, ropes=guys), statics=False)
    assert not sentence.startswith("ends")
    assert "if only its frame held it" in sentence


def test_a_column_under_a_short_shock_is_not_reported_as_buckling():
    """Twice the Euler load for 30 ms."""
    blow = InputSignal(times=(0.0, 0.5, 0.5, 0.53, 0.53), values=(0.0, 0.0, 1.0, 1.0, 0.0))
    system = column(Flexible(2, BEAM, damping=0.1), force=on_tip(2.0), signal=blow)
    s = started(system, sample_ns=SECOND // 200)
    hand_over(s, SECOND)
    assert s.notes == []


def test_tension_stiffens_a_spinning_blade():
    """A tension of many Euler loads is no compression."""
    system = scene(Flexible(2, BEAM, damping=0.1))
    hub = Joint("root", "revolute", "world", "jib", axis=Y, v0=(20.0,))
    hub_inertia = ((1e6, 0.0, 0.0), (0.0, 1e6, 0.0), (0.0, 0.0, 1e6))
    s = started(replace(system, bodies=(replace(system.bodies[0], inertia=hub_inertia),), joints=(hub,)))
    hand_over(s, SECOND)
    assert s.notes == []
