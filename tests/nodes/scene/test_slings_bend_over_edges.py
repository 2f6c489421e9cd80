"""Slings and ropes bend over the edges of a scene; faults of edges are reported at their place."""

from math import acos, atan2, cos, hypot, sin, sqrt
from pathlib import Path

import numpy as np
import pytest
from heavylift.coordinator.run import run
from heavylift.kernel import SceneError
from heavylift.kernel.description import Reeving
from heavylift.nodes.scene import bundled, parse, sling_load
from heavylift.recordings import Recording
from lifting import cargo, pose, slings, unstated

G = 9.80665
TEXT = bundled()["edge"].read_text(encoding="utf-8")
RADIUS, AXIS = 0.3, (-9.7, 2.7)  # y and z of the heel's rounding on the block


def at(state, body: str, p) -> np.ndarray:
    """A point of a body in the world."""
    place, R = state.poses[body]
    return np.array(place) + np.array(R) @ np.array(p)


def unrolled(hook: np.ndarray, lug: np.ndarray, axis=AXIS, RADIUS=RADIUS) -> tuple[float, np.ndarray]:
    """Length of a sling over the heel and how it leaves the hook, both by the block's axes: tangents, an arc between
    them, and a rise along the edge that is the same everywhere."""
    p, q = (np.array([x[1] - axis[0], x[2] - axis[1]]) for x in (hook, lug))
    wrap = atan2(q[1], -q[0]) * -1.0 + atan2(p[1], -p[0]) - acos(RADIUS / hypot(*p)) - acos(RADIUS / hypot(*q))
    assert wrap > 0.0
    tangents = [sqrt(hypot(*x) ** 2 - RADIUS**2) for x in (p, q)]
    flat, rise = sum(tangents) + RADIUS * wrap, lug[0] - hook[0]
    touches = atan2(p[1], -p[0]) - acos(RADIUS / hypot(*p))
    tangent = np.array([-RADIUS * cos(touches), RADIUS * sin(touches)]) - p
    u = np.array([rise / flat, *(tangent / hypot(*tangent))])
    return hypot(flat, rise), u / np.linalg.norm(u)


def test_a_tilted_block_is_held_by_slings_that_bend_around_its_heel() -> None:
    """Without friction: each sling is as long as plane geometry says, and all forces on the block balance."""
    text = TEXT.replace("friction: 0.15", "friction: 0").split("  - stage: back")[0]
    tilted = parse(text, passing=True).statics.states[-1]
    place, R = (np.array(x) for x in tilted.poses["block"])
    total, turning = np.array([0.0, 0.0, -160e3 * G]), np.zeros(3)
    for i, x in enumerate((-2.0, 2.0), 1):
        hook, lug = R.T @ (at(tilted, "crane.H3", (0.0, 0.0, -2.0)) - place), np.array([x, -10.15, -1.5])
        length, u = unrolled(hook, lug)
        T = tilted.tensions[f"rear.sling-{i}"]
        assert pytest.approx(250e6 * (length / 14.0 - 1.0), rel=1e-5) == T
        force = -T * (R @ u)
        total, turning = total + force, turning + np.cross(R @ hook, force)
    for i, x in enumerate((-3.0, 3.0), 1):
        lug, hook = at(tilted, "block", (x, 8.0, 3.2)), at(tilted, f"crane.H{i}", (0.0, 0.0, -2.0))
        force = tilted.tensions[f"front.sling-{i}"] * (hook - lug) / np.linalg.norm(hook - lug)
        total, turning = total + force, turning + np.cross(lug - place, force)
    assert np.abs(total).max() < 1e-4 * 160e3 * G
    assert np.abs(turning).max() < 1e-4 * 160e3 * G * 10.0


LIFT = (
    unstated(bundled()["lift"].read_text(encoding="utf-8"))
    .replace("P1: [-8 m, -6 m, 4.3 m]", "P1: [-8 m, -8.3 m, 0 m]")
    .replace("P2: [-4 m, -6 m, 4.3 m]", "P2: [-4 m, -8.3 m, 0 m]")
    .replace("Q1: [4 m, -6 m, 4.3 m]", "Q1: [4 m, -8.3 m, 0 m]")
    .replace("Q2: [8 m, -6 m, 4.3 m]", "Q2: [8 m, -8.3 m, 0 m]")
    .replace("at: 40 m}  ", "at: 40 m, upper trolley: 70.5 m}  ")
    .replace("sling: 10 m, lugs: [P1, P2]", "sling: 14 m, lugs: [P1, P2], over edges: [sheer]")
    .replace("sling: 10 m, lugs: [Q1, Q2]", "sling: 14 m, lugs: [Q1, Q2], over edges: [sheer]")
    .replace("end: 60 s", "limits: {off-lead: unknown}")
    .replace("\nrig:", "\nedges:\n  sheer: {on: block, from: [-9 m, -8.5 m, 3.8 m], to: [9 m, -8.5 m, 3.8 m],"
             " radius: 0.2 m}\n\nrig:")
    .split("  - stage: sideways")[0]
)  # fmt: skip


