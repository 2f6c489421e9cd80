"""What a rung leaves out leaves no trace in the code: operations of one evaluation, counted."""

from dataclasses import replace

from heavylift.kernel.describe import Body, Joint, Lock, System
from heavylift.kernel.rate import Program
from heavylift.kernel.simulation import Simulation
from heavylift.nodes.models import system
from heavylift.nodes.scene import load


def declared(fidelity):
    return replace(system(load("lift", [f"fidelity={fidelity}"]).plan), thresholds=())


def operations(given):
    """Of the right-hand side, with those of all that it calls."""
    return count(Simulation(given).method.f_rate)


def count(f):
    return sum(count(n.args[0]) if n.op == "call" else 1 for n in f.nodes if n.op != "in")


def test_pads_that_are_left_out_are_as_if_never_written():
    every, standing = declared("{}"), declared("{pads: standing}")
    kept = {s.name for s in standing.supports}
    assert len(kept) == len(every.supports) // 2
    written = replace(every, supports=tuple(s for s in every.supports if s.name in kept))
    assert operations(standing) == operations(written) < operations(every)


def test_a_locked_joint_is_as_if_its_bodies_were_one():
    free, locked = declared("{}"), declared("{locked: [hinges, gantries]}")
    assert operations(locked) < operations(free)
    assert len(Simulation(locked).state) < len(Simulation(free).state)


def test_each_rung_down_costs_less():
    rungs = ("{ropes: massive, lumps: 2, girder: elastic}", "{girder: elastic}", "{}", "{motion: across}")
    costs = [operations(declared(rung)) for rung in rungs]
    assert costs == sorted(costs, reverse=True)
    assert len(set(costs)) == len(costs)


def test_a_joint_that_is_locked_in_mid_run_leaves_the_equations():
    """The choice is made again: another variant of the code, with less to compute."""
    swing = Joint("pin", "revolute", "world", "arm", axis=(0.0, 1.0, 0.0), q0=(0.3,), v0=(0.0,))
    bend = Joint("elbow", "revolute", "arm", "hand", (0.0, 0.0, -1.0), axis=(0.0, 1.0, 0.0), q0=(0.2,), v0=(0.0,))
    bodies = tuple(Body(n, 2.0, (0.0, 0.0, -0.5), ((0.1, 0, 0), (0, 0.1, 0), (0, 0, 0.1))) for n in ("arm", "hand"))
    arm = System(bodies, (swing, bend), locks=(Lock("hold", "elbow"),))
    free, held = (Program(arm, locked=frozenset(names)) for names in ((), ("hold",)))
    work = [sum(n.op != "in" for n in p.instances[0][1].accelerate.nodes) for p in (free, held)]
    assert work[1] < work[0]
