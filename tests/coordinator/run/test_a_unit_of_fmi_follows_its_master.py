"""A scene as a unit of FMI 2 and 3: real inputs, parameters, saved states and, in FMI 3, returns at located events.

FMPy plays the units; the references are native runs of scenes in which the same is written down.
"""

import json
from pathlib import Path

import fmpy
import heavylift
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from heavylift.coordinator.run.units import SteppedScene, export
from heavylift.kernel import SceneError, allowed
from heavylift.nodes import Fmu, drive
from heavylift.nodes.devs import ms, seconds
from heavylift.nodes.scene import LoadedScene, load

SCENE = """heavylift: 1
name: slider
end: 6 s
samples: 10 Hz
method: dopri5
tolerance: 1e-9
mechanism:
  bodies: {{sledge: {{mass: {mass}}}, bob: {{mass: 100 kg, com: [0, 0, -3 m]}}}}
  joints:
    rail: {{type: prismatic, child: sledge, axis: [1, 0, 0]}}
    pivot: {{type: revolute, parent: sledge, child: bob, axis: [0, -1, 0], start: 20 deg}}
  drives: {{motor: {{joint: rail, type: speed, damping: 50 kN s/m, ramp: 1 m/s2}}}}
wind: {{direction: [1, 0, 0], {wind}, on: {{bob: {{sides: [2 m2, 2 m2, 1 m2]}}}}}}
"""
DROPS = """heavylift: 1
name: drops
end: 4 s
samples: 10 Hz
method: dopri5
tolerance: 1e-9
mechanism:
  bodies: {load: {mass: 10 t}}
  joints: {guide: {type: prismatic, child: load, axis: [0, 0, 1], start: -29.5 m}}
  ropes: {fall: {start: {body: world}, end: {body: load}, length: 30 m, EA: 94 MN, damping: 20 kN s/m}}
"""
BETWEEN_m, BETWEEN_N = 1e-8, 0.01  # interpolation between samples of 10 Hz, of 30 m and 100 kN
SAME = 1e-7  # of runs with other steps and a tolerance of 1e-9
ANGLE, TRAVEL = "joint.position.pivot.angle", "joint.position.rail.travel"


def scene(folder: Path, wind: str = "speed: 0 m/s", mass: str = "1 t +- 10 %", name: str = "slider") -> LoadedScene:
    file = folder / f"{name}.yaml"
    file.write_text(SCENE.format(wind=wind, mass=mass))
    return load(file)


