"""A moored barge in current, wind and waves: mean offsets in closed form, Newman's slow drift, and files of drift."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import msgspec
import numpy as np
import pytest
from heavylift.kernel import SceneError
from heavylift.kernel.analysis import equilibrium
from heavylift.kernel.simulation import Simulation
from heavylift.nodes.limits import checks_of
from heavylift.nodes.models import system
from heavylift.nodes.scene import LoadedScene, load, parse
from heavylift.nodes.scenes import vessels_folder
from heavylift.nodes.sea import MeanDrift, drift_of

K, AREA, LENGTH = 4e5, 440.0, 110.0
TABLE = "[[0 deg, 0.4, 0, 0], [90 deg, 0.05, 0.9, 0.02], [180 deg, -0.45, 0, 0]]"
SCENE = """
heavylift: 1
name: offset
end: 400 s
seed: 3
%s
vessels:
  barge:
    mass: 14432 t
    size: [110 m, 32 m, 8 m]
    draught: 4 m
    com: [0 m, 0 m, 2 m]
    heading: %s
    motion: forces
    floating:
      hydrodynamics: %s
      mooring: {surge: 400 kN/m, sway: 400 kN/m, yaw: 400 MN m/rad}
      damping: [[4e6, 0, 0, 0, 0, 0], [0, 4e6, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0],
                [0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 4e9]]
      %s
actions: [{wait: 1 s}]
"""
STREAM = "%s: {area: 440 m2, length: 110 m, coefficients: " + TABLE + "}"


def at_rest(text: str) -> tuple[np.ndarray, float]:
    """Place of the barge in its equilibrium, and its yaw angle [rad]."""
    s = Simulation(system(parse(text).plan), 1e-8)
    s.start()
    q = np.array(equilibrium(s).q)
    return q[:3], 2.0 * float(np.arctan2(q[5], q[6]))


@pytest.mark.parametrize("bow", [0.0, 40.0])
def test_the_offset_of_a_moored_barge_in_a_current_is_drag_force_over_mooring_stiffness(bow: float) -> None:
    """Along the bow: k x = 1/2 rho A C U^2, however the barge lies; a current astern has the other coefficient."""
    for to, C in ((bow, 0.4), (bow + 180.0, 0.45)):
        current = f"current: {{speed: 1.2 m/s, heading: {to} deg}}"
        place, yaw = at_rest(SCENE % (current, f"{bow} deg", "barge-110", STREAM % "current"))
        want = 0.5 * 1025.0 * AREA * C * 1.2**2 / K
        angle = np.radians(to)
        assert place[:2] == pytest.approx(want * np.array([np.cos(angle), np.sin(angle)]), rel=1e-6, abs=1e-6)
        assert yaw == pytest.approx(np.radians(bow), abs=1e-9)


def test_a_beam_wind_pushes_a_moored_barge_sideways_and_turns_it() -> None:
    """The wind of the scene, with its density; the turned barge feels the coefficients of its own direction."""
    wind = "wind: {speed: 15 m/s, direction: [0, 1, 0]}"
    place, yaw = at_rest(SCENE % (wind, "0 deg", "barge-110", STREAM % "wind"))
    pressure = 0.5 * 1.225 * AREA * 15.0**2
    assert place[1] == pytest.approx(0.9 * pressure / K, rel=1e-3)
    assert yaw == pytest.approx(0.02 * pressure * LENGTH / 4e8, rel=0.05)


@pytest.mark.parametrize(("of", "height", "force"), [("wind", 9.0, 0.5 * 1.225 * 15.0**2), ("current", -2.0, 512.5)])
def test_a_beam_stream_heels_a_barge_by_its_force_times_height_over_the_righting_moment(of, height, force):
    """W GM phi = F h with GM of roll: the moorings hold at the waterline; without a height, that is an amber check."""
    stream = (STREAM % of).replace("length: 110 m,", f"length: 110 m, height: {height} m,")
    flow = {
        "wind": "wind: {speed: 15 m/s, direction: [0, 1, 0]}",
        "current": "current: {speed: 1 m/s, heading: 90 deg}",
    }
    text = SCENE % (flow[of], "0 deg", "barge-110", stream)
    s = Simulation(system(parse(text).plan), 1e-8)
    s.start()
    roll = 2.0 * float(equilibrium(s).q[3])
    GM = 19.33333 - 2.0
    assert roll == pytest.approx(-0.9 * AREA * force * height / (14432e3 * 9.80665 * GM), rel=2e-3)
    assert unchecked(parse(text)) == []
    without = parse(SCENE % (flow[of], "0 deg", "barge-110", STREAM % of))
    assert unchecked(without) == [
        f"inputs of heel of barge by {of}: not included; give the 'height' of 'floating: {{{of}: ...}}'"
    ]


@pytest.mark.parametrize(("of", "height"), [("wind", "-1 cm"), ("current", "1 cm")])
def test_a_centre_of_pressure_of_wind_in_the_water_or_of_current_above_it_is_refused(of: str, height: str) -> None:
    stream = (STREAM % of).replace("length: 110 m,", f"length: 110 m, height: {height},")
    with pytest.raises(SceneError, match=rf"scene.yaml:\d+:\d+: .*{of}: its centre of pressure is"):
        parse(SCENE % ("", "0 deg", "barge-110", stream))


def test_the_wind_force_on_a_barge_has_the_speed_history_of_the_gusts() -> None:
    gusts = "wind: {speed: 5 m/s, direction: [1, 0, 0], gusts: [[0 s, 5 m/s], [10 s, 20 m/s]]}"
    plan = parse(SCENE % (gusts, "0 deg", "barge-110", STREAM % "wind")).plan
    (wind,) = [f for f in plan.machines[0].system.forces if f.name == "barge.wind"]
    assert (wind.signal.times, wind.signal.values) == ((0.0, 10.0), (5.0, 20.0))


BEAM = (
    ((500.0, 0.0, 0.0), (2e3, 0.0, 0.0), (3e3, 0.0, 0.0)), ((0.0, 1e3, 1e4), (0.0, 8e3, 4e4), (0.0, 1e4, 6e4)),
     ((-500.0, 0.0, 0.0), (-2e3, 0.0, 0.0), (-3e3, 0.0, 0.0)),
)  # fmt: skip
HALF = [0.5 * (np.array(a) + np.array(b)) for a, b in pairwise(BEAM)]  # at 45 and 135 deg
ROWS = [BEAM[0], HALF[0].tolist(), BEAM[1], HALF[1].tolist(), BEAM[2]]
DRIFT = MeanDrift(
    (0.4, 0.8, 1.2), tuple(0.25 * np.pi * i for i in range(5)), tuple(tuple(map(tuple, rows)) for rows in ROWS)
)


@pytest.fixture
def drifting(tmp_path: Path) -> Path:
    """A folder with the barge's file, with mean drift."""
    hull = msgspec.json.decode((vessels_folder() / "barge-110.json").read_bytes())
    hull["drift"] = msgspec.to_builtins(DRIFT)
    (tmp_path / "hull.json").write_bytes(msgspec.json.encode(hull))
    return tmp_path


