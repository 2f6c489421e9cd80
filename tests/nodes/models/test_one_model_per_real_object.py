"""Structure of the models against Fig. 7, and what they declare against the scene `turnover`."""

from dataclasses import replace

import msgspec
import pytest
from heavylift.kernel.description import (
    Body,
    Brake,
    Drive,
    Joint,
    JointSpring,
    Line,
    Point,
    Rope,
    Stop,
    Support,
    System,
    Threshold,
)
from heavylift.nodes.devs import Coupled, Model
from heavylift.nodes.models import build, build_one, couplings, subscriptions, system, tree
from heavylift.nodes.models.commander import Commander
from heavylift.nodes.models.parts import Actor, BodyAtomic, BodyCoupled, JointAtomic, JointCoupled, LoadCell
from heavylift.nodes.plan import Action, CrossingCondition, Mechanism, Plan, Turn, decode, encode
from yard import turnover

TURN = Action(orders=(Turn(rate=0.0026, accel=0.00026, to=1.5),))
DOF = {"fixed": 0, "revolute": 1, "prismatic": 1, "spherical": 3, "free": 6}


def below(model: Model) -> list[Model]:
    children = model.children.values() if isinstance(model, Coupled) else ()
    return [model, *(found for child in children for found in below(child))]


def test_the_scene_turnover_has_ten_coupled_models_with_nineteen_bodies_and_54_degrees_of_freedom() -> None:
    plan = turnover(TURN)
    models, mechanics = build(plan), system(plan)
    assert list(models) == ["commander", "west", "east", *(f"loader-{i}" for i in range(1, 7)), "block"]
    assert len(mechanics.bodies) == len(mechanics.joints) == 19
    assert sum(DOF[joint.kind] for joint in mechanics.joints) == 54
    kinds = [joint.kind for joint in mechanics.joints]
    assert (kinds.count("prismatic"), kinds.count("free"), kinds.count("revolute")) == (6, 7, 6)
    assert [rope.name for rope in mechanics.ropes if rope.winch] == [
        f"{c}.H{i}" for c in ("east", "west") for i in (1, 2, 3)
    ]
    assert len([rope for rope in mechanics.ropes if not rope.winch]) == 12
    assert (len(mechanics.supports), len(mechanics.drives), len(mechanics.masters)) == (8, 6, 1)


def test_each_joint_or_body_has_a_coupled_model_with_one_atomic_model_and_its_actors() -> None:
    models = [m for model in build(turnover(TURN)).values() for m in below(model)]
    for kind, atomic, count in ((JointCoupled, JointAtomic, 19), (BodyCoupled, BodyAtomic, 19)):
        found = [m for m in models if isinstance(m, kind)]
        assert len(found) == count
        for coupled in found:
            children = list(coupled.children.values())
            assert [isinstance(child, atomic) for child in children].count(True) == 1
            assert len(children) > 1
            assert all(isinstance(child, (atomic, Actor)) for child in children)
    assert [m.path for m in models if isinstance(m, Commander)] == ["commander.actions"]


def test_the_commander_model_is_connected_to_every_machine_and_the_kernel_receives_all_orders() -> None:
    plan = turnover(TURN)
    models = build(plan)
    table = couplings(plan)
    for name in list(models)[1:]:
        assert ("commander", f"order_{name}", name, "order") in table
        assert (name, "report", "commander", "report") in table
        assert (name, "input", "kernel", f"input_{name}") in table
        assert ("kernel", f"state_{name}", name, "state") in table
    assert ("commander", "input", "kernel", "input_commander") in table
    for source, out, target, into in table:
        assert source == "kernel" or out in models[source].ports
        assert target == "kernel" or into in models[target].ports


def test_a_state_event_of_the_kernel_is_sent_to_the_model_of_the_part_that_it_concerns() -> None:
    heard = subscriptions(turnover())
    assert heard["loader-3.sling-2"] == ("loader-3",)
    assert heard["block.lower-1"] == ("block",)
    assert heard["west.H1"] == heard["west.H1.highest"] == heard["west.main.load"] == ("west",)
    assert "loader-1.hinge.lock" not in heard


def test_a_node_builds_only_its_own_models_from_the_plan_that_it_receives() -> None:
    plan = decode(encode(turnover(TURN)))
    assert plan == turnover(TURN)
    assert [m.path for m in below(build_one(plan, "loader-3"))] == [
        "loader-3",
        "loader-3.free-joint",
        "loader-3.free-joint.joint",
        "loader-3.free-joint.free",
        "loader-3.hinge-joint",
        "loader-3.hinge-joint.joint",
        "loader-3.hinge-joint.hinge-lock",
        "loader-3.hinge-joint.hinge-damper",
        "loader-3.hinge-joint.hinge-stop",
        "loader-3.upper-body",
        "loader-3.upper-body.body",
        "loader-3.upper-body.weight",
        "loader-3.lower-body",
        "loader-3.lower-body.body",
        "loader-3.lower-body.weight",
        "loader-3.lower-body.sling-1",
        "loader-3.lower-body.sling-2",
        "loader-3.lower-body.load",
    ]