def test_slings_of_lifting_beams_bend_over_the_block() -> None:
    """Those of a goliath's loaders: their slack at the start is that over the edge; in the air each is as long as plane
    geometry says, and all forces on the block balance."""
    scene = parse(LIFT, passing=True)
    lugs = {name: np.array(p) for name, p in cargo(scene.plan).lugs.items()}
    hangs = pose(scene.plan, "loader-1.upper")[:3] + np.array([-2.0, 0.0, -3.0]) - (40.0, 75.0, 6.0)
    assert unrolled(hangs, lugs["P1"], (-8.5, 3.8), 0.2)[0] == pytest.approx(14.0 - 0.05, abs=1e-9)
    up = scene.statics.states[-1]
    place, R = (np.array(x) for x in up.poses["block"])
    total, turning = np.array([0.0, 0.0, -300e3 * G]), np.zeros(3)
    for tie, sling in slings(scene.plan).values():
        beam, lug = R.T @ (at(up, tie.upper.body, tie.upper.p) - place), lugs[tie.lug]
        length, u = np.linalg.norm(beam - lug), (lug - beam) / np.linalg.norm(beam - lug)
        over = isinstance(sling, Reeving)
        if over:
            length, u = unrolled(beam, lug, (-8.5, 3.8), 0.2)
        T = up.tensions[sling.name]
        assert pytest.approx(sling.EA * (length / (sling.signal.value if over else sling.L0) - 1.0), rel=1e-5) == T
        total, turning = total - T * (R @ u), turning - T * (R @ np.cross(beam, u))
    assert np.abs(total).max() < 1e-4 * 300e3 * G
    assert np.abs(turning).max() < 1e-4 * 300e3 * G * 8.0
    hooks = [hook for machine in scene.plan.machines for hook in machine.hooks]
    assert sum(sling_load(scene.plan, up, hook) for hook in hooks) == pytest.approx(300e3, rel=1e-4)


def test_bent_slings_of_a_lifting_beam_are_unhooked_and_hooked_again(tmp_path: Path) -> None:
    text = LIFT.split("actions:")[0] + "actions:\n  - loader-1: unhook\n  - loader-1: hook [P1, P2]\n  - wait: 1 s\n"
    scene = parse(text, passing=True)
    run(scene, tmp_path / "run.mcap", in_process=True)
    events = Recording(tmp_path / "run.mcap").events()
    assert [e.type for e in events if e.type in ("Unhooked", "Hooked")] == ["Unhooked"] * 2 + ["Hooked"] * 2


def test_slings_over_edges_bend_over_one_body_from_the_start() -> None:
    with pytest.raises(SceneError, match="slings can bend over edges only if they hang on 'lugs' from the start"):
        parse(LIFT.replace("lugs: [P1, P2], ", ""), passing=True)
    quay = "quay: {on: world, from: [9 m, 66 m, 9 m], to: [60 m, 66 m, 9 m], radius: 0.2 m, inside: [40 m, 68 m, 8 m]}"
    text = LIFT.replace("\nedges:\n", f"\nedges:\n  {quay}\n").replace("edges: [sheer]", "edges: [sheer, quay]")
    with pytest.raises(SceneError, match="the block turns freely, so its slings bend over edges of one body only"):
        parse(text, passing=True)


ROPE = """\
heavylift: 1
name: quay
mechanism:
  bodies: {load: {mass: 1 t, inertia: [1 t m2, 1 t m2, 1 t m2]}}
  joints: {guide: {type: prismatic, child: load, axis: [0, 0, 1], start: -5 m, at: [3 m, 0, 0]}}
  ropes:
    fall:
      start: {body: world, at: [-4 m, 0 m, 0.1 m]}
      end: {body: load}
      over edges: [quay]
      EA: 20 MN
      length: 10.04 m
      damping: 3 kN s/m
edges:
  quay: {on: world, from: [0, -1 m, 0], to: [0, 1 m, 0], radius: 0.2 m, friction: 0.1, inside: [-1 m, 0, -1 m]}
actions:
  - fall: unhook
"""