def scene(folder: Path, waves: str, bow: float = 0.0, hull: str = "hull.json") -> LoadedScene:
    (folder / "sea.yaml").write_text(SCENE % (f"waves: {{{waves}}}", f"{bow} deg", hull, "waterplane: null"))
    return load(folder / "sea.yaml")


def test_the_mean_offset_of_a_moored_barge_in_a_regular_wave_is_drift_force_over_stiffness(drifting: Path) -> None:
    """a^2 D / k, by the mean over 16 waves when the start has decayed; D halfway between two frequencies."""
    w = 1.0
    period = 2.0 * np.pi / w
    plan = scene(drifting, f"height: 1.6 m, period: {period} s, heading: 180 deg, ramp: 30 s").plan
    s = Simulation(system(plan), 1e-7)
    s.start()
    found = []
    for t in 300.0 + period * np.arange(64) / 16.0:
        s.run(round(t * 1e9))
        found.append(s.row().poses.reshape(-1, 12)[0, 0])
    assert np.mean(found) == pytest.approx(-(0.8**2) * 2.5e3 / K, rel=0.02)


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("bow", [0.0, 25.0])
def test_drift_force_in_an_irregular_sea_agrees_with_newmans_sum_over_pairs_of_waves(
    drifting: Path, side: int, bow: float
) -> None:
    """The signal in surge, sway and yaw at some instants against the double sum, from either side of the hull."""
    loaded = scene(drifting, f"seas: {{s: {{Hs: 2 m, Tp: 7 s, components: 30, heading: {bow + side * 60} deg}}}}", bow)
    forces = loaded.plan.machines[0].system.forces
    a, w, phases = np.array([(x.amplitude, x.frequency, x.phase) for x in loaded.scene.waves.harmonics(3)]).T
    rows = np.array(DRIFT.values)
    for mode, label in enumerate(("surge", "sway", "yaw")):
        (f,) = [f for f in forces if f.name == f"barge.{label} drift"]
        ends = [np.interp(w, DRIFT.frequencies, rows[h, :, mode]) for h in (0, 2)]
        D = (ends[0] / 3.0 + ends[1] * 2.0 / 3.0) * (side if mode else 1)
        x = f.signal.waves
        A, B = np.array(x.cosines) - 1j * np.array(x.sines), np.array(x.by[0]) - 1j * np.array(x.by[1])
        for t in (0.0, 12.3, 250.0):
            found = ((A * np.exp(1j * w * t)).sum() * (B * np.exp(1j * w * t)).sum().conjugate()).real
            turned = np.subtract.outer(w, w) * t + np.subtract.outer(phases, phases)
            want = (np.outer(a, a) * 0.5 * np.add.outer(D, D) * np.cos(turned)).sum()
            assert found == pytest.approx(want, rel=1e-9, abs=1e-6 * abs(D).max())
        assert (A * B.conj()).real.sum() == pytest.approx((a * a * D).sum(), rel=1e-9, abs=1e-9)