@pytest.fixture(scope="module", params=["2", pytest.param("3", marks=pytest.mark.large(beyond=1))])
def unit(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    if request.param == "3":
        pytest.importorskip("pythonfmu3")
    folder = tmp_path_factory.mktemp("unit")
    return export(scene(folder), folder / "slider.fmu", inputs=["motor", "wind"], fmi=request.param)


def simulated(file: Path, signals: dict[str, list[tuple[float, float]]], **start: float) -> np.ndarray:
    """Play a unit by FMPy with input signals that jump at times [s] of communication points."""
    times = sorted({t for rows in signals.values() for t, _ in rows} | {0.0, 6.0})
    table = [(t, *(next(v for at, v in reversed(rows) if at <= t) for rows in signals.values())) for t in times]
    doubled = [row for a, b in zip(table, table[1:] + table[-1:], strict=True) for row in (a, (b[0], *a[1:]))]
    kind = [("time", float), *((name, float) for name in signals)]
    return fmpy.simulate_fmu(
        str(file), start_values=start, input=np.array(doubled, dtype=kind) if signals else None, stop_time=6.0,
        output_interval=0.1, output=[ANGLE, TRAVEL], use_event_mode=False,
    )  # fmt: skip


def native(of: LoadedScene, orders: tuple = ()) -> heavylift.Result:
    return heavylift.simulate(of, orders=orders)


def test_fmpy_finds_no_fault_in_an_fmu_and_all_its_signals_have_units(unit):
    assert validate_fmu(str(unit)) == []
    variables = {v.name: v for v in fmpy.read_model_description(str(unit)).modelVariables}
    found = {name: variables[name].unit for name in ("speed.motor", "wind", ANGLE, "pose.bob.z", "energy.kinetic")}
    assert found == {"speed.motor": "m/s", "wind": "m/s", ANGLE: "rad", "pose.bob.z": "m", "energy.kinetic": "J"}
    real = [v for v in variables.values() if v.type in ("Real", "Float64") and v.causality in ("input", "output")]
    assert all(v.unit for v in real)
    assert len(real) > 20


def test_a_drive_speed_set_by_the_fmi_importer_moves_the_drive_as_an_order_does(unit, tmp_path):
    found = simulated(unit, {"speed.motor": [(0.0, 0.0), (1.0, 0.5), (3.0, 0.0)], "wind": [(0.0, 0.0)]})
    orders = ((1.0, "motor: drive 0.5 m/s by 1 m"),)
    want = native(scene(tmp_path), orders).at(found["time"], before=True)
    assert found[TRAVEL] == pytest.approx(want["joint/position"]["rail.travel"], abs=SAME)
    assert found[ANGLE] == pytest.approx(want["joint/position"]["pivot.angle"], abs=SAME)
    assert found[TRAVEL][-1] > 0.9


def test_a_wind_speed_set_by_the_fmi_importer_acts_as_equal_gusts_in_the_scene(unit, tmp_path):
    found = simulated(unit, {"speed.motor": [(0.0, 0.0)], "wind": [(0.0, 0.0), (2.0, 15.0), (4.0, 5.0)]})
    gusts = "speed: 0 m/s, gusts: [[0 s, 0 m/s], [2 s, 0 m/s], [2 s, 15 m/s], [4 s, 15 m/s], [4 s, 5 m/s]]"
    want = native(scene(tmp_path, gusts)).at(found["time"])
    assert found[ANGLE] == pytest.approx(want["joint/position"]["pivot.angle"], abs=SAME)
    calm = native(scene(tmp_path)).at(found["time"])
    assert abs(found[ANGLE] - calm["joint/position"]["pivot.angle"]).max() > 1e-3


def test_an_uncertain_input_of_the_scene_is_a_parameter_of_the_fmu(unit, tmp_path):
    found = simulated(unit, {}, **{"mechanism.bodies.sledge.mass": 2000.0})
    want = native(scene(tmp_path, mass="2 t")).at(found["time"])
    assert found[ANGLE] == pytest.approx(want["joint/position"]["pivot.angle"], abs=SAME)


def test_a_saved_fmu_state_restored_in_another_instance_continues_bit_for_bit(unit):
    description = fmpy.read_model_description(str(unit))
    number = {v.name: v.valueReference for v in description.modelVariables}
    folder = fmpy.extract(str(unit))

    def made():
        one = fmpy.instantiate_fmu(folder, description, "CoSimulation")
        if description.fmiVersion == "2.0":
            one.setupExperiment(startTime=0.0)
        one.enterInitializationMode()
        one.exitInitializationMode()
        return one

    def set_(one, name, value):
        (one.setReal if description.fmiVersion == "2.0" else one.setFloat64)([number[name]], [value])

    def get(one, name):
        return (one.getReal if description.fmiVersion == "2.0" else one.getFloat64)([number[name]])[0]

    first = made()
    set_(first, "speed.motor", 0.4)
    for k in range(7):
        first.doStep(0.25 * k, 0.25)
    state = first.getFMUState()
    data = first.serializeFMUState(state)
    set_(first, "wind", 9.0)
    first.doStep(1.75, 0.5)
    ends = [get(first, ANGLE)]
    other = made()
    other.setFMUState(other.deserializeFMUState(data))
    set_(other, "wind", 9.0)
    other.doStep(1.75, 0.5)
    ends.append(get(other, ANGLE))
    first.setFMUState(state)
    set_(first, "wind", 9.0)
    first.doStep(1.75, 0.5)
    ends.append(get(first, ANGLE))
    assert ends == [ends[0]] * 3
    for one in (first, other):
        one.terminate()
        one.freeInstance()


def test_an_fmu_state_saved_before_the_update_of_an_event_is_restored_with_all_values(tmp_path):
    (tmp_path / "drops.yaml").write_text(DROPS)
    file = export(load(tmp_path / "drops.yaml"), tmp_path / "drops.fmu")
    unit = SteppedScene(Path(fmpy.extract(str(file))) / "resources")

    def values() -> list[float]:
        return [x.get() for x in unit.variables()]

    for number in range(4):
        while not unit.step(4.0, pytest.fail, events=True):
            pass
        state, before = unit.state(), values()
        kept = json.dumps(state)
        unit.run.settle()
        after = values()
        assert after != before
        unit.step(3.0 + 0.1 * number, pytest.fail)
        last = values()
        for saved in state, json.loads(kept):
            unit.restore(saved)
            assert (unit.run.now < seconds(3.0), values()) == (True, before)
            unit.run.settle()
            assert values() == after
        unit.step(3.0 + 0.1 * number, pytest.fail)
        assert values() == last
        unit.restore(state)
        unit.run.settle()


@pytest.mark.parametrize("step", [0.8, 0.05])
def test_a_step_of_fmi_3_returns_at_every_located_event(step, tmp_path):
    """None is lost however many lie in one step; outputs there are those before and after the event."""
    pytest.importorskip("pythonfmu3")
    (tmp_path / "drops.yaml").write_text(DROPS)
    drops = load(tmp_path / "drops.yaml")
    result = native(drops)
    times = sorted({seconds(e.t) for e in result.events if e.source == "kernel" and 0.0 < e.t < 4.0})
    assert len(times) >= 6
    rows = fmpy.simulate_fmu(
        str(export(drops, tmp_path / "drops.fmu", fmi="3")), stop_time=4.0, output_interval=step,
        output=["pose.load.z", "tension.fall"], use_event_mode=True, early_return_allowed=True, record_events=True,
    )  # fmt: skip
    before = {seconds(float(row["time"])): (row["pose.load.z"], row["tension.fall"]) for row in reversed(rows)}
    after = {seconds(float(row["time"])): (row["pose.load.z"], row["tension.fall"]) for row in rows}
    grid = [seconds(step * k) for k in range(round(4.0 / step) + 1)]
    returned = sorted({*after} - {*grid})
    assert returned == [t for t in times if t not in grid]
    for found, left in (before, True), (after, False):
        want = result.at([t / 1e9 for t in returned], before=left)
        assert [found[t][0] for t in returned] == pytest.approx(want["pose/load"]["z"], abs=BETWEEN_m)
        assert [found[t][1] for t in returned] == pytest.approx(want["rope/tension"]["fall"], abs=BETWEEN_N)
    assert any(after[t][1] > before[t][1] + 1e4 for t in returned), "a rope that tightens jumps to its damping"


def test_an_fmi_master_without_event_mode_loses_only_the_instants_of_events(tmp_path):
    """As OMSimulator does by its issue 1609: it opts out of event mode, so results are those of communication points,
    and a jump is smeared over a step. A master with event mode has two rows where a value jumps."""
    pytest.importorskip("pythonfmu3")
    (tmp_path / "drops.yaml").write_text(DROPS)
    file = str(export(load(tmp_path / "drops.yaml"), tmp_path / "drops.fmu", fmi="3"))
    played = {
        events: fmpy.simulate_fmu(
            file, stop_time=4.0, output_interval=0.5, output=["pose.load.z", "events"], use_event_mode=events,
            early_return_allowed=events, record_events=events,
        )
        for events in (True, False)
    }  # fmt: skip
    assert [float(t) for t in played[False]["time"]] == [0.5 * k for k in range(9)]
    last = {float(row["time"]): tuple(row) for row in played[True]}
    assert [last[float(row["time"])] for row in played[False]] == [tuple(row) for row in played[False]]
    times, counts = played[True]["time"], played[True]["events"]
    doubled = [i for i in range(1, len(times)) if times[i] == times[i - 1]]
    assert len(doubled) >= 6
    assert sum(counts[i] - counts[i - 1] for i in doubled) == counts[-1] - counts[0]


def test_events_of_an_exported_scene_reach_a_devs_model_at_their_instants(tmp_path, monkeypatch):
    """FMI 3 out and in: the unit of a scene as an atomic of heavylift's own."""
    pytest.importorskip("pythonfmu3")
    monkeypatch.setenv("HEAVYLIFT_CACHE", str(tmp_path / "cache"))
    (tmp_path / "drops.yaml").write_text(DROPS)
    drops = load(tmp_path / "drops.yaml")
    file = export(drops, tmp_path / "drops.fmu", fmi="3")
    times = {seconds(e.t) for e in native(drops).events if e.source == "kernel" and 0.0 < e.t < 3.5}
    with allowed([str(tmp_path)]):
        sent = drive(Fmu("drops", file, ms(700), ["pose.load.z"]), [], until=seconds(3.5) - 1)
    assert {tag.t for tag, _, _ in sent} == times | {ms(700) * k for k in range(5)}


def test_exporting_an_fmu_with_inputs_that_the_scene_does_not_have_is_refused(tmp_path):
    calm = load("pendulum")
    with pytest.raises(SceneError, match="--input wind: the scene has no 'wind'"):
        export(calm, tmp_path / "x.fmu", inputs=["wind"])
    with pytest.raises(SceneError, match="'engine' is not a drive or winch that a model can control"):
        export(scene(tmp_path), tmp_path / "x.fmu", inputs=["engine"])
