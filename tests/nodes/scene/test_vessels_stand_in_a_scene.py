"""Vessels of a scene: phase of the wave at their place, permitted load, and responses."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from heavylift.kernel import SceneError
from heavylift.kernel.analysis import modes
from heavylift.kernel.model import Program, evaluate
from heavylift.kernel.simulation import Simulation
from heavylift.nodes.models import system
from heavylift.nodes.scene import load, parse
from lifting import pose

G = 9.80665
WAVES = "waves: {height: 2 m, period: 8 s, heading: 150 deg, ramp: 10 s}\n"
W = 2.0 * np.pi / 8.0
GIVEN = f"""
heavylift: 1
name: sea
end: 20 s
{WAVES}
vessels:
  barge:
    mass: 13200 t
    size: [110 m, 32 m, 8 m]
    draught: 4.5 m
    at: [40 m, -30 m, 0 m]
    responses:
      {{surge: [0.25 m/m, 90 deg], heave: [0.45 m/m, 10 deg], roll: [1.1 deg/m, -70 deg], pitch: [0.5 deg/m, 95 deg]}}
"""
CRANE = "cranes: {crane: {type: pedestal-400, on: barge, at: [0 m, 0 m, 3.5 m], radius: 26 m}}\n"
BLOCK = """
block:
  on: barge
  mass: %s
  size: [12 m, 8 m, 5 m]
  at: [26 m, 0 m, 7 m]
  lugs: {N1: [0 m, 3 m, 2.6 m], N2: [0 m, -3 m, 2.6 m]}
  supports: {height: 4.5 m, at: [[-5 m, -3 m], [5 m, -3 m], [-5 m, 3 m], [5 m, 3 m]]}
"""
FORCES = f"""
heavylift: 1
name: sea
end: 20 s
{WAVES.replace("2 m", "0.02 m").replace("150", "180")}
vessels:
  barge:
    mass: 12000 t
    size: [110 m, 32 m, 8 m]
    draught: 4.5 m
    com: [0.5 m, 0 m, 1 m]
    motion: forces
    floating:
      waterplane: 3200 m2
      GM: 5 m
      GML: 180 m
      mooring: {{surge: 2 MN/m, sway: 3 MN/m, yaw: 900000 kN m/rad}}
      loads:
        {{surge: [1.5 MN/m, 90 deg], heave: [9 MN/m, 20 deg], roll: [30 MN m/m, -80 deg], pitch: [600 MN m/m, 90 deg]}}
      added mass:
        - [1e6, 0, 0, 0, 4e6, 0]
        - [0, 7e6, 0, 2e6, 0, 0]
        - [0, 0, 2e7, 0, 1e7, 0]
        - [0, 2e6, 0, 4e8, 0, 0]
        - [4e6, 0, 1e7, 0, 1.5e10, 0]
        - [0, 0, 0, 0, 0, 7e9]
      damping:
        - [3e5, 0, 0, 0, 0, 0]
        - [0, 2e6, 0, 0, 0, 0]
        - [0, 0, 1.1e7, 0, 2e7, 0]
        - [0, 0, 0, 1.5e8, 0, 0]
        - [0, 0, 2e7, 0, 9e9, 0]
        - [0, 0, 0, 0, 0, 1e9]
