"""The log of a tackle tells its load, which is written into the scene with its uncertainty, comments kept."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from heavylift.coordinator.measured import measure, scene_text
from heavylift.coordinator.run import run
from heavylift.kernel import SceneError
from heavylift.nodes.scene import load, parse, uncertain_inputs, varied
from heavylift.nodes.scene.inputs import inputs
from heavylift.recordings import Recording
from lifting import cargo
from small_lift import log

MASS, LONGEST = "mechanism.bodies.load.mass", "mechanism.ropes.fall.winch.longest"
MAPS = ["lead=reeving/tension/fall.1 [kN] +- 0.3 kN", "dead=reeving/tension/fall.4 [kN] +- 0.3 kN"]


def logged(folder: Path, settings: list[str], seed: int) -> tuple[Path, Path]:
    """The recording of the bundled tackle, and the log of one with these settings."""
    run(load("tackle", ["end=15 s"]), folder / "run.mcap", in_process=True)
    run(load("tackle", [*settings, "samples=100 Hz", "end=15 s"]), folder / "real.mcap", in_process=True)
    real, rng = Recording(folder / "real.mcap").signal("reeving/tension"), np.random.default_rng(seed)
    t = np.arange(0.0, 14.0, 0.1)
    cells = {
        name: np.interp(t, real.t, real[column]) / 1e3 + 0.3 * rng.standard_normal(len(t))
        for name, column in (("lead", "fall.1"), ("dead", "fall.4"))
    }
    return folder / "run.mcap", log(folder / "log.csv", {"time [s]": t + 50.0, **cells})


def test_the_mass_of_the_load_is_estimated_from_a_log_and_written_into_the_scene(tmp_path: Path) -> None:
    recording, table = logged(tmp_path, [f"{MASS}=41.3 t"], 3)
    found = measure(recording, table, MAPS, None, [MASS, LONGEST], [f"{MASS} +- 3 %"])
    lead, _ = found.comparisons
    assert lead.u_input == pytest.approx(0.015 * 104e3, rel=0.05)  # of the lead part's tension: half of what is stated
    assert not lead.lacks
    value, half = (float(text.removesuffix(" t")) for text in found.estimates[MASS])
    assert abs(value - 41.3) < 1.5 * half < 0.3
    assert "hardly depends on it" in found.not_identified[LONGEST]
    assert found.scene == tmp_path / "run-measured.yaml"
    text = found.scene.read_text()
    assert "mass: {} +- {}".format(*found.estimates[MASS]) in text
    assert [str(x) for x in uncertain_inputs(load(found.scene))] == ["{} {} +- {}".format(MASS, *found.estimates[MASS])]
    assert text.startswith("# A rope over sheaves: a tackle of four falls")
    assert "end: 15 s" in text  # which was laid over the scene for the run
    assert load(found.scene).plan.machines[0].system.bodies[0].mass == pytest.approx(1e3 * value)


@pytest.mark.large
@pytest.mark.parametrize("seed", range(6))
def test_several_inputs_of_random_tackles_are_estimated_from_logs(seed: int, tmp_path: Path) -> None:
    rng = np.random.default_rng(100 + seed)
    true = {
        MASS: rng.uniform(37.0, 43.0),
        "mechanism.ropes.fall.over.0.efficiency": rng.uniform(94.0, 98.0),
        "mechanism.ropes.fall.damping": rng.uniform(40.0, 90.0),
    }
    units = dict(zip(true, ("t", "%", "kN s/m"), strict=True))
    recording, table = logged(tmp_path, [f"{name}={x!r} {units[name]}" for name, x in true.items()], seed)
    found = measure(recording, table, MAPS, None, list(true))
    assert {MASS, "mechanism.ropes.fall.over.0.efficiency"} <= set(found.estimates)
    for name, texts in found.estimates.items():
        value, half = (float(text.removesuffix(units[name])) for text in texts)
        assert abs(value - true[name]) < 1.75 * half, name  # 3.5 standard uncertainties


def test_an_estimated_input_that_the_scene_does_not_state_is_added_to_its_text() -> None:
    scene = load("lift")
    fitted = inputs(scene, ["block.com.x", "block.mass", "cranes.crane.rope damping", "rig.sling.EA"])
    given = {p.name: text for p, text in zip(fitted, [("0.21 m", "0.02 m"), ("306.1 t", "1.2 t"), ("0.05", "0.01"),
                                                      ("440 MN", "20 MN")], strict=True)}  # fmt: skip
    text = scene_text(scene, fitted, given, "log.csv")
    found = parse(text, "lift.yaml").scene
    assert found.block is not None
    assert (found.block.com, found.block.mass) == ((0.21, 0.0, 0.0), 306_100.0)
    assert found.machines["crane"].hooks["crane.H1"].damping == 0.05
    assert found.rig is not None
    assert found.rig.sling.EA == 440e6
    assert "#   block.com.x: 0.21 m +- 0.02 m" in text
    assert {x.name for x in uncertain_inputs(parse(text))} == set(given)
    assert "# on supports of 2 m; its inertia is that of a uniform box" in text


def test_estimated_values_are_rounded_to_their_uncertainty() -> None:
    mass, EA = inputs(load("lift"), ["block.mass", "rig.sling.EA"])
    assert mass.rounded(305_983.2, 332.0) == ("305.98 t", "0.66 t")
    assert EA.rounded(4.45255e8, 4.9295e6) == ("445.3 MN", "9.9 MN")


def test_estimating_one_input_leaves_all_others_unchanged() -> None:
    scene = load("lift", ["block.mass=310 t"])
    (com,) = inputs(scene, ["block.com.y"])
    other = varied(scene, [com], [-0.3])
    assert cargo(other.plan).mass == 310_000.0
    assert cargo(other.plan).com == (0.0, -0.3, 0.0)
    assert other.plan.fidelity == scene.plan.fidelity


@pytest.mark.parametrize(
    ("name", "what"),
    [
        ("block.weight", "there is no 'weight'; "),
        ("block.com.w", "there is no 'w'; known: 0, 1, 2"),
        ("cranes.west.at", "there is no 'west'; known: crane"),
        ("name", "is not a quantity"),
        ("block.mass.x", "'mass' is a single quantity without a part 'x'"),
        ("rig.sling.WLL", "the scene gives this input no value"),
    ],
)
def test_estimating_an_input_that_the_scene_does_not_have_is_refused(name: str, what: str) -> None:
    with pytest.raises(SceneError, match=f"input {name}: ") as message:
        inputs(load("lift"), [name])
    assert what in str(message.value)