@pytest.mark.parametrize("turned", [False, True])
def test_a_rope_passes_on_the_outer_side_of_an_edge(turned: bool) -> None:
    """Whichever end of the edge is named first; a rope over it is one over a sheave, and can be taken off."""
    ends = "from: [0, -1 m, 0], to: [0, 1 m, 0]"
    text = ROPE.replace(ends, "from: [0, 1 m, 0], to: [0, -1 m, 0]") if turned else ROPE
    (rope,) = parse(text, passing=True).plan.machines[0].system.reevings
    (edge,) = rope.edges
    assert (edge.axis[1], *edge.span) == (1.0, 0.0, 2.0) if not turned else (1.0, -2.0, 0.0)
    assert (edge.edge, edge.radius, edge.friction, rope.hooked) == ("quay", 0.2, 0.1, True)


def tensions(text: str) -> list[float]:
    states = parse(text.replace("actions:\n  - fall: unhook", "actions:\n  - wait: 1 s"), passing=True).statics.states
    return [state.tensions["fall"] for state in states]


@pytest.mark.parametrize("aside", [0.0, 0.3])
def test_the_tension_of_a_rope_over_an_edge_on_a_third_body_equals_that_over_an_edge_on_the_wall(aside: float) -> None:
    """A rope from a wall over a pier to its load hangs as one over the wall does, wherever the pier stands."""
    ends = "from: [{0} m, -1 m, {1} m], to: [{0} m, 1 m, {1} m]"
    own = ROPE.replace("from: [0, -1 m, 0], to: [0, 1 m, 0]", ends.format(aside, 0))
    third = ROPE.replace("joints: {", f"joints: {{stands: {{type: fixed, child: pier, at: [{aside} m, 0, 1 m]}}, ")
    third = third.replace("bodies: {", "bodies: {pier: {mass: 9 t}, ").replace("{on: world", "{on: pier")
    third = third.replace("from: [0, -1 m, 0], to: [0, 1 m, 0]", ends.format(0, -1))
    third = third.replace("inside: [-1 m, 0, -1 m]", f"inside: [{-1 - aside} m, 0, -2 m]")
    assert tensions(third) == pytest.approx(tensions(own), rel=1e-9)
    assert min(tensions(own)) > 0.0


PIER = """\
  quay: {on: world, from: [-1 m, -1 m, 0], to: [-1 m, 1 m, 0], radius: 0.2 m, inside: [-2 m, 0, -1 m]}
  pier: {on: pier, from: [0, -1 m, 0], to: [0, 1 m, 0], radius: 0.2 m, inside: [-1 m, 0, -1 m]}
"""


@pytest.mark.parametrize("joint", ["type: prismatic, axis: [0, 1, 0]", "type: spherical"])
def test_edges_on_two_bodies_that_stay_parallel_may_bend_the_same_rope(joint: str) -> None:
    """One that slides bears as the ground would; a body that turns anyhow is refused where it is written."""
    text = ROPE.split("  quay:")[0] + PIER + "actions:\n  - fall: unhook\n"
    text = text.replace("over edges: [quay]", "over edges: [quay, pier]")
    text = text.replace("joints: {", f"joints: {{stands: {{{joint}, child: pier}}, ")
    text = text.replace("bodies: {", "bodies: {pier: {mass: 9 t, inertia: [1 t m2, 1 t m2, 1 t m2]}, ")
    text = text.replace("length: 10.04 m", "length: 10.03 m")
    if "prismatic" in joint:
        assert tensions(text) == pytest.approx(tensions(text.replace("{on: pier", "{on: world")), rel=1e-9)
        shorter = ROPE.replace("friction: 0.1, ", "").replace("10.04", "10.03")
        assert tensions(text) > tensions(shorter), "it takes the longer way"
        return
    with pytest.raises(SceneError) as message:
        parse(text, passing=True)
    assert "the joint 'stands' can turn the one on 'pier' out of parallel; use edges of a single body" in str(
        message.value
    )
    assert "scene.yaml:" in str(message.value)


def test_a_rope_over_an_elastic_pier_conserves_the_energy_balance(tmp_path: Path) -> None:
    """Pulled askew over an edge without friction, on a body of its own that the rope pushes to and fro."""
    text = ROPE.split("actions:")[0].replace(
        "joints: {", "joints: {gives: {type: prismatic, child: pier, axis: [1, 0, 0]}, "
    )
    text = text.replace("bodies: {", "bodies: {pier: {mass: 3 t}, ").replace("{on: world", "{on: pier")
    text = text.replace("  ropes:", "  springs: {bends: {joint: gives, stiffness: 200 kN/m}}\n  ropes:")
    text = text.replace("friction: 0.1", "friction: 0").replace("damping: 3 kN s/m", "damping: 0 kN s/m")
    scene = parse(text.replace("[-4 m, 0 m", "[-4 m, 0.5 m") + "end: 3 s\naccuracy: 1e-6 %\n", passing=True)
    run(scene, tmp_path / "run.mcap", in_process=True)
    rec = Recording(tmp_path / "run.mcap")
    assert np.ptp(rec["pose/pier"].values[:, 0]) > 0.03
    assert float(rec.result["energy_error"]) < 1e-8 * float(rec.result["energy_turned_over"])