"""  # a wave so low that the vessel answers as a linear one


@pytest.mark.parametrize("heading", [0.0, 35.0, -90.0])
def test_the_tip_of_a_crane_on_a_vessel_moves_by_the_response_functions_of_the_vessel(heading: float) -> None:
    """Place and velocity of the boom's tip against R(t) A cos(w t + phase - k x), k = w^2 / g, at some times."""
    given = GIVEN.replace("    responses:", f"    heading: {heading} deg\n    responses:")
    plan = parse(given + CRANE + BLOCK % "180 t" + "actions: [{wait: 1 s}]\n").plan
    (c, s), h = (np.cos(np.radians(heading)), np.sin(np.radians(heading))), pose(plan, "block")
    Rz = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    assert h[:2] == pytest.approx((Rz @ [26.0, 0.0, 0.0] + [40.0, -30.0, 0.0])[:2], abs=1e-9)
    program = Program(system(plan))
    rise = np.sqrt(60.0**2 - 23.0**2)
    tip = np.array([26.0, 0.0, 3.5 + 14.0 + 2.0 + rise])
    late = W * W / G * (40.0 * np.cos(np.radians(150.0)) - 30.0 * np.sin(np.radians(150.0)))

    def place(t: float) -> np.ndarray:
        u = min(t / 10.0, 1.0)
        r = u**3 * (10.0 - 15.0 * u + 6.0 * u * u)
        c = {p: r * np.cos(W * t + np.radians(p) - late) for p in (90, 10, -70, 95)}
        roll, pitch = np.radians(1.1 * c[-70]), np.radians(0.5 * c[95])
        Rx = np.array([[1, 0, 0], [0, np.cos(roll), -np.sin(roll)], [0, np.sin(roll), np.cos(roll)]])
        Ry = np.array([[np.cos(pitch), 0, np.sin(pitch)], [0, 1, 0], [-np.sin(pitch), 0, np.cos(pitch)]])
        distance = Rz @ (np.array([0.25 * c[90], 0.0, 0.45 * c[10]]) + Ry @ Rx @ tip)
        at: np.ndarray = np.array([40.0, -30.0, 0.0]) + distance
        return at

    for t in (4.0, 17.3, 241.0):
        P = program.parameters.initial.copy()
        P[program.parameters.at["clock", ""]] = t
        x = evaluate(program, 0.0, program.initial_state(), P)
        body = np.array(x.ends[program.graph.number("crane.boom")], float)
        R, arm, V = body[:9].reshape(3, 3), body[12:15] + body[:9].reshape(3, 3) @ [60.0, 0.0, 0.0], body[15:]
        assert body[9:12] + arm == pytest.approx(place(t), abs=1e-9), R
        rate = (place(t + 1e-4) - place(t - 1e-4)) / 2e-4
        assert V[3:] + np.cross(V[:3], arm) == pytest.approx(rate, abs=1e-7)


def test_a_load_above_two_percent_of_the_displacement_is_refused_on_a_vessel_with_prescribed_motion() -> None:
    """300 t on 13 796 t, crane included, would move the vessel otherwise; it is said so."""
    with pytest.raises(SceneError) as error:
        parse(GIVEN + CRANE + BLOCK % "300 t" + "actions: [{wait: 1 s}]\n")
    message = (
        "a load of 300 t is more than 2% of its displacement of 13736 t, so its motion would not stay as it is given"
    )
    assert message in str(error.value)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (GIVEN.replace("responses:", "motion: forces\n    responses:"), "motion: forces needs 'floating'"),
        (GIVEN.replace("0.25 m/m", "0.25 deg/m"), "'deg/m'"),
        (GIVEN + (BLOCK % "1 t").replace("on: barge", "on: barje") + CRANE, "there is no vessel 'barje'"),
        (FORCES.replace("[1e6, 0, 0, 0, 4e6, 0]", "[1e6, 0, 0, 0, 5e6, 0]"), "added mass must be a symmetric matrix"),
    ],
)
def test_invalid_vessels_are_refused_in_one_sentence(text: str, told: str) -> None:
    """Each names the place and what to write."""
    with pytest.raises(SceneError, match=r"scene\.yaml:\d+:\d+") as error:
        parse(text)
    assert told in str(error.value)


@pytest.fixture(scope="module")
def matrices() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """M + A, B, K and F per wave amplitude of the vessel in `FORCES`, written down by hand."""
    m, (x, _, z) = 12e6, (0.5, 0.0, 1.0)
    box = m / 12.0 * np.array([32.0**2 + 8.0**2, 110.0**2 + 8.0**2, 110.0**2 + 32.0**2])
    c = np.array([[0, -z, 0], [z, 0, -x], [0, x, 0]])
    M = np.block([[m * np.eye(3), -m * c], [m * c, np.diag(box) - m * c @ c]])
    A = np.diag([1e6, 7e6, 2e7, 4e8, 1.5e10, 7e9])
    A[1, 3] = A[3, 1] = 2e6
    A[0, 4] = A[4, 0] = 4e6
    A[2, 4] = A[4, 2] = 1e7
    B = np.diag([3e5, 2e6, 1.1e7, 1.5e8, 9e9, 1e9])
    B[2, 4] = B[4, 2] = 2e7
    K = np.diag([2e6, 3e6, 1025.0 * G * 3200.0, m * G * 5.0, m * G * 180.0, 9e8])
    size, angle = np.array([1.5e6, 0.0, 9e6, 3e7, 6e8, 0.0]), np.radians([90.0, 0.0, 20.0, -80.0, 90.0, 0.0])
    return M + A, B, K, size * np.exp(1j * angle)


