"""Fenders between a vessel and a quay: equilibrium and rebound in closed form, and the check of the fender load."""

from __future__ import annotations

from math import cos, exp, pi, sin, sqrt

import numpy as np
import pytest
from heavylift.coordinator.record import play
from heavylift.kernel import SceneError
from heavylift.kernel.analysis import equilibrium
from heavylift.kernel.simulation import Simulation
from heavylift.nodes.limits import uses_on_path
from heavylift.nodes.models import system
from heavylift.nodes.scene import LoadedScene, parse
from heavylift.nodes.statics import follow
from scipy.optimize import brentq

G, MASS, K, D, PUSH = 9.80665, 14432e3, 4e6, 2e6, 600e3  # [kg, N/m, N s/m, N], of each of two fenders
SCENE = """
heavylift: 1
name: alongside
end: %s
samples: 20 Hz
method: dopri5
tolerance: 1e-9
vessels:
  barge:
    mass: 14432 t
    size: [110 m, 32 m, 8 m]
    draught: 4 m
    at: [0 m, %s, 0 m]
    motion: forces
    floating: {waterplane: 3500 m2, GM: 5 m, GML: 200 m, mooring: {surge: 400 kN/m, yaw: 400 MN m/rad%s}}
fenders:
  fore: {at: [40 m, -20 m, 0 m], meets: [40 m, -16 m, 0 m], stiffness: 4 MN/m,
         vessel: barge, facing: %s, damping: %s, %s}
  aft: {at: [-40 m, -20 m, 0 m], meets: [-40 m, -16 m, 0 m], stiffness: 4 MN/m,
        vessel: barge, facing: %s, damping: %s, %s}
mechanism:
  name: tug
  forces: {tug: {type: load, body: barge, force: [0 kN, %s, 0 kN]}}
actions: [{wait: 1 s}]
"""
CLOSE = 1e-3  # relative
SAMPLE = 0.06  # [s] between two samples, and a little


def scene(y: str = "-4 m", more: str = "", push: str = "-600 kN", end: str = "20 s", facing: str = "[0, 1, 0]",
          damping: str = "2 MN s/m", other: str = "capacity: 400 kN") -> LoadedScene:  # fmt: skip
    one = facing, damping, other
    return parse(SCENE % (end, y, more, *one, *one, push))


def test_two_fenders_share_the_push_of_a_tug_on_the_barge() -> None:
    """At rest each yields by half of the push over its stiffness, and that is what is held against its capacity."""
    loaded = scene("-4.05 m")
    s = Simulation(system(loaded.plan), 1e-9)
    s.start()
    equilibrium(s)
    assert s.row().normal.tolist() == pytest.approx([PUSH / 2.0] * 2, rel=CLOSE)
    for capacity, beyond in (("400 kN", False), ("290 kN", True)):
        held = scene("-4.05 m", other=f"capacity: {capacity}")
        uses = [
            x for x in uses_on_path(held.plan, list(follow(held.plan).states)) if x.limit.quantity == "support load"
        ]
        assert {x.limit.subject for x in uses} == {"fore", "aft"}
        assert [x.beyond for x in uses] == [beyond] * 2
        assert uses[0].value * G == pytest.approx(PUSH / 2.0, rel=CLOSE)


def test_a_barge_that_drifts_against_its_fenders_rebounds_as_a_damped_half_wave() -> None:
    """Pushed over 0.5 m, it touches with v; the reaction is that of a mass on a spring and damper, and it leaves."""
    run = play(scene("-3.5 m", end="12 s").plan)
    t, force = run.t, run.past.part(0, len(run.t)).tensions["fore"]
    meets = t[np.flatnonzero(force > 0.0)[0]]
    assert meets == pytest.approx(sqrt(2.0 * 0.5 * MASS / PUSH), abs=SAMPLE)
    v = PUSH / MASS * sqrt(2.0 * 0.5 * MASS / PUSH)
    w, decay = sqrt(2.0 * K / MASS), D / MASS
    wd, rest = sqrt(w * w - decay * decay), PUSH / (2.0 * K)
    tau = t - sqrt(2.0 * 0.5 * MASS / PUSH)
    b = (v - decay * rest) / wd

    def moved(x: float) -> tuple[float, float]:
        """Compression and its rate."""
        e, c, s = exp(-decay * x), cos(wd * x), sin(wd * x)
        y = e * (-rest * c + b * s)
        return rest + y, e * ((rest * decay + b * wd) * c + (rest * wd - b * decay) * s)

    want = [0.0 if x < 0.0 or x > pi / wd else K * moved(x)[0] + D * moved(x)[1] for x in tau]
    # it leaves when spring and damper no longer push together, and the tug has not yet brought it back
    leaves = brentq(lambda x: K * moved(x)[0] + D * moved(x)[1], 0.5 * pi / wd, 1.5 * pi / wd)
    assert np.all(force[(tau > SAMPLE) & (tau < leaves - SAMPLE)] > 0.0)
    after = force[tau > leaves + SAMPLE]
    assert len(after) > 5
    assert not np.any(after)
    inside = (tau > 0.2) & (tau < 0.6 * pi / wd)
    assert force[inside] == pytest.approx(np.array(want)[inside], rel=CLOSE)


