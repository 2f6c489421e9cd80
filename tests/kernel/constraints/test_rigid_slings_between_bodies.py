"""A block is lifted off its pads on rigid slings under elastic hook ropes, far from the origin, by every method."""

from dataclasses import replace
from math import sqrt

import numpy as np
import pytest
from heavylift.kernel.description import Body, Joint, Line, Point, RigidRope, Rope, Support, System, Threshold
from small_scenes import SECOND, G, X, Z, column, cube, hand_over, imbalance, started

FAR = 75.0  # [m] of the lift from the origin
HOOK, BLOCK, HALF, EA = 15e3, 3e5, 6.0, 1e9
LOOSE = {"dopri5": 1e-3, "dop853": 1e-3, "radau5": 1e-3}
PEAK = 1e-2  # of peaks at loose tolerances
STIFF = 1e-3  # what slings a thousand times as stiff as the ropes leave


def lift(sling_EA: float = np.inf, lean: float = 0.0) -> System:
    """Slings are 20 mm slack; `lean`: the centre of mass beside the middle of the lugs."""
    places = (FAR - HALF, FAR + HALF)
    bodies = [Body("block", BLOCK, (lean, 0.0, 0.0), cube(BLOCK, 8.0))]
    joints = [
        Joint(
            "block", "planar", "world", "block", axis=(0.0, -1.0, 0.0), second=X, q0=(FAR, 0.0, 0.0), v0=(0.0, 0.0, 0.0)
        )
    ]
    ropes, slings, pads = [], [], []
    for i, x in enumerate(places):
        hook, carrier, lug = f"hook{i}", f"carrier{i}", Point("block", (x - FAR, 0.0, 4.0))
        bodies += [Body(carrier, 0.0), Body(hook, HOOK)]
        joints += [
            Joint(f"x{i}", "prismatic", "world", carrier, axis=X, q0=(x,)),
            Joint(f"z{i}", "prismatic", carrier, hook, axis=Z, q0=(14.0,)),
        ]
        line = (Line(Point("world", (x, 0.0, 44.0)), Point(hook)),)
        ropes.append(Rope(f"rope{i}", line, EA, 30.0 / (1.0 + HOOK * G / EA), 2e5, winch=True))
        slings.append((f"sling{i}", (Line(Point(hook), lug),), 10.02))
        k = 1e9
        pads.append(
            Support(f"pad{i}", Point("block", (x - FAR, 0.0, -4.0)), -4.0 + BLOCK * G / 2 / k, k, 1e7, 0.2, k, 1e7)
        )
    whole = System(tuple(bodies), tuple(joints), ropes=tuple(ropes), supports=tuple(pads), gravity=G)
    if sling_EA == np.inf:
        return replace(whole, rigid_ropes=tuple(RigidRope(*s) for s in slings))
    damping = 0.1 * sqrt(sling_EA / 10.0 * HOOK)
    return replace(whole, ropes=whole.ropes + tuple(Rope(n, line, sling_EA, L, damping) for n, line, L in slings))


def lifted(scene: System, **options):
    s = started(scene, sample_ns=SECOND // 20, **options)
    for i in range(2):
        s.references.set_profile(f"rope{i}", 0, -0.05, 0.1, -0.4)
    s.settle()
    hand_over(s, 12 * SECOND)
    return s


@pytest.mark.parametrize("method", LOOSE)
def test_every_integration_method_finds_the_same_sling_tensions_at_a_loose_tolerance(method):
    """Steps that are long against the ropes' motion, with positions of 75 m: nothing is lost and nothing chatters."""
    fine, loose = lifted(lift(), tolerance=1e-8), lifted(lift(), method=method, tolerance=LOOSE[method])
    want, found = (column(s, "rope/peak")[1].max(axis=0) for s in (fine, loose))
    assert found == pytest.approx(want, rel=PEAK)
    assert np.array(loose.row().tension) == pytest.approx([BLOCK * G / 2 + HOOK * G] * 2, rel=5e-2)
    taut = [e for _, e in loose.log if e.name.startswith("sling")]
    assert [e.what for e in taut] == ["taut", "taut"]
    assert imbalance(loose) < 1e-3


@pytest.mark.parametrize("method", ["dopri5", "radau5"])
def test_elastic_slings_tend_to_rigid_slings_as_their_stiffness_grows(method):
    """Also where the block leans and its pads open one after the other."""
    rigid = lifted(lift(lean=1.0), method=method, tolerance=1e-8)
    stiff = lifted(lift(1e3 * EA, lean=1.0), method="radau5", tolerance=1e-8)
    for topic in ("rope/tension", "rope/peak"):
        a, b = (column(s, topic)[1].max(axis=0)[:2] for s in (rigid, stiff))
        assert a == pytest.approx(b, rel=STIFF)
    assert rigid.state[:3] == pytest.approx(stiff.state[:3], abs=STIFF)
    shares = BLOCK * G * np.array([HALF - 1.0, HALF + 1.0]) / (2.0 * HALF)
    assert np.array(rigid.row().pull) == pytest.approx(shares, rel=STIFF * 10)


def test_the_load_cell_of_an_unhooked_rope_shows_zero():
    """Of two loads on rigid ropes one is let go."""
    bodies = tuple(Body(n, 1e3) for n in ("left", "right"))
    joints = tuple(Joint(n, "prismatic", "world", n, axis=Z, q0=(-10.0,)) for n in ("left", "right"))
    ropes = tuple(RigidRope(f"rope-{n}", (Line(Point("world"), Point(n)),), 10.0) for n in ("left", "right"))
    cells = tuple(Threshold(f"cell-{n}", "tension", ropes=(f"rope-{n}",)) for n in ("left", "right"))
    s = started(System(bodies, joints, rigid_ropes=ropes, thresholds=cells, gravity=G))
    hand_over(s, SECOND)
    s.unhook("rope-left")
    s.settle()
    hand_over(s, 2 * SECOND)
    assert s.state[:2] == pytest.approx([-10.0 - 0.5 * G, -10.0], abs=1e-6)
    assert np.array(s.row().pull) == pytest.approx([0.0, 1e3 * G])