def test_slow_drift_of_a_moored_vessel_without_drift_data_is_reported_as_not_checked(drifting: Path) -> None:
    seas = {"slow drift": "seas: {s: {Hs: 1 m, Tp: 8 s, components: 20}}", "mean drift": "height: 1 m, period: 8 s"}
    for drift, sea in seas.items():
        rows = {}
        for hull in ("hull.json", "barge-110"):
            found = checks_of(scene(drifting, sea, hull=hull).plan, [], [], None, [])
            rows[hull] = [(x.quantity, x.subject, x.state) for x in found if "drift" in x.quantity]
        assert rows == {"hull.json": [], "barge-110": [(drift, "barge", "amber")]}


RAFT = "  raft: {mass: 9000 t, size: [90 m, 9 m, 6 m], draught: 3 m, at: [0 m, 90 m, 0 m], responses: {}}\n"


def unchecked(loaded: LoadedScene) -> list[str]:
    return [x.sentence for x in loaded.checks if x.quantity == "inputs" and x.state == "amber"]


def test_wind_and_current_and_trim_effects_without_a_check_give_amber_lines_in_the_verdict(drifting: Path) -> None:
    wind = "wind: {speed: 5 m/s, direction: [1, 0, 0], on: {%s}}"
    hull = msgspec.json.decode((drifting / "hull.json").read_bytes()) | {"buoyancy": None}
    (drifting / "hull.json").write_bytes(msgspec.json.encode(hull))
    still = (drifting / "sea.yaml", "0 deg", "hull.json")
    still[0].write_text(SCENE % ("", *still[1:], "waterplane: null"))
    assert unchecked(load(still[0])) == ["inputs of trim of barge: its data have no centre of buoyancy"]
    own = SCENE % (wind % "barge: {sides: [1 m2, 1 m2, 1 m2]}", "0 deg", "barge-110", "waterplane: null")
    assert unchecked(parse(own)) == []
    with pytest.raises(SceneError, match="the wind on barge counts twice"):
        parse(own.replace("waterplane: null", STREAM % "wind"))
    other = own.replace("barge: {sides", "raft: {sides").replace("vessels:\n", f"vessels:\n{RAFT}")
    assert unchecked(parse(other)) == [
        "inputs of wind on barge: not included; give its coefficients, 'floating: {wind: ...}'"
    ]
    given = "heavylift: 1\nname: raft\nend: 1 s\ncurrent: {speed: 1 m/s}\nactions: [{wait: 1 s}]\nvessels:\n" + RAFT
    assert unchecked(parse(given)) == ["inputs of current on raft: not included: its motion is given"]


def test_a_floating_vessel_without_gravity_is_refused() -> None:
    with pytest.raises(SceneError, match="barge floats, which needs gravity"):
        parse(SCENE % ("gravity: 0 m/s2", "0 deg", "barge-110", "waterplane: null"))


def test_drift_coefficients_from_wamit_files_are_scaled_to_newtons(tmp_path: Path) -> None:
    """Relative to rho g L in surge and sway, rho g L^2 in yaw; only equal headings are mean drift."""
    rows = [
        f"{T} {b} {c} {mode} 9 9 {0.01 * T * mode * (1 if b == c else 5)} 0"
        for T in (8.0, 6.0) for b in (0, 90) for c in (0, 90) for mode in (1, 2, 6)
    ]  # fmt: skip
    path = tmp_path / "barge.8"
    path.write_text("PER B1 B2 I MOD PHS RE IM\n" + "\n".join(rows))
    w, headings, values = drift_of(path, 1e4, 10.0)
    assert w == pytest.approx(2.0 * np.pi / np.array([8.0, 6.0]))
    assert headings == pytest.approx([0.0, 0.5 * np.pi])
    assert values[1, 0] == pytest.approx([0.08 * 1e5, 0.16 * 1e5, 0.48 * 1e6])
    path.write_text("\n".join(rows[:-1]))
    with pytest.raises(SceneError, match="it needs surge, sway and yaw at each of two or more headings and periods"):
        drift_of(path, 1e4, 10.0)


BAD = {
    "the scene has a current, and the vessel has no coefficients for it": "waterplane: null",
    "give one row for each direction, from 0 deg to 180 deg in equal steps": (STREAM % "current").replace(
        "90 deg", "80 deg"
    ),
    "coefficients of sway and yaw must be zero at 0 deg": (STREAM % "current").replace("0.4, 0, 0", "0.4, 0.1, 0"),
}


@pytest.mark.parametrize("sentence", BAD)
def test_impossible_currents_are_refused_in_one_sentence(sentence: str) -> None:
    with pytest.raises(SceneError, match=sentence):
        parse(SCENE % ("current: {speed: 1 m/s}", "0 deg", "barge-110", BAD[sentence]))
