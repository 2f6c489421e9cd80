"""Every example scene runs, shows the effect in its first comment, and is on the gallery page with a picture.

`turnover`, `lift`, `arm` and `pendulum` are run elsewhere (tests/turnover, chain, kernel, hosts).
"""

from __future__ import annotations

from math import cos, pi, radians, sin, sqrt
from pathlib import Path

import numpy as np
import pytest
from heavylift.coordinator.commands import app, page
from heavylift.coordinator.run import run
from heavylift.nodes.scene import bundled, load
from heavylift.recordings import Recording
from heavylift.recordings.write import output_path
from typer.testing import CliRunner

G = 9.80665
FOLDER = Path(__file__).parents[2] / "nodes" / "scenes"
LARGEST = 60_000  # [bytes] of a picture
DRAWN = 1e-3  # [m] of poses that are recorded as 32-bit numbers and of accuracies of 1e-5


def played(folder: Path, name: str) -> Recording:
    output = folder / f"{name}.mcap"
    run(load(name), output, in_process=True)
    recording = Recording(output)
    assert recording.result["status"] == "finished"
    return recording


def column(recording: Recording, signal: str, name: str, start: float = 0.0, end: float = 1e9) -> np.ndarray:
    found = recording.signal(signal)
    return found[name][(found.t >= start) & (found.t <= end)]


def test_the_example_tandem_shares_the_block_between_its_cranes_by_statics(tmp_path: Path) -> None:
    recording = played(tmp_path, "tandem")
    tension = recording.signal("rope/tension")
    hooks = np.array([tension[f"{crane}.{hook}"] for crane in ("west", "east") for hook in ("H1", "H2")])
    still = (600e3 / 4 + 45e3) * G
    assert hooks[:, -1] == pytest.approx(np.full(4, still), rel=0.01)
    assert recording.stages()[-1][1] == "swing"


def test_the_example_trolley_leaves_no_swing_after_accelerating_over_one_period(tmp_path: Path) -> None:
    recording = played(tmp_path, "trolley")
    assert np.ptp(column(recording, "pose/load", "x", 25.0, 39.0)) < 0.01
    assert np.ptp(column(recording, "pose/load", "x", 60.0)) > 5.0
    assert 2 * pi * sqrt(24.0 / G) == pytest.approx(1.0 / 0.1017, abs=0.01)


@pytest.mark.large
def test_the_crate_of_the_example_ramp_slides_down_and_leaves_the_ramp(tmp_path: Path) -> None:
    recording = played(tmp_path, "ramp")
    x = recording.signal("pose/crate")
    lean = radians(30.0)
    along = G * (sin(lean) - 0.3 * cos(lean))
    sliding = x.t < 2.0
    assert (x["x"] - x["x"][0])[sliding] == pytest.approx(cos(lean) * along * x.t[sliding] ** 2 / 2, abs=DRAWN)
    assert x["z"][-1] == pytest.approx(-2.0, abs=DRAWN)
    assert column(recording, "contact/force", "floor")[-1] == pytest.approx(4000.0 * G, rel=1e-6)


def test_the_rope_of_the_example_snatch_tightens_after_a_free_fall(tmp_path: Path) -> None:
    recording = played(tmp_path, "snatch")
    taut = [e for e in recording.events(source="kernel") if e.type == "StateEvent" and e.value["what"] == "taut"]
    assert taut[0].t_ns * 1e-9 == pytest.approx(sqrt(2 * 0.5 / G), abs=1e-6)
    assert column(recording, "rope/tension", "fall").min() == 0.0
    assert column(recording, "pose/load", "z")[-1] == pytest.approx(-27.03, abs=0.01)


def test_the_girder_in_the_example_scene_sags_like_a_beam_on_two_supports(tmp_path: Path) -> None:
    recording = played(tmp_path, "girder")
    EI, L = 210e9 * 19.7, 150.0
    sag = 5 * 2500e3 * G * L**3 / (384 * EI) + 450e3 * G * L**3 / (48 * EI)
    assert 90.0 - column(recording, "pose/mark", "z", 30.0).min() == pytest.approx(sag, rel=0.01)