SILL = """\
heavylift: 1
name: sill
cranes: {hall: {type: overhead-100, at: 0 m, trolley: 8 m}}
machines: {hall: {hooks: {hall.main: {apart: 0 m, hangs: 12 m, over edges: [sill]}}}}
edges: {sill: {on: world, from: [-2 m, 9 m, 14 m], to: [2 m, 9 m, 14 m], radius: 0.25 m, inside: [0 m, 9.5 m, 13 m]}}
actions:
  - hall traversing: traverse 10 m/min by 4 m
  - hall: hoist 2 m/min by 1 m
  - hall traversing: traverse 10 m/min by -4 m
"""


def test_a_hook_rope_bends_over_a_sill_and_leaves_it() -> None:
    """The hook hangs plumb below the edge, as high as tangent, arc and stretch leave; its winch hoists it there."""
    scene = parse(SILL, passing=True)
    ends = {state.action: state for state in scene.statics.states}
    T, EA, (y, z) = 2500.0 * G, 12 * 38.3e6, (12.0 - 9.0, 20.0 - 14.0)
    D = hypot(y, z)
    over = sqrt(D * D - 0.25**2) + 0.25 * (np.pi - atan2(z, y) - acos(0.25 / D))
    for action in (1, 2):
        place, long = ends[action].poses["hall.main"][0], ends[action].references["hall.main"] * (1.0 + T / EA)
        assert place == pytest.approx((0.0, 8.75, 14.0 - (long - over)), abs=1e-6)
        assert ends[action].tensions["hall.main"] == pytest.approx(T, rel=1e-6)
    assert ends[3].poses["hall.main"][0] == pytest.approx((0.0, 8.0, 20.0 - long), abs=1e-6), "free again"


def test_a_hook_rope_over_an_edge_with_keys_for_several_lines_is_refused() -> None:
    with pytest.raises(SceneError, match="a hook rope over edges is one line: remove 'drum' and 'apart'"):
        parse(SILL.replace("apart: 0 m, ", ""), passing=True)


def test_a_sling_bends_over_an_obstacle() -> None:
    """On which side of the wall it passes follows from where it holds the block: between that and the wall."""
    wall = "heel: {on: wall, from: [-5 m, 0.5 m, 3 m], to: [5 m, 0.5 m, 3 m]"
    text = TEXT.replace("heel: {on: block, from: [-5 m, -9.7 m, 2.7 m], to: [5 m, -9.7 m, 2.7 m]", wall)
    text = text.replace("edges:\n", "obstacles: {wall: {box: [10 m, 1 m, 6 m], at: [0 m, 32.5 m, 3 m]}}\n\nedges:\n")
    machines = parse(text.split("  - stage: take up")[0] + "  - wait: 1 s\n", passing=True).plan.machines
    edges = [edge for machine in machines for rope in machine.system.reevings for edge in rope.edges]
    assert [(x.at.body, x.axis, x.span) for x in edges] == [("wall", (-1.0, 0.0, 0.0), (-10.0, 0.0))] * 2


BAD = {
    "no such edge": ("over edges: [heel]", "over edges: [hell]", "rigging.rear.over edges[0]: there is no edge 'hell'"),
    "another body": (
        "heel: {on: block",
        "heel: {on: world",
        "'world' has no centre of mass: give the edge 'heel' a point",
    ),
    "no such body": ("heel: {on: block", "heel: {on: blok", "on 'blok', which is not there yet: name edges of what"),
    "no length": ("to: [5 m, -9.7 m", "to: [-5 m, -9.7 m", "the edge 'heel' has no length: keep 'from' and 'to' apart"),
    "no radius": ("radius: 0.3 m", "radius: 0 m", "a length must be greater than zero here"),
    "no side": ("friction: 0.15}", "friction: 0.15, inside: [0 m, -9.25 m, 6.9 m]}", "not plain: give it 'inside'"),
    "too short": ("length: 14 m", "length: 2.2 m", "2.2 m of rope with 0.3 m of slack do not reach over its edges"),
}


@pytest.mark.parametrize("name", BAD)
def test_faults_of_edges_for_ropes_are_reported(name: str) -> None:
    old, new, sentence = BAD[name]
    assert TEXT.count(old) == 1
    with pytest.raises(SceneError) as message:
        parse(TEXT.replace(old, new), passing=True)
    assert sentence in str(message.value)
    assert "scene.yaml:" in str(message.value)
