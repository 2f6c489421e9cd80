"""Effects omitted by a model level add no operations to an evaluation."""

from dataclasses import fields, replace

from heavylift.kernel.description import Body, Joint, Lock, System
from heavylift.kernel.model import Program
from heavylift.kernel.simulation import Simulation
from heavylift.nodes.models import system
from heavylift.nodes.scene import load


def declared(fidelity):
    return replace(system(load("lift", [f"fidelity={fidelity}"]).plan), thresholds=())


def mechanism(scene, *settings):
    return system(load(scene, settings).plan)


def operations(given):
    """Of the right-hand side, with those of all that it calls."""
    return count(Simulation(given, native=False).method.f_rate)


def count(f):
    return sum(count(n.args[0]) if n.op == "call" else 1 for n in f.nodes if n.op != "in")


def test_a_model_without_pads_spends_no_operations_on_pads():
    every, standing = declared("{}"), declared("{pads: standing}")
    kept = {s.name for s in standing.supports}
    assert len(kept) == len(every.supports) // 2
    written = replace(every, supports=tuple(s for s in every.supports if s.name in kept))
    assert operations(standing) == operations(written) < operations(every)


def test_a_locked_joint_reduces_the_operations_and_states_of_a_scene():
    free, locked = declared("{}"), declared("{locked: [hinges, gantries]}")
    assert operations(locked) < operations(free)
    assert len(Simulation(locked).state) < len(Simulation(free).state)


def test_a_model_without_wind_spends_no_operations_on_wind():
    windy, still = mechanism("gust"), mechanism("gust", "mechanism.forces={}")
    never = System(windy.bodies, windy.joints, ropes=windy.ropes, gravity=windy.gravity)
    assert operations(still) == operations(never) < operations(windy)
    assert code(still) == code(never)


def test_omitted_contacts_cost_no_operations_and_leave_no_code():
    touching, free = mechanism("ramp"), mechanism("ramp", "mechanism.contacts={}")
    never = System(touching.bodies, touching.joints, gravity=touching.gravity)
    assert operations(free) == operations(never) < operations(touching)
    assert code(free) == code(never)


def test_an_omitted_contact_pair_costs_no_operations_and_leaves_no_code():
    slope = "{ramp: {body: crate, box: [2 m, 2 m, 2 m], against: {normal: [0.5, 0, 0.8660254]}, friction: 0.3}}"
    both, one = mechanism("ramp"), mechanism("ramp", f"mechanism.contacts={slope}")
    never = System(both.bodies, both.joints, contacts=both.contacts[:1], gravity=both.gravity)
    assert operations(one) == operations(never) < operations(both)
    assert code(one) == code(never)


def test_each_support_adds_the_same_number_of_operations_to_an_evaluation_of_the_equations():
    standing = declared("{}")
    flying = replace(standing, supports=())
    written = System(**{f.name: getattr(flying, f.name) for f in fields(System) if f.name != "supports"})
    assert operations(flying) == operations(written)
    one = replace(standing, supports=standing.supports[:1])
    assert operations(standing) - operations(flying) == len(standing.supports) * (operations(one) - operations(flying))


def test_a_body_of_two_parts_on_a_locked_joint_costs_as_many_operations_as_one_made_in_one_piece():
    apart, whole = arm("fixed"), arm(None)
    assert operations(apart) == operations(whole) < operations(arm("revolute"))


def test_a_crane_with_a_rigid_girder_equals_a_crane_described_without_elasticity():
    """Its beam taken out of the description by hand, trolleys on straight rails of the main body."""
    bending, rigid = declared("{girder: elastic}"), declared("{girder: rigid}")
    beam = next(b for b in bending.bodies if b.flexible)
    crane = beam.name.removesuffix(".girder")
    straight = tuple(
        Joint(j.name, "prismatic", f"{crane}.main", j.child, axis=(0.0, 1.0, 0.0), q0=j.q0, v0=j.v0)
        if j.kind == "slider"
        else j
        for j in bending.joints
        if j.child != beam.name
    )
    by_hand = replace(bending, bodies=tuple(b for b in bending.bodies if b is not beam), joints=straight)
    assert operations(rigid) == operations(by_hand) < operations(bending)


def arm(elbow):
    """Two links; the joint between them, or None: one body of both."""
    pin = Joint("pin", "revolute", "world", "arm", axis=(0.0, 1.0, 0.0), q0=(0.3,), v0=(0.0,))
    upper = Body("arm", 2.0, (0.0, 0.0, -0.5), ((0.1, 0, 0), (0, 0.1, 0), (0, 0, 0.1)))
    if elbow is None:
        return System((replace(upper, mass=4.0, com=(0.0, 0.0, -1.0)),), (pin,))
    turns = {"q0": (0.2,), "v0": (0.0,)} if elbow == "revolute" else {}
    bend = Joint("elbow", elbow, "arm", "hand", (0.0, 0.0, -1.0), axis=(0.0, 1.0, 0.0), **turns)
    return System((upper, replace(upper, name="hand")), (pin, bend))


def code(given):
    """What two descriptions must have in common to run on the same machine code."""
    return Simulation(given, native=False).native.structure


def test_each_coarser_model_level_needs_fewer_operations_per_evaluation():
    candidates = ("{ropes: massive, lumps: 2, girder: elastic}", "{girder: elastic}", "{}", "{motion: across}")
    costs = [operations(declared(candidate)) for candidate in candidates]
    assert costs == sorted(costs, reverse=True)
    assert len(set(costs)) == len(costs)


def test_a_joint_locked_during_a_run_is_removed_from_the_compiled_equations():
    """The choice is made again: another variant of the code, with less to compute."""
    swing = Joint("pin", "revolute", "world", "arm", axis=(0.0, 1.0, 0.0), q0=(0.3,), v0=(0.0,))
    bend = Joint("elbow", "revolute", "arm", "hand", (0.0, 0.0, -1.0), axis=(0.0, 1.0, 0.0), q0=(0.2,), v0=(0.0,))
    bodies = tuple(Body(n, 2.0, (0.0, 0.0, -0.5), ((0.1, 0, 0), (0, 0.1, 0), (0, 0, 0.1))) for n in ("arm", "hand"))
    arm = System(bodies, (swing, bend), locks=(Lock("hold", "elbow"),))
    free, held = (Program(arm, locked=frozenset(names)) for names in ((), ("hold",)))
    work = [sum(n.op != "in" for n in p.instances[0][1].accelerate.nodes) for p in (free, held)]
    assert work[1] < work[0]
