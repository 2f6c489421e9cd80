"""Modal beams bend and vibrate by beam theory, alone and with attached loads and ropes."""

from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest
from heavylift.kernel.analysis import equilibrium, modes
from heavylift.kernel.description import Beam, Body, Flexible, Joint, Line, Nodal, Point, Rope, System
from heavylift.kernel.model import Program, evaluate
from heavylift.kernel.multibody.flexible import beam_matrices, nodes_of
from heavylift.kernel.simulation.native import channels
from scipy.optimize import fsolve
from small_scenes import SECOND, G, Z, column, hand_over, imbalance, started

# C18 of the closed forms: the girder of a 900 t goliath crane and its rope
LENGTH, EI, GIRDER, P = 150.0, 4137180468750.0, 2.5e6, 8825985.0
MASS, ROPE, FALL = P / G, 62339200.0, 60.0
STATIC, FREQUENCY = 0.005, 0.01  # accepted there
ELEMENTS = 1e-5  # what 32 elements leave of the lowest modes
EXACT = 1e-6  # round-off of matrices whose elements span eight decades

MID = LENGTH / 2
BEAM = Beam(LENGTH, GIRDER / LENGTH, EI_y=EI)
SIMPLE = Flexible(3, BEAM, frame="simply supported")


def girder(flexible=SIMPLE, load=0.0, rope=False):
    """A girder over the ground; a load sits on it, or hangs in a rope on a guide."""
    bodies, joints = [Body("girder", 0.0, flexible=flexible)], [Joint("legs", "fixed", "world", "girder")]
    ropes = ()
    if load:
        bodies.append(Body("load", load))
        on = Joint("seat", "fixed", "girder", "load", (MID, 0.0, 0.0))
        guide = Joint("guide", "prismatic", "world", "load", (MID, 0.0, 0.0), axis=Z, q0=(-1.05 * FALL,))
        joints.append(guide if rope else on)
    if rope:
        ropes = (Rope("rope", (Line(Point("girder", (MID, 0.0, 0.0)), Point("load")),), ROPE * FALL, FALL),)
    return System(tuple(bodies), tuple(joints), ropes=ropes, gravity=G)


def accelerations(program):
    P_ = program.parameters.initial.copy()
    for (kind, _), at in program.parameters.at.items():
        if kind == "rope":
            P_[at][3] = 1.0  # taut

    def a(q):
        y = np.concatenate([q, np.zeros(program.ny - program.nq)])
        return np.asarray(evaluate(program, 0.0, y, P_).dy[program.nq : program.nq + program.nv], float)

    return a


def at_rest(program):
    q, _, found, why = fsolve(accelerations(program), program.initial_state()[: program.nq], full_output=True)
    assert found == 1, why
    return q


def frequencies(program, q):
    """[Hz] of small motion about q, by central differences."""
    a, h = accelerations(program), 1e-5
    J = np.array([(a(q + h * e) - a(q - h * e)) / (2 * h) for e in np.eye(len(q))]).T
    return np.sort(np.sqrt(-np.linalg.eigvals(J).real)) / (2 * pi)


def sag(program, x=MID):
    """Deflection of a station [m], downwards."""
    link = program.graph.links[program.graph.number("girder")]
    return -float((link.modes.at(x) @ at_rest(program)[link.q_modes])[2])


def test_the_sag_of_a_loaded_girder_agrees_with_beam_theory():
    own = sag(Program(girder()))
    assert own == pytest.approx(5 * GIRDER * G * LENGTH**3 / (384 * EI), rel=STATIC)
    assert sag(Program(girder(load=MASS))) - own == pytest.approx(0.15, rel=STATIC)


def test_a_girder_has_its_exact_frequencies_alone_with_a_load_and_in_series_with_a_rope():
    alone = Program(girder())
    assert frequencies(alone, at_rest(alone))[0] == pytest.approx(1.0999304296178403, rel=ELEMENTS)
    loaded = Program(girder(load=MASS))
    assert frequencies(loaded, at_rest(loaded))[0] == pytest.approx(0.8396035320978033, rel=FREQUENCY)
    series = Program(girder(load=MASS, rope=True))
    lowest = frequencies(series, at_rest(series))[:2]
    assert lowest[0] == pytest.approx(0.7628733033269092, rel=FREQUENCY)
    # C18 takes 17/35 of the mass, the shape of the static sag; half of it, the first mode, is nearer to the second one
    k, m = pi**4 * EI / (2 * LENGTH**3), GIRDER / 2
    two = np.array([[(k + ROPE) / m, -ROPE / m], [-ROPE / MASS, ROPE / MASS]])
    assert lowest[1] == pytest.approx(np.sqrt(np.linalg.eigvals(two).max()) / (2 * pi), rel=FREQUENCY)
    assert lowest[1] == pytest.approx(1.923635237492667, rel=2 * FREQUENCY)


def test_a_girder_reduces_the_stiffness_of_the_rope_that_hangs_on_it():
    """The load hangs lower by P/k of the girder and P/k of the rope; the girder's own sag is no part of that."""
    hanging, empty = Program(girder(load=MASS, rope=True)), Program(girder())
    drop = -at_rest(hanging)[-1] - FALL - sag(empty)
    assert drop == pytest.approx(P / 30269512.598129544, rel=STATIC)


