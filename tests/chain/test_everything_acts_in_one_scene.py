"""Contact, a loop, a lock, a bending beam, a rigid and an elastic rope, springs and wind in one scene file.

Within 60 ms the crate hits its ramp, the plate falls into its rigid rope, and a wheel on a four-bar linkage is locked.
"""

from pathlib import Path

import numpy as np
import pytest
from chain import channel, happenings, play
from heavylift.kernel.description import System
from heavylift.kernel.simulation import Simulation
from heavylift.kernel.simulation.native import channels, published
from heavylift.nodes.scene import parse

SCENE = """\
heavylift: 1
name: everything
accuracy: 1e-4 %
samples: 1 kHz
end: 100 ms
mechanism:
  bodies:
    girder: {beam: {length: 20 m, mass: 4 t, EI y: 5 GN m2, frame: simply supported, modes: 2, damping: 2 %}}
    crank: {mass: 1 t, com: [0, 0, 0.5 m], inertia: [100 kg m2, 100 kg m2, 10 kg m2]}
    coupler: {mass: 1 t, com: [0, 0, 0.5 m], inertia: [100 kg m2, 100 kg m2, 10 kg m2]}
    rocker: {mass: 1 t, com: [0, 0, 0.5 m], inertia: [100 kg m2, 100 kg m2, 10 kg m2]}
    wheel: {mass: 200 kg, inertia: [20 kg m2, 40 kg m2, 20 kg m2]}
    plate: {mass: 3 t, inertia: [3 t m2, 3 t m2, 5 t m2]}
    crate: {mass: 4 t, inertia: [5 t m2, 5 t m2, 5 t m2]}
  joints:
    legs: {type: fixed, child: girder, at: [-10 m, 0, 12 m]}
    a: {type: revolute, child: crank, axis: [0, 1, 0], speed: 1 rad/s}
    b: {type: revolute, parent: crank, child: coupler, at: [0, 0, 1 m], axis: [0, 1, 0], start: 90 deg, speed: -1 rad/s}
    d: {type: revolute, child: rocker, at: [1 m, 0, 0], axis: [0, 1, 0], speed: 1 rad/s}
    c: {type: revolute, parent: rocker, child: coupler, at: [0, 0, 1 m], at child: [0, 0, 1 m], axis: [0, 1, 0]}
    hub: {type: revolute, parent: coupler, child: wheel, at: [0, 0.2 m, 0.5 m], axis: [0, 1, 0], speed: 20 rad/s}
    hang: {type: free, child: plate, at: [0, 0, 6 m]}
    float:
      {type: free, child: crate, at: [20.6006 m, 0, 0.8008 m], attitude: [0, 0.316227766016838, 0, 0.948683298050514]}
  locks:
    bolt: {joint: hub}
  ropes:
    sling: {start: {body: girder, at: [10 m, 0, 0]}, end: {body: plate}, rigid: true, length: 6.002 m}
    stay: {start: {body: girder, at: [15 m, 0, 0]}, end: {body: plate, at: [1 m, 0, 0]}, EA: 1 MN, length: 7.2 m}
  contacts:
    ramp:
      {body: crate, box: [2 m, 3 m, 2 m], against: {at: [20 m, 0, 0], normal: [0.6, 0, 0.8]}, friction: 0.5,
       restitution: 10 %}
  forces:
    link: {type: spring, start: {body: coupler, at: [0, 0, 0.5 m]}, end: {body: plate}, rest: 4 m, stiffness: 2 kN/m}
    gale: {type: wind, body: plate, area: 12 m2, drag: 1.2, direction: [0, 1, 0], gusts: [[0 s, 5 m/s], [1 s, 20 m/s]]}
actions:
  - wait 40 ms
  - bolt: lock
  - wait 30 ms
  - bolt: unlock
"""
MS = 1_000_000
CLOSES = 1e-6  # of the energy that is turned over, at a tolerance of 1e-9
ALIKE = 1e-10  # between states of machine code and floats: the same steps, rounded in another order


def system() -> System:
    (mechanism,) = parse(SCENE).plan.machines
    return mechanism.system


def told(cuts: tuple[int, ...] = (), end: int = 60 * MS) -> Simulation:
    """The story of the actions by hand: the bolt is locked at 40 ms; `cuts` [ns]: where runs are granted until."""
    s = Simulation(system(), tolerance=1e-9, sample_ns=MS)
    s.start()
    for t, lock in ((40 * MS, True), (end, False)):
        for cut in (c for c in cuts if s.epoch <= c < t):
            s.run(cut)
        s.interrupt(t)
        if lock:
            s.set_lock("bolt", True)
        s.settle()
    return s


@pytest.fixture(scope="module")
def story() -> Simulation:
    return told()


@pytest.mark.large
def test_the_energy_balance_closes_over_an_impact_a_rope_snatch_and_a_joint_lock(story: Simulation) -> None:
    assert [(e.name, e.what) for _, e in story.log if e.name in ("sling", "bolt")] == [
        ("sling", "taut"),
        ("bolt", "locked"),
    ]
    assert "closed" in [e.what for _, e in story.log if e.name == "ramp"]
    rows = published(story.method, np.array([row for _, row in story.rows]))
    at = {c.topic: slice(c.start, c.stop) for c in channels(story.method)}
    kinetic, potential, stored, work, heat = rows[:, at["energy"]].T
    total = kinetic + potential + stored - work + heat
    assert np.ptp(total) < CLOSES * max(np.ptp(kinetic), np.ptp(potential), heat.max())
    assert np.abs(story.X[story.method.layout.at["gap"]]).max() < 1e-9


@pytest.mark.large
def test_results_of_the_kernel_do_not_depend_on_how_time_grants_divide_the_run(story: Simulation) -> None:
    cuts = tuple(int(t) for t in np.random.default_rng(3).integers(0, 60 * MS, 40))
    again = told(tuple(sorted(cuts)))
    assert again.log == story.log
    assert again.state.tobytes() == story.state.tobytes()
    assert [(t, row.tobytes()) for t, row in again.rows] == [(t, row.tobytes()) for t, row in story.rows]


@pytest.mark.large
def test_interpreted_python_gives_the_same_results_as_machine_code() -> None:
    """Through the impacts of the crate and the snatch of the sling, at a coarse tolerance: floats are slow."""
    native, oracle = (Simulation(system(), tolerance=1e-4, sample_ns=MS, native=n) for n in (True, False))
    for s in (native, oracle):
        s.start()
        s.run(28 * MS)
    assert [(t, e.name, e.what) for t, e in oracle.log] == [(t, e.name, e.what) for t, e in native.log]
    assert [e.value for _, e in oracle.log] == pytest.approx([e.value for _, e in native.log], rel=1e-9)
    assert ("sling", "taut") in [(e.name, e.what) for _, e in oracle.log]
    assert np.abs(oracle.state - native.state).max() < ALIKE


@pytest.mark.large
def test_distributed_runs_and_runs_in_one_process_write_equal_recordings(tmp_path: Path) -> None:
    one, many = (play(tmp_path, SCENE, in_process=here) for here in (True, False))
    assert one.result["digest"] == many.result["digest"]
    assert float(one.result["energy_error"]) < CLOSES
    assert [h.t for h in happenings(one, "locked", "bolt")] == [0.04]
    assert happenings(one, "taut", "sling")
    t, rate = channel(one, "joint/velocity", "hub.rate")
    assert np.all(rate[(t > 0.041) & (t < 0.069)] == 0.0)
