"""One lift on every model level: rigid to massive ropes, stiff and bending girder, spatial and planar."""

from dataclasses import replace
from math import pi, sin, sqrt

import msgspec
import numpy as np
import pytest
from heavylift.coordinator.participants import paused
from heavylift.kernel import ModelError, SceneError
from heavylift.kernel.analysis import equilibrium, modes
from heavylift.kernel.simulation import Simulation
from heavylift.nodes.models import build_one, system
from heavylift.nodes.scene import load
from lifting import cranes

RUNGS = (
    "{ropes: rigid}",
    "{slings: rigid}",
    "{ropes: rigid, slings: rigid, motion: across}",
    "{locked: [hinges, gantries]}",
    "{motion: across}",
    "{girder: elastic}",
    "{girder: elastic, motion: across}",
    "{girder: elastic, locked: [trolleys]}",
    "{ropes: massive}",
    "{ropes: massive, lumps: 7, girder: elastic, motion: across}",
)
QUIET = 1e-5  # [m/s, rad/s] what rounding and the pads' settling leave
SETTLES = 5e-3  # [m/s] on a girder that slopes, a trolley settles by half a millimetre into its servo
SAME_PLANE = 1e-4  # relative: the accuracy that the scene asks for; it is its own mirror image
ONE_MODE = 2e-4  # relative: finite elements of the beam against its sine


def lift(*fidelity: str, still: bool = False):
    """The bundled lift on a candidate; `still`: nothing is ordered."""
    quiet = ["actions=[{wait: 10 s}]", "end=4 s"] if still else []
    return load("lift", [*(f"fidelity={f}" for f in fidelity), *quiet])


@pytest.mark.parametrize("rung", RUNGS)
@pytest.mark.large(beyond=1)
def test_no_machine_moves_before_it_receives_its_first_order(rung):
    s = paused(lift(rung, still=True), at=3.0)
    speeds = s.state[s.program.graph.nq :][: s.program.graph.nv]
    assert np.abs(speeds).max() < (SETTLES if "elastic" in rung else QUIET)


def test_the_system_compiled_at_a_model_level_does_not_contain_the_parts_that_the_level_omits():
    count = {r: len(system(lift(r).plan).joints) for r in ("{}", "{locked: [hinges]}", "{ropes: massive}")}
    assert count["{ropes: massive}"] == count["{}"] + 3 * 4 * 3  # ropes, lumps, joints of each
    hinges = [j.kind for j in system(lift("{locked: [hinges]}").plan).joints if "hinge" in j.name]
    assert hinges == ["fixed"] * 3
    rigid = system(lift("{ropes: rigid, slings: rigid}").plan)
    assert (len(rigid.ropes), len(rigid.rigid_ropes)) == (0, 9)


def test_a_girder_without_load_swings_at_its_frequency():
    """w^2 = (pi^4 / 2 * k / 48) / (m / 2 + sum of trolley masses * sin^2(pi y / L))."""
    plan = lift("{girder: elastic, locked: [trolleys, gantries]}", still=True).plan
    crane = cranes(plan)[0]
    s = Simulation(replace(build_one(plan, crane.name).declare(), thresholds=(), ropes=()))
    s.start()
    equilibrium(s)
    (girder,), (lower, _, upper) = crane.girders, crane.system.bodies  # in the order of their names, as actuators are
    trolleys = zip(crane.actuators[1:3], (lower, upper), strict=True)
    mass = girder.mass / 2.0 + sum(t.mass * sin(pi * at.start / girder.span) ** 2 for at, t in trolleys)
    want = sqrt(pi**4 / 2.0 * girder.stiffness / 48.0 / mass) / (2.0 * pi)
    assert modes(s).oscillations[0].frequency == pytest.approx(want, rel=ONE_MODE)


def test_a_heavy_rope_carries_its_own_weight_and_its_load():
    """At the hook, the tension is the weight of what hangs on it; at the trolley, that of the whole rope more."""
    scene = lift("{ropes: massive, lumps: 5}", still=True)
    row = paused(scene, at=3.0).row()
    plan, names = scene.plan, [r.name for r in system(scene.plan).ropes]
    tension = dict(zip(names, row.tension, strict=True))
    hook, rope = cranes(plan)[0].hooks[0], cranes(plan)[0].system.ropes[0]
    lumps = [hook.line * rope.L0 / 5.0] * 5
    for i, name in enumerate((*(f"{rope.name}~{i}" for i in range(1, 6)), rope.name), 1):
        below = hook.below + sum(lumps[i - 1 :])
        assert tension[name] == pytest.approx(below * plan.gravity, rel=1e-6)


def test_a_symmetric_lift_stays_in_its_plane():
    """Nothing pulls the bundled lift along the rails, so that the planar model loses nothing."""
    space, plane = (paused(lift(f), after="sideways").row() for f in ("{}", "{motion: across}"))
    assert plane.tension == pytest.approx(space.tension, rel=SAME_PLANE)


def test_an_order_to_a_locked_joint_ends_the_run_with_a_one_sentence_error():
    """As an operator gives it."""
    given = lift("{}")
    locked = msgspec.structs.replace(given.plan.fidelity, locked=("crane.upper-slide", "crane.lower-slide"))
    scene = replace(given, plan=msgspec.structs.replace(given.plan, fidelity=locked))
    with pytest.raises(
        ModelError, match=r"lift.yaml:55:5: crane.upper-slide cannot move: it is held by 'locked' of 'fidelity'"
    ):
        paused(scene, after="sideways")


def test_unknown_joints_cannot_be_locked():
    with pytest.raises(SceneError, match=r"no joint 'hinge' to lock.*(?s:.)*hinges"):
        lift("{locked: [hinge]}")