def test_statics_and_modes_of_a_scene_include_the_elasticity_of_its_girder():
    s = started(girder(load=MASS, rope=True))
    rest = equilibrium(s)
    assert rest.q == pytest.approx(at_rest(s.program), rel=1e-6, abs=1e-9)
    found = modes(s).oscillations[:2]
    assert [m.frequency for m in found] == pytest.approx(frequencies(s.program, rest.q)[:2], rel=1e-4)
    shares = dict(found[0].bodies)
    assert sum(shares.values()) == pytest.approx(1.0)
    along = 1.0 - (2 * pi * found[0].frequency) ** 2 * MASS / ROPE  # how far the girder moves with the load
    assert shares["girder"] / shares["load"] == pytest.approx(GIRDER / 2 * along**2 / MASS, rel=0.02), "half its mass"


@pytest.mark.parametrize(
    ("frame", "roots"),
    [
        ("clamped", (1.8751040687, 4.6940911330, 7.8547574382)),
        ("simply supported", (pi, 2 * pi, 3 * pi)),
        ("free", (4.7300407449, 7.8532046241, 10.995607838)),
    ],
)
def test_uniform_beams_have_their_exact_bending_frequencies(frame, roots):
    body = Body("girder", 0.0, flexible=Flexible(3, BEAM, frame=frame))
    joint = Joint("legs", "free" if frame == "free" else "fixed", "world", "girder")
    system = System((replace(body, inertia=((1.0, 0.0, 0.0), *body.inertia[1:])),), (joint,), gravity=0.0)
    program = Program(system)
    link = program.graph.links[0]
    found = np.sqrt(link.modes.stiffness / link.modes.mass)
    want = [(b / LENGTH) ** 2 * sqrt(EI / BEAM.mass_per_length) for b in roots]
    assert found == pytest.approx(want, rel=5 * ELEMENTS)


def test_a_clamped_beam_has_its_exact_axial_and_torsional_frequencies():
    beam = Beam(10.0, 80.0, EA=2e9, GJ=3e6, polar=5.0, elements=64)
    twist = Program(replace(girder(Flexible(2, beam)), gravity=0.0)).graph.links[0].modes
    torsion, axial = pi / 20.0 * sqrt(3e6 / 5.0), pi / 20.0 * sqrt(2e9 / 80.0)
    assert np.sqrt(twist.stiffness / twist.mass) == pytest.approx([torsion, 3 * torsion], rel=1e-3)
    stiff = Program(girder(Flexible(1, replace(beam, GJ=0.0)))).graph.links[0].modes
    assert np.sqrt(stiff.stiffness / stiff.mass) == pytest.approx([axial], rel=1e-4)


@pytest.mark.parametrize(("loads", "error"), [((), 0.03), ((LENGTH,), EXACT)])
def test_one_eigenmode_misses_three_percent_of_a_tip_deflection_and_a_static_mode_is_exact(loads, error):
    program = Program(girder(Flexible(1, BEAM, loads=loads)))
    bent = program.graph.links[0].modes
    tip = bent.at(LENGTH)[2]
    assert tip @ (tip / bent.stiffness) == pytest.approx(LENGTH**3 / (3 * EI), rel=error)
    assert bool(loads) or tip @ (tip / bent.stiffness) < 0.98 * LENGTH**3 / (3 * EI)


def test_a_beam_given_by_its_matrices_equals_the_described_beam():
    beam = replace(BEAM, elements=12)
    M, K = beam_matrices(beam)
    bending = [d for d in range(len(M)) if d % 6 in (2, 4)]
    held = tuple(d for d in range(len(M)) if d not in bending or d in (2, len(M) - 4))
    nodes = tuple(tuple(map(float, p)) for p in nodes_of(beam))
    nodal = Nodal(nodes, tuple(map(tuple, M.tolist())), tuple(map(tuple, K.tolist())), held)
    given = Program(girder(Flexible(3, nodal=nodal), load=MASS))
    built = Program(girder(replace(SIMPLE, beam=beam), load=MASS))
    q = np.array([0.1, 0.02, -0.03])
    assert accelerations(given)(q) == pytest.approx(accelerations(built)(q), rel=1e-5)  # matrices know no shortening
    shapes = given.graph.links[0].modes.shapes[:, :2]
    taken = Flexible(2, nodal=replace(nodal, modes=tuple(map(tuple, shapes.tolist()))))
    assert Program(girder(taken)).graph.links[0].modes.stiffness == pytest.approx(
        built.graph.links[0].modes.stiffness[:2], rel=1e-9
    )


def test_a_load_on_a_damped_girder_settles_with_a_closed_energy_balance():
    """Vibration at the loaded frequency with the decay of the damping ratio, and the sag of rest at the end."""
    system = girder(replace(SIMPLE, modes=1, damping=0.1), load=MASS)
    s = started(system, tolerance=1e-10, sample_ns=10_000_000, h_max=0.01)
    hand_over(s, 30 * SECOND)
    assert imbalance(s) < 1e-9
    t, q = column(s, "joint/position")
    rest = at_rest(s.program)
    assert q[-1, 0] == pytest.approx(rest[0], rel=1e-3)
    above = q[:, 0] - rest[0]
    rises = t[1:][(above[:-1] < 0) & (above[1:] >= 0)]
    f = frequencies(s.program, rest)[0]
    assert np.diff(rises[:6]) == pytest.approx(1 / f, rel=0.02)
    assert next(c.names for c in channels(s.method) if c.topic == "joint/position") == ("girder.mode1",)
