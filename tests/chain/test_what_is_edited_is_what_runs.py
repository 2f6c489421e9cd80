"""Editing the action list, a joint, a body or a law of a scene changes the run as computed."""

import re
from math import pi, sqrt
from pathlib import Path

import numpy as np
import pytest
from chain import G, channel, play
from heavylift.kernel.multibody import build_graph
from heavylift.nodes.models import system
from heavylift.nodes.scene import load
from heavylift.recordings import Recording
from scipy.spatial.transform import Rotation

LIFT = load("lift").text + "\nend: 60 s\n"
STAGES = ("take up slack", "lift off", "up", "sideways")
SEEN = 1e-4  # [m] of the block's last place: ten times what a hundredth of the tolerance changes
GIVES_WAY = 0.01  # [m] a servo-driven trolley under the pull of the swinging block
SAME = 1e-6  # relative, of a static stretch or of a period


def without(text: str, stage: str) -> str:
    """The scene with one action taken off its list."""
    left, removed = re.subn(rf"  - stage: {stage}\b.*\n(?:    .*\n)*", "", text)
    assert removed == 1
    return left


def last_place(recording: Recording) -> np.ndarray:
    return recording.signal("pose/block").values[-1, :3]


def stages(recording: Recording) -> list[str]:
    return [e.value["name"] for e in recording.events(source="commander", port="stage")]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """The bundled lift as it is."""
    return play(tmp_path_factory.mktemp("whole"), LIFT)


@pytest.mark.parametrize("stage", STAGES)
def test_removing_an_action_from_the_list_changes_the_run(tmp_path: Path, whole: Recording, stage: str) -> None:
    assert stages(whole)[:4] == list(STAGES)

    poorer = play(tmp_path, without(LIFT, stage))

    assert stages(poorer) == [name for name in stages(whole) if name != stage]
    assert np.abs(last_place(poorer) - last_place(whole)).max() > SEEN


def test_a_shortened_move_in_the_action_list_shortens_the_run(tmp_path: Path, whole: Recording) -> None:
    further = play(tmp_path, LIFT, ["actions.3.trolleys=traverse 20 m/min by 3 m"])

    for trolley in ("upper", "lower"):
        _, far = channel(further, f"pose/crane.{trolley}", "y")
        _, near = channel(whole, f"pose/crane.{trolley}", "y")
        assert far[-1] - near[-1] == pytest.approx(1.0, abs=GIVES_WAY)


def test_actions_of_a_scene_are_executed_in_the_order_in_which_they_are_listed(
    tmp_path: Path, whole: Recording
) -> None:
    head, *actions = LIFT.split("  - stage: ")
    actions[2], actions[3] = actions[3], actions[2]

    swapped = play(tmp_path, "  - stage: ".join([head, *actions]))

    assert stages(swapped)[2:4] == ["sideways", "up"]
    assert np.abs(last_place(swapped) - last_place(whole)).max() > SEEN


@pytest.mark.parametrize("parent", ["link-3", "link-2"])
def test_attaching_a_joint_to_another_body_changes_the_path_matrix_and_the_motion(tmp_path: Path, parent: str) -> None:
    change = f"mechanism.joints.J4.parent={parent}"
    graph = build_graph(system(load("arm", [change]).plan))
    row = next(i for i, link in enumerate(graph.links) if link.body.name == "link-4")
    path = {link.joint.name for link, on in zip(graph.links, graph.T[row], strict=True) if on}
    assert path == {"J1", parent.replace("link-", "J"), "J4"}

    arm = play(tmp_path, load("arm").text, [change])

    joint = [1.6, 0.0, 0.0]
    carrier, carried = (arm.signal(f"pose/{link}").values for link in (parent, "link-4"))
    on_parent = carrier[:, :3] + Rotation.from_quat(carrier[:, 3:]).apply(joint)
    assert np.abs(carried[:, :3] - on_parent).max() < SAME
    assert np.ptp(carried[:, 2]) > 1.0


PENDULUM = """\
heavylift: 1
name: pendulum
accuracy: 1e-6 %
samples: 20 Hz
end: 40 s
mechanism:
  bodies:
    load: {mass: 450 t, com: [0, 0, -60 m]}
  joints:
    pivot: {type: revolute, child: load, axis: [0, 1, 0], start: 0.01 deg}
"""


def half_period(recording: Recording) -> float:
    """Seconds between the first two passages through the vertical, by straight lines between samples."""
    t, place = channel(recording, "joint/position", recording.signal("joint/position").names[0])
    at = np.flatnonzero(place[:-1] * place[1:] < 0.0)[:2]
    first, second = t[at] - place[at] * (t[at + 1] - t[at]) / (place[at + 1] - place[at])
    return float(second - first)


# A hundredth of a degree swings like the linear pendulum: its period is 2e-9 longer.
@pytest.mark.parametrize(
    ("atomic", "change", "period"),
    [
        ("none", {}, 2 * pi * sqrt(60 / G)),
        ("body: the link's length", {"-60 m": "-15 m"}, 2 * pi * sqrt(15 / G)),
        ("body: the mass of a point", {"450 t": "45 t"}, 2 * pi * sqrt(60 / G)),
        (
            "body: the moment of inertia",
            {"-60 m]": "-60 m], inertia: [1.62e9 kg m2, 1.62e9 kg m2, 0]"},
            2 * pi * sqrt((60 + 60.0) / G),
        ),
        (
            "actor: a spring on the joint",
            {"0.01 deg}": "0.01 deg}\n  springs: {coil: {joint: pivot, stiffness: 794.33865 MN m/rad}}"},
            2 * pi * sqrt(60 / (4 * G)),
        ),
        (
            "joint: a sliding one, on a spring",
            {
                "type: revolute": "type: prismatic",
                "0.01 deg}": "1 mm}\n  springs: {coil: {joint: pivot, stiffness: 450 kN/m}}",
            },
            2 * pi,
        ),
    ],
)
def test_changed_data_of_one_element_change_the_pendulum_period_as_the_closed_form_predicts(
    tmp_path: Path, atomic: str, change: dict[str, str], period: float
) -> None:
    text = PENDULUM
    for old, new in change.items():
        assert old in text, atomic
        text = text.replace(old, new)

    assert 2 * half_period(play(tmp_path, text)) == pytest.approx(period, rel=SAME)
