"""The four-link arm of the paper's Fig. 2: golden accelerations and joint forces (C19b).

Joint forces are measured with force cells: pairs of massless sliding joints, held still by prescribed drives, between
each link and its hinge.  What holds a cell is the force of the hinge.
"""

import json
from pathlib import Path

import numpy as np
import pytest
from heavylift.kernel.description import WORLD, Body, Drive, Joint, System
from heavylift.kernel.multibody import build_graph, cut
from heavylift.kernel.multibody.dynamics import dynamics
from heavylift.kernel.simulation import Simulation

FORMS = json.loads((Path(__file__).parents[2] / "data" / "closed_forms.json").read_text())
C19B = next(x for x in FORMS if x["id"] == "C19b")
GIVEN, WANT = C19B["given"], C19B["expected"]
PARENT = (-1, 0, 0, 2)
PRECISE = 1e-9  # relative, as the closed form asks


def arm(cells: bool = False, at_rest: bool = False) -> System:
    """Slender links along x, hinges about -y (positive angles lift), each at its parent's end."""
    bodies, joints, drives = [], [], []
    for i, p in enumerate(PARENT):
        m, l = GIVEN["m"][i], GIVEN["l"][i]
        on, end = (WORLD, 0.0) if p < 0 else (f"link{p}", GIVEN["l"][p])
        if cells:
            for name, axis in ((f"x{i}", (1.0, 0.0, 0.0)), (f"z{i}", (0.0, 0.0, 1.0))):
                bodies.append(Body(name, 0.0))
                joints.append(Joint(f"slide-{name}", "prismatic", on, name, (end, 0.0, 0.0), axis=axis))
                drives.append(Drive(f"hold-{name}", f"slide-{name}", "prescribed"))
                on, end = name, 0.0
        slender = ((0.0, 0.0, 0.0), (0.0, m * l * l / 12.0, 0.0), (0.0, 0.0, m * l * l / 12.0))
        bodies.append(Body(f"link{i}", m, (l / 2.0, 0.0, 0.0), slender))
        v0 = 0.0 if at_rest else GIVEN["qd"][i]
        joints.append(
            Joint(
                f"hinge{i}", "revolute", on, f"link{i}", (end, 0.0, 0.0),
                axis=(0.0, -1.0, 0.0), q0=(GIVEN["q"][i],), v0=(v0,),
            )
        )  # fmt: skip
        if at_rest:
            drives.append(Drive(f"hold-hinge{i}", f"hinge{i}", "prescribed"))
    return System(tuple(bodies), tuple(joints), drives=tuple(drives))


def reactions(system: System) -> dict[str, float]:
    """What each prescribed joint carries."""
    graph = build_graph(system)
    (tree,) = cut(graph, {graph.coordinate(d.name, d.joint)[1] for d in system.drives})
    q = np.array([x for k in graph.links for x in k.joint.q0 or (0.0,)])
    v = np.array([x for k in graph.links for x in k.joint.v0 or (0.0,)])
    still = np.zeros(len(tree.prescribed_dofs))
    W = [np.zeros(6)] * len(tree.bodies)
    *_, forces = dynamics(tree, q, v, np.zeros(graph.nv), W, system.gravity, still)
    names = [k.joint.name for k, b in zip(graph.links, tree.bodies, strict=True) if b.prescribed]
    return dict(zip(names, map(float, forces), strict=True))


@pytest.mark.parametrize("native", [True, False])
def test_the_four_link_arm_has_the_published_joint_accelerations(native):
    simulation = Simulation(arm(), native=native)
    simulation.start()
    f = simulation.X[simulation.method.layout.at["f"]]
    assert f[4:8] == pytest.approx(WANT["qdd"], rel=PRECISE)


def test_the_four_link_arm_has_the_published_joint_forces():
    F = reactions(arm(cells=True))
    angle = [GIVEN["q"][0]]
    for i in (1, 2, 3):
        angle.append(angle[PARENT[i]] + GIVEN["q"][i])
    for i, p in enumerate(PARENT):
        a = 0.0 if p < 0 else angle[p]  # a cell lies in its parent's axes
        x, z = F[f"slide-x{i}"], F[f"slide-z{i}"]
        world = (x * np.cos(a) - z * np.sin(a), x * np.sin(a) + z * np.cos(a))
        assert world == pytest.approx(WANT["F_c"][i], rel=PRECISE)


def test_the_base_of_the_resting_four_link_arm_carries_its_weight():
    F = reactions(arm(cells=True, at_rest=True))
    assert F["slide-z0"] == pytest.approx(WANT["total_weight"], rel=1e-14)
    assert F["slide-x0"] == pytest.approx(0.0, abs=1e-9)
    assert WANT["base_force_at_rest_right"] == WANT["total_weight"]