def test_the_rope_of_the_example_tackle_loses_tension_at_each_sheave(tmp_path: Path) -> None:
    recording = played(tmp_path, "tackle")
    lead, dead = (column(recording, "reeving/tension", f"fall.{n}", 5.0, 9.0) for n in (1, 4))
    assert dead / lead == pytest.approx(np.full(len(lead), 0.97**3), rel=1e-6)


def test_the_linkage_in_the_example_scene_does_not_move_while_its_joint_is_locked(tmp_path: Path) -> None:
    recording = played(tmp_path, "linkage")
    (locked,) = [e for e in recording.events(source="kernel") if e.type == "StateEvent" and e.value["what"] == "locked"]
    assert locked.t_ns == 2_500_000_000
    assert locked.value["value"] > 0.0, "what it took out of the motion [J]"
    assert np.ptp(column(recording, "joint/position", "a.angle", 2.51, 3.49)) < 1e-9
    assert np.ptp(column(recording, "joint/position", "a.angle", 3.51)) > 0.1


def test_the_wind_of_the_example_gust_pushes_the_load_aside(tmp_path: Path) -> None:
    recording = played(tmp_path, "gust")
    push = 0.5 * 1.225 * 80.0 * 1.3 * 15.0**2
    lateral = column(recording, "pose/load", "x", 12.0, 32.0)
    assert (lateral.max() + lateral.min()) / 2 == pytest.approx(41.0 * push / (60e3 * G), rel=0.1)
    assert np.ptp(column(recording, "pose/load", "x", 0.0, 10.0)) == 0.0


@pytest.fixture(scope="module")
def damper(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    return played(tmp_path_factory.mktemp("damper"), "damper")


def damped(zeta: float, t: np.ndarray) -> np.ndarray:
    """Angle [rad] that linear theory gives a pendulum of 24 m, damped by zeta, whose pivot goes 34 m with 0.25 m/s2 and
    1 m/s: the sum of four steps of acceleration."""
    w = sqrt(G / 24.0)
    wd = w * sqrt(1 - zeta**2)

    def step(s: np.ndarray) -> np.ndarray:
        s = np.maximum(s, 0.0)
        return -0.25 / G * (1 - np.exp(-zeta * w * s) * (np.cos(wd * s) + zeta * w / wd * np.sin(wd * s)))

    return step(t) - step(t - 4.0) - step(t - 34.0) + step(t - 38.0)


@pytest.mark.parametrize(("of", "zeta", "off"), [("plain", 0.0, 0.06), ("led", 9.2 / (2 * sqrt(G * 24.0)), 0.012)])
def test_the_controller_of_the_anti_sway_example_damps_a_swing_as_in_theory(
    damper: Recording, of: str, zeta: float, off: float
) -> None:
    q, load = damper.signal("joint/position"), damper.signal(f"pose/{of}-load")
    lateral = load["x"] - q[f"{of}-rail.travel"]
    assert lateral == pytest.approx(24.0 * damped(zeta, q.t), abs=off), "of 2.3 and 0.8 m at most"
    assert q[f"{of}-rail.travel"][-1] == pytest.approx(34.0, abs=1e-3)
    left = float(np.abs(lateral[q.t > 70.0]).max())
    assert left == pytest.approx(2.32, abs=0.01) if of == "plain" else left < 0.01


def test_the_gallery_page_describes_all_bundled_scenes() -> None:
    assert (FOLDER / "GALLERY.md").read_text() == page([load(name) for name in bundled()])
    pictures = {path.stem: path.stat().st_size for path in (FOLDER / "pictures").glob("*.png")}
    assert set(pictures) == {*bundled(), "vlcc"}
    assert max(pictures.values()) <= LARGEST
    for path in (FOLDER / "pictures").glob("*.png"):
        assert output_path(path) == path  # which --force replaces


def test_the_gallery_command_writes_the_gallery_page(tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text("# Mine.\nheavylift: 1\nname: mine\nextends: pendulum\nend: 1 s\n")
    message = CliRunner().invoke(app, ["gallery", str(tmp_path / "mine.yaml"), "-o", str(tmp_path / "page")])
    assert message.exit_code == 0, message.exception
    text = (tmp_path / "page" / "GALLERY.md").read_text()
    assert "## mine\n\nMine.\n\n![mine](pictures/mine.png)\n\n    heavylift run mine.yaml\n" in text
    assert (tmp_path / "page" / "pictures" / "mine.png").read_bytes()[:4] == b"\x89PNG"
