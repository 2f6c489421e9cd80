"""Vessels that follow their own response to the waves: against the frequency domain, and against the full equations."""

from __future__ import annotations

from pathlib import Path

import heavylift
import numpy as np
import pytest
from heavylift.coordinator.ladder import Ladder, ModelLevel, at_level
from heavylift.coordinator.record import play
from heavylift.coordinator.run import run
from heavylift.kernel import KernelError, SceneError
from heavylift.kernel.description import Load
from heavylift.kernel.simulation import Simulation
from heavylift.nodes.models import system
from heavylift.nodes.models.levels import STEP
from heavylift.nodes.plan import Fidelity, Plan
from heavylift.nodes.scene import LoadedScene, load, parse
from test_hulls_in_waves import answer, hull, scene

GIVEN, FLAT = Fidelity(water="motion given"), Fidelity(water="one frequency")
EXACT = 1e-9  # relative: the same linear equations
LINEAR = 5e-3  # of the largest motion of a kind: what a wave of 2 cm moves that is not linear
NEAR_ROLL = 3e-2  # near resonance in roll the hook block below the boom, 1e-3 of the restoring moment, counts
MODES = ("surge", "sway", "heave", "roll", "pitch", "yaw")


def amplitudes(of: Plan, name: str = "barge") -> np.ndarray:
    """(6,) complex amplitudes of the joints of the vessel."""
    waves = {drive.name: drive.wave for drive in system(of).drives}
    return np.array([(x := waves[f"{name}.{mode}.drive"]).amplitude * np.exp(1j * x.phase) for mode in MODES])


@pytest.mark.parametrize("seed", range(5))
def test_a_vessel_with_prescribed_motion_moves_in_waves_from_any_side_by_its_response_functions(seed: int) -> None:
    random = np.random.default_rng(seed)
    to, bow, period = (float(x) for x in random.uniform((-180.0, -180.0, 4.0), (180.0, 180.0, 16.0)))
    plan = parse(scene(f"height: 2 cm, period: {period!r} s", f"{to!r} deg", f"{bow!r} deg")).plan
    want = 0.01 * answer(hull(), 2.0 * np.pi / period, np.radians(to - bow))
    for kind in (slice(0, 3), slice(3, 6)):
        assert amplitudes(at_level(plan, GIVEN))[kind] == pytest.approx(
            want[kind], abs=EXACT * np.abs(want[kind]).max()
        )


@pytest.mark.parametrize(("period", "to"), [(6.0, 150.0), (10.0, 90.0)])
def test_a_vessel_with_prescribed_response_to_waves_is_always_where_the_freely_floating_vessel_is(
    period: float, to: float
) -> None:
    """A quarter of an hour after the start, in amplitude and phase."""
    w, poses = 2.0 * np.pi / period, []
    times = 900.0 + period * np.arange(16) / 16.0
    for level in (Fidelity(), GIVEN):
        plan = parse(scene(f"height: 2 cm, period: {period} s", f"{to} deg").replace("400 s", "2000 s")).plan
        s = Simulation(system(at_level(plan, level)), 1e-8)
        s.start()
        rows = np.array([placed(s, t) for t in times])
        poses.append(rows - rows.mean(axis=0))
    want = np.real(np.outer(np.exp(1j * w * times), 0.01 * answer(hull(), w, np.radians(to))))
    for kind in (slice(0, 3), slice(3, 6)):
        size = LINEAR * np.abs(want[:, kind]).max()
        assert poses[1][:, kind] == pytest.approx(want[:, kind], abs=size)
        assert poses[0][:, kind] == pytest.approx(poses[1][:, kind], abs=2.0 * size)


def placed(s: Simulation, t: float) -> np.ndarray:
    """(6,) displacements and small rotations of the barge at a time."""
    s.run(round(t * 1e9))
    s.interrupt(round(t * 1e9))
    pose = s.row().poses.reshape(-1, 12)[s.program.graph.number("barge")]
    s.settle()
    R = pose[3:].reshape(3, 3)
    return np.array([*pose[:3], R[2, 1], -R[2, 0], R[1, 0]])