def test_a_free_vessel_responds_to_waves_as_its_linear_equations_predict(matrices: tuple[np.ndarray, ...]) -> None:
    """Amplitude and phase of all motions in the steady state: (K - w^2 (M + A) + i w B) x = F a, solved by NumPy."""
    M, B, K, F = matrices
    want = np.linalg.solve(K - W * W * M + 1j * W * B, 0.01 * F)
    s = Simulation(system(parse(FORCES).plan), 1e-9)
    s.start()
    found, n = np.zeros(6, complex), 16
    for i in range(n):
        t_ns = 800_000_000_000 + 8_000_000_000 * i // n
        s.run(t_ns)
        s.interrupt(t_ns)
        q = np.array(s.row().q) * [1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 0.0]
        found += 2.0 / n * q[:6] * np.exp(-1j * W * t_ns * 1e-9)
        s.settle()
    assert np.abs(found - want).max() < 1e-3 * np.abs(want).max()
    assert np.abs(found[3] / want[3] - 1.0) < 1e-2


def test_natural_periods_of_a_vessel_follow_from_stiffness_and_inertia(matrices: tuple[np.ndarray, ...]) -> None:
    """All six, by the eigenvalues of [[0, 1], [-(M + A)^-1 K, -(M + A)^-1 B]]."""
    M, B, K, _ = matrices
    state = np.block([[np.zeros((6, 6)), np.eye(6)], [-np.linalg.solve(M, K), -np.linalg.solve(M, B)]])
    want = sorted({round(abs(s) / (2.0 * np.pi), 12) for s in np.linalg.eigvals(state) if s.imag > 0.0})
    s = Simulation(system(parse(FORCES).plan), 1e-6)
    s.start()
    s.interrupt(0)
    found = [mode.frequency for mode in modes(s).oscillations]
    assert found == pytest.approx(want, rel=1e-6)


def test_a_vessel_floats_level_with_its_crane() -> None:
    """The water bears hull, crane and block on deck; the hook block of 12 t, 26 m ahead, makes it sink and trim."""
    text = FORCES.replace("com: [0.5 m, 0 m, 1 m]", "com: [0 m, 0 m, 1 m]")
    scene = parse(text + CRANE + BLOCK % "300 t" + "rigging: {legs: {on: crane main, to: [N1, N2], length: 30 m}}\n"
                  "actions: [{wait: 1 s}]\n")  # fmt: skip
    (_, _, z), R = scene.statics.states[0].poses["barge"]
    carried = sum(body.mass for body in system(scene.plan).bodies if body.name != "crane.main")
    assert z == pytest.approx(-12e3 / (1025.0 * 3200.0), rel=1e-3)
    assert R[0][2] == pytest.approx(12e3 * 26.0 / (carried * 180.0), rel=0.02)


def test_turning_a_vessel_and_its_wave_together_does_not_change_the_response() -> None:
    """Free in the water, its motions along its own axes are the same, to what the integration allows."""
    found = []
    for heading in (0, 40):
        text = FORCES.replace("motion: forces", f"heading: {heading} deg\n    motion: forces")
        s = Simulation(system(parse(text.replace("heading: 180", f"heading: {180 + heading}")).plan), 1e-8)
        s.start()
        s.run(15_000_000_000)
        s.interrupt(15_000_000_000)  # steps end elsewhere
        row, angle = s.row(), np.radians(heading)
        R = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
        own = row.poses.reshape(-1, 12)[0]
        found.append(np.concatenate([R.T @ own[:3], (R.T @ own[3:].reshape(3, 3)).ravel()]))
    assert np.abs(found[0][:3]).max() > 1e-3, "it moves"
    assert found[1] == pytest.approx(found[0], abs=1e-7)


def test_vessels_of_all_lifts_in_a_scene_share_one_sea(tmp_path: Path) -> None:
    """The wave meets a vessel of an instance where it is put, with the phase of one that stands there alone."""
    (tmp_path / "sea.yaml").write_text(GIVEN + "actions: [{wait: 1 s}]\n")
    (tmp_path / "yard.yaml").write_text("heavylift: 1\nname: yard\nlifts: {a: {extends: sea.yaml, at: [5 m, 90 m]}}\n")
    alone = parse(GIVEN.replace("[40 m, -30 m, 0 m]", "[45 m, 60 m, 0 m]") + "actions: [{wait: 1 s}]\n").plan
    (one,), (other,) = load(tmp_path / "yard.yaml").plan.machines, alone.machines
    assert one.system.joints[0].p_PJ == other.system.joints[0].p_PJ
    phases = [[drive.wave.phase for drive in machine.system.drives if drive.wave] for machine in (one, other)]
    assert len(phases[0]) == 6
    assert phases[0] == pytest.approx(phases[1], abs=1e-12)