@pytest.mark.parametrize("facing", ["[0, 2, 0]", "[0.6, 0.8, 0]", "[0, 0.8, 0.6]"])
def test_the_force_of_a_fender_acts_along_its_stated_direction(facing: str) -> None:
    loaded = scene("-4.05 m", more=", sway: 1 kN/m", facing=facing, damping="0 N s/m")
    s = Simulation(system(loaded.plan), 1e-9)
    s.start()
    n = np.array([float(x) for x in facing.strip("[]").split(",")])
    n /= np.linalg.norm(n)
    depth = -(np.array([0.0, -0.05, 0.0]) @ n)
    assert s.row().normal.tolist() == pytest.approx([K * depth] * 2, rel=1e-9)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"other": "on: ferry"}, "there is no vessel 'ferry'"),
        ({"other": "on: barge"}, "a vessel cannot lean on itself"),
        ({"facing": "[0, 0, 0]"}, "the direction has no length"),
        ({"y": "-4.11 m"}, "'barge' begins 0.11 m behind the face, and the fender yields by 0.1 m only"),
        ({"y": "-7 m", "other": "friction: 0.2"}, "begins 3 m behind the face, and the fender yields by 2 m only"),
    ],
)
def test_impossible_fenders_are_refused_in_one_sentence(change: dict[str, str], words: str) -> None:
    with pytest.raises(SceneError, match=words):
        scene(**change)


def test_a_fender_without_a_stated_capacity_is_reported_as_not_checked() -> None:
    rows = [x for x in scene(other="friction: 0.2").plan.limits if x.subject in ("fore", "aft")]
    assert [(x.value, x.note) for x in rows] == [(None, "give its 'capacity'")] * 2


def test_fenders_in_a_scene_without_gravity_have_no_limit_in_kilograms() -> None:
    """The limit of a support is in kilograms, of which none are known there."""
    text = SCENE % ("20 s", "0 m", "", *2 * ("[0, 1, 0]", "2 MN s/m", "capacity: 400 kN"), "-600 kN")
    head, _, tail = text.partition("    motion: forces\n")
    text = (
        head.replace("heavylift: 1", "heavylift: 1\ngravity: 0 m/s2") + "    responses: {}\n" + tail.partition("\n")[2]
    )
    assert [x.value for x in parse(text).plan.limits if x.subject in ("fore", "aft")] == [None, None]


SIZES = (3.0, 1.2)  # [m] of both faces


def sized(at: tuple[float, float, float], push: str = "-600 kN", along: str = "0 kN", end: str = "20 s") -> LoadedScene:
    """The barge at `at`, before fenders with ends."""
    text = SCENE % (
        end, "%s", ", sway: 1 kN/m", *2 * ("[0, 1, 0]", "2 MN s/m", f"size: [{SIZES[0]} m, {SIZES[1]} m]"), push
    )  # fmt: skip
    text = text.replace("at: [0 m, %s, 0 m]", "at: [{} m, {} m, {} m]".format(*at)).replace(
        "force: [0 kN", f"force: [{along}"
    )
    return parse(text.replace("surge: 400 kN/m", "surge: 1 kN/m"))


def misses(of: LoadedScene) -> list[bool]:
    """Whether each fender is missed on the path at rest."""
    rows = uses_on_path(of.plan, list(follow(of.plan).states))
    return [x.beyond for x in rows if "beside the face" in x.limit.subject]


@pytest.mark.parametrize("seed", range(12))
def test_a_fender_pushes_only_a_vessel_that_meets_its_face(seed: int) -> None:
    draw = np.random.default_rng(seed)
    x, y, z = (draw.uniform(-1.0, 1.0, 3) * (2.0, 0.09, 0.8) + (0.0, -4.0, 0.0)).round(3).tolist()
    s = Simulation(system(sized((x, y, z)).plan), 1e-9)
    s.start()
    meets = abs(x) < SIZES[0] / 2 and abs(z) < SIZES[1] / 2
    want = max(0.0, -(y + 4.0)) * K if meets else 0.0
    assert s.row().normal.tolist() == pytest.approx([want] * 2, rel=1e-9)


@pytest.mark.parametrize(("at", "missed"), [((1.4, -4.05, 0.0), False), ((1.6, -4.05, 0.0), True),
                                            ((0.0, -4.05, -0.7), True), ((1.6, -3.9, 0.0), False)])  # fmt: skip
def test_a_vessel_behind_the_plane_of_a_fender_face_but_beside_the_face_gives_a_red_check(
    at: tuple[float, float, float], missed: bool
) -> None:
    """At rest, where the tug holds it away from the quay, a vessel before the plane misses nothing yet."""
    assert misses(sized(at, push="0 kN")) == [missed] * 2


@pytest.mark.parametrize("at", [(1.5, -4.05, 0.0), (0.0, -3.0, -0.6), (-1.5, -4.0, 0.2)])
def test_a_vessel_that_begins_at_the_edge_of_a_fender_face_is_refused(at: tuple[float, float, float]) -> None:
    with pytest.raises(SceneError, match=r"fenders.fore.size: 'barge' begins at the edge of the face"):
        sized(at)


def test_a_barge_that_drifts_along_the_quay_beyond_its_fenders_gives_a_red_verdict() -> None:
    """Pushed along with 2 MN against a mooring of 1 kN/m, it passes the edge after sqrt(2 x 1.5 m x mass / 2 MN)."""
    of = sized((0.0, -4.075, 0.0), along="2000 kN", end="8 s")
    run = play(of.plan)
    past, t = run.past.part(0, len(run.t)), run.t
    leaves, force = sqrt(2.0 * 1.5 * MASS / 2e6), past.tensions["fore"]
    assert np.all(force[t < leaves - SAMPLE] > 0.0)
    assert not np.any(force[t > leaves + SAMPLE])
    (row,) = [x for x in run.judge.fine[1] if x.limit.subject == "barge beside the face of fore"]
    assert row.beyond
    assert row.value == pytest.approx(-4.0 - past.poses["barge"][:, 1].min(), abs=0.1)


def test_a_fender_face_whose_size_is_not_stated_is_reported_as_not_checked() -> None:
    (one, other) = [x for x in scene().plan.limits if "beside the face" in x.subject]
    assert (one.value, other.note) == (None, "give the 'size' of the face")