def test_the_prescribed_motion_in_an_irregular_sea_is_the_sum_of_the_responses_to_its_waves() -> None:
    """Each harmonic of a short-crested sea by the frequency domain, at random instants."""
    loaded = parse(scene("seas: {a: {Hs: 1 m, Tp: 7 s, components: 30, spreading: 2}}", "200 deg", "35 deg", seed=4))
    drives = {d.name: d.waves for d in system(at_level(loaded.plan, GIVEN)).drives}
    sea = loaded.scene.waves.harmonics(4)
    for t in np.random.default_rng(1).uniform(50.0, 400.0, 4):
        each = [x.amplitude * np.exp(1j * (x.frequency * t + x.phase))
                * answer(hull(), x.frequency, x.direction - np.radians(35.0)) for x in sea]  # fmt: skip
        want = np.sum(each, axis=0).real
        for k, mode in enumerate(MODES):
            x = drives[f"barge.{mode}.drive"]
            turned = np.array(x.frequencies) * t
            found = float(np.cos(turned) @ x.cosines + np.sin(turned) @ x.sines)
            assert found == pytest.approx(want[k], abs=EXACT * np.abs(each).sum())


def light() -> LoadedScene:
    """The scene `moored` with a load of 1 t and a hook block of 3 t."""
    changes = ["block.mass=1 t", "vessels.barge.mass=13895 t", "actions=[{wait: 1 s}]", "end=200 s", "samples=4 Hz"]
    return load("moored", changes)


def test_a_crane_with_a_light_load_moves_equally_on_a_freely_floating_vessel_and_with_prescribed_motion() -> None:
    """Heave of barge and hook agree, in phase, when the start has decayed."""
    runs = [play(at_level(light().plan, level)).past.part(0, 800) for level in (Fidelity(), GIVEN)]
    for body in ("barge", "crane.main"):
        free, given = (x.poses[body][400:, 2] - x.poses[body][400:, 2].mean() for x in runs)
        assert np.std(free - given) < LINEAR * np.std(free)


def test_the_prescribed_motion_of_a_moored_crane_vessel_is_that_of_the_linear_model_of_the_whole_lift() -> None:
    """The kernel's own linearisation, of all bodies, catenaries and states of the water, from loads to poses."""
    loaded = light()
    poses = [f"pose/barge/{axis}" for axis in ("x", "y", "z", "qx", "qy", "qz")]
    model = heavylift.linearise(loaded, [f"barge.{mode} wave" for mode in MODES], poses)
    drives = {d.name: d.waves for d in system(at_level(loaded.plan, GIVEN)).drives}
    forces = {f.name: f.signal.waves for m in loaded.plan.machines for f in m.system.forces if isinstance(f, Load)}
    named = [drives[f"barge.{mode}.drive"] for mode in MODES], [forces[f"barge.{mode} wave"] for mode in MODES]
    found, loads = (np.array([np.array(x.cosines) - 1j * np.array(x.sines) for x in rows]) for rows in named)
    whole = np.eye(len(model.A))
    for i, w in enumerate(drives["barge.heave.drive"].frequencies):
        want = (model.C @ np.linalg.solve(1j * w * whole - model.A, model.B) + model.D) @ loads[:, i]
        want[3:] *= 2.0  # of a quaternion
        for kind, close in ((slice(0, 3), LINEAR), (slice(3, 6), NEAR_ROLL)):
            assert found[kind, i] == pytest.approx(want[kind], abs=close * np.abs(found[kind]).max())


def test_prescribed_vessel_motion_is_a_model_level_only_for_scenes_with_vessels_in_waves() -> None:
    for name, there in (("moored", True), ("floating", False), ("lift", False)):
        ladder = Ladder(load(name).plan)
        assert ("motion given" in {x.water for x in ladder.compared}) is there
        assert "motion given" not in {x.water for x in ladder.plausible}
    level = ModelLevel(at_level(load("moored").plan, GIVEN))
    assert level.level == "elastic ropes, rigid girder, motion of vessels given"
    assert "drift of vessels, and their motion under loads" in level.left_out
    assert "motion of vessels given" not in ModelLevel(at_level(load("floating").plan, GIVEN)).left_out