def test_the_lifting_beam_declares_its_hinge_with_stops_damper_and_lock() -> None:
    plan = turnover(hooked="A")
    low, high = (build_one(plan, name).declare() for name in ("loader-1", "loader-3"))
    assert [(j.name, j.kind, j.parent, j.child) for j in low.joints] == [
        ("loader-1.free", "free", "world", "loader-1.upper"),
        ("loader-1.hinge", "revolute", "loader-1.upper", "loader-1.lower"),
    ]
    assert (low.joints[1].p_PJ, low.joints[1].axis) == ((0.0, 0.0, -2.0), (0.0, 1.0, 0.0))
    assert [stop.name for stop in low.stops] == ["loader-1.hinge.stop"]
    assert [spring.d for spring in low.springs] == [1e5]
    assert [brake.engaged for brake in (*low.brakes, *high.brakes)] == [False, True]
    upper, lower = low.bodies  # boxes of 2 m, and of 4 m by 1 m by 1 m
    assert (upper.mass, upper.com, lower.mass, lower.com) == (35e3, (0.0, 0.0, -1.0), 10e3, (0.0, 0.0, -0.5))
    assert [upper.inertia[i][i] for i in range(3)] == pytest.approx([35e3 * 8.0 / 12.0] * 3)
    assert [lower.inertia[i][i] for i in range(3)] == pytest.approx([10e3 * x / 12.0 for x in (2.0, 17.0, 17.0)])


def test_rated_values_of_load_cells_include_the_hook_blocks() -> None:
    cells = {m.element: m.rated for m in below(build_one(turnover(), "west")) if isinstance(m, LoadCell)}
    tons = {name: round(rated / 9.80665e3, 9) for name, rated in cells.items()}
    assert tons == {
        "west.H1.load": 475.0,
        "west.H2.load": 475.0,
        "west.H3.load": 475.0,
        "west.upper.load": 950.0,
        "west.main.load": 750.0,
    }


def test_a_heavier_block_in_the_plan_is_heavier_in_the_kernel_system() -> None:
    plan = turnover()
    *others, block = plan.machines
    (body,) = block.system.bodies
    heavy = replace(block.system, bodies=(replace(body, mass=910e3),))
    heavier = msgspec.structs.replace(plan, machines=(*others, msgspec.structs.replace(block, system=heavy)))
    assert [b.mass for b in system(heavier).bodies if b not in system(plan).bodies] == [910e3]


def test_changing_a_joint_or_a_body_or_an_actor_changes_the_system_declared_to_the_kernel() -> None:
    model = build_one(turnover(), "west")
    before = model.declare()
    parts = {m.path: m for m in below(model)}
    joint, drive, main = (
        parts["west.gantry-joint.joint"],
        parts["west.gantry-joint.gantry-drive"],
        parts["west.main-body.body"],
    )
    assert isinstance(joint, JointAtomic)
    assert isinstance(drive, Actor)
    assert isinstance(main, BodyAtomic)
    joint.joint = replace(joint.joint, kind="fixed")
    drive.laws = System(drives=(replace(before.drives[0], kp=1.0),))
    main.body = replace(main.body, mass=1.0)
    after = model.declare()
    assert (after.joints[0].kind, after.drives[0].kp, after.bodies[1].mass) == ("fixed", 1.0, 1.0)
    assert (after.joints[1:], after.drives[1:], after.bodies[2:]) == (
        before.joints[1:],
        before.drives[1:],
        before.bodies[2:],
    )


def test_thresholds_of_conditions_are_sent_to_the_model_that_observes_them() -> None:
    guard = Threshold("block.angle-1", "angle", of="block")
    plan = turnover(Action(when=CrossingCondition(model="block", threshold=guard, value=1.5, rising=True), orders=()))
    assert guard in build_one(plan, "block").declare().thresholds
    assert subscriptions(plan)["block.angle-1"] == ("block",)


def test_a_mechanism_passes_exactly_the_parts_written_in_the_scene_to_the_kernel() -> None:
    link = Joint("q1", "revolute", "world", "link1", axis=(0.0, 1.0, 0.0), q0=(0.3,), v0=(0.0,))
    written = System(
        bodies=(Body("link1", 10.0), Body("mass", 5.0)),
        joints=(link, Joint("q2", "prismatic", "link1", "mass", q0=(0.0,), v0=(0.0,))),
        springs=(JointSpring("spring", "q2", 10.0, 1.0),),
        stops=(Stop("stop", "q2", -1.0, 1.0, 1e5, 1e3),),
        brakes=(Brake("brake", "q1", 5.0, 1e4, 1e2),),
        drives=(Drive("motor", "q1", "prescribed"),),
        ropes=(Rope("rope", (Line(Point("world"), Point("mass")),), 1e6, 2.0, winch=True),),
        supports=(Support("foot", Point("mass"), 0.0, 1e6, 1e3),),
    )
    plan = Plan(name="arm", machines=(Mechanism(name="arm", system=written),), end=1.0)
    assert system(plan) == written
    models = [m.path for m in below(build(plan)["arm"])]
    assert models[:5] == [
        "arm",
        "arm.q1-joint",
        "arm.q1-joint.joint",
        "arm.q1-joint.motor",
        "arm.q1-joint.brake",
    ]
    assert models[-4:] == [
        "arm.mass-body.body",
        "arm.mass-body.weight",
        "arm.mass-body.rope",
        "arm.mass-body.supports",
    ]


def test_the_printed_tree_of_models_shows_atomic_models_actors_and_ports() -> None:
    lines = tree(turnover(TURN)).splitlines()
    assert lines[0] == "turnover: 10 coupled models"
    at = lines.index("├─ loader-6  coupled: machine  [order state -> input report]")
    assert lines[at + 4 : at + 9] == [
        "│  ├─ hinge-joint  joint coupled  [order state latch-hinge-lock -> input report]",
        "│  │  ├─ joint  joint atomic: revolute, loader-6.upper to loader-6.lower",
        "│  │  ├─ hinge-lock  actor: LatchActor of loader-6.hinge.lock  [order state latch -> input report]",
        "│  │  ├─ hinge-damper  actor: law of loader-6.hinge.damper",
        "│  │  └─ hinge-stop  actor: law of loader-6.hinge.stop",
    ]
    assert lines[-1] == "      └─ attitude  actor: Inclinometer of block  [order state -> input report]"