AFLOAT = (
    "vessels.barge={mass: 13716 t, size: [110 m, 32 m, 8 m], draught: 4 m, com: [0 m, 0 m, 1 m], motion: forces, "
    "floating: {hydrodynamics: barge-110, mooring: {surge: 400 kN/m, sway: 400 kN/m, yaw: 400 MN m/rad}}}"
)
LIFTS = [("floating", [AFLOAT], (0.02, 0.05)), ("moored", [], (1e-3, 1e-3))]


@pytest.mark.parametrize(("name", "changes", "limits"), LIFTS)
def test_simplified_water_models_change_the_largest_hook_load_little_and_more_for_heavier_loads(
    name: str, changes: list[str], limits: tuple[float, float]
) -> None:
    """180 t of 14 432 t in waves of 1.5 m, and 120 t in an irregular sea of 0.5 m, against memory."""
    plan = load(name, changes).plan
    full, *less = (play(at_level(plan, x)).peaks["crane.main"].tension for x in (Fidelity(), FLAT, GIVEN))
    for found, most in zip(less, limits, strict=True):
        assert 0.0 < abs(found / full - 1.0) < most


def test_a_lift_runs_in_a_scene_that_gives_the_motion_of_its_vessel(tmp_path: Path) -> None:
    given = load("moored", ["fidelity={water: motion given}"])
    result = run(given, tmp_path / "moored.mcap", in_process=True)
    assert result.verdict.state != "red"
    assert result.energy_error < 0.01


def test_a_vessel_of_given_motion_takes_no_heavy_load() -> None:
    """10 % of its displacement: on the free vessel the lift is allowed."""
    heavy = ["block.mass=1400 t", "vessels.barge.mass=12496 t"]
    load("moored", heavy)
    with pytest.raises(
        SceneError, match=r"fidelity.water: a load of 14\d\d(\.\d+)? t is more than 2% of its displacement"
    ):
        load("moored", [*heavy, "fidelity={water: motion given}"])


ROWS = "[[0 deg, 1, 0, 0], [90 deg, 0, 1, 0], [180 deg, -1, 0, 0]]"
STREAM = f"{{area: 400 m2, length: 110 m, height: 0 m, coefficients: {ROWS}}}"
FENDER = (
    "fenders={quay: {at: [0, -16 m, 0], meets: [0, -16 m, 0], stiffness: 4 MN/m, vessel: barge, facing: [0, 1, 0]}}"
)


def test_what_does_not_move_a_vessel_of_given_motion_is_listed_as_not_checked() -> None:
    acting = [f"vessels.barge.floating.{of}={STREAM}" for of in ("current", "wind")]
    ends = "start: {body: world, at: [0, 40 m, 0]}, end: {body: barge, at: [0, 16 m, 0]}"
    acting.append("mechanism.forces.tug={type: load, body: barge, force: [0 kN, 100 kN, 0 kN]}")
    acting.append(
        f"mechanism.forces.dolphin={{type: spring, {ends}, rest: 24 m, stiffness: 1 MN/m, damping: 1 MN s/m}}"
    )
    acting.append(f"mechanism.forces.hawser={{type: spring, {ends}, rest: 24 m, stiffness: 1 MN/m}}")
    acting += ["current={speed: 1 m/s, heading: 90 deg}", "wind={speed: 8 m/s, direction: [0, 1, 0]}", FENDER]
    for level, want in (("memory", set[str]()), ("motion given", {"current", "wind", "fenders", "tug", "dolphin"})):
        rows = load("moored", [*acting, f"fidelity={{water: {level}}}"]).plan.limits
        found = [x for x in rows if x.note == "does not move it: its motion is given"]
        assert {x.subject for x in found} == {f"{of} on barge" for of in want}
        assert all(x.value is None for x in found)


def test_a_line_that_hangs_vertically_is_refused_at_all_levels() -> None:
    ends = "start: {body: world, at: [%s m, 0, -60 m]}, end: {body: barge, at: [0, 0, -4 m]}"
    line = f"{{type: mooring line, {ends}, length: 56 m, EA: 600 MN, mass: 130 kg/m, seabed: false}}"
    for x, level in ((0.0, "memory"), (0.0, "motion given"), (STEP, "motion given")):
        changes = [f"mechanism.forces.tether={line % x}", f"fidelity={{water: {level}}}"]
        with pytest.raises(KernelError, match="'tether': length fits no catenary"):
            Simulation(system(load("moored", changes).plan), 1e-8)
