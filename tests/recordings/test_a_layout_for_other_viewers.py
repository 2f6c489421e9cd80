"""The layout that comes with a recording: everything that its panels name is in the recording."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from heavylift.coordinator.run import run
from heavylift.nodes.scene import load
from heavylift.recordings import Recording
from heavylift.recordings.render import LAYOUT


@pytest.fixture(scope="module", params=["lift", "arm"])
def recorded(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Recording:
    path = tmp_path_factory.mktemp("run") / "run.mcap"
    run(load(request.param, ["end=1 s"]), path, in_process=True)
    return Recording(path)


@pytest.fixture
def attached(recorded: Recording) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(recorded.attachments[LAYOUT])
    return found


def leaves(tree: Any) -> list[str]:
    """The panels of a tree of splits."""
    return [tree] if isinstance(tree, str) else [*leaves(tree["first"]), *leaves(tree["second"])]


def test_the_layout_for_other_viewers_describes_every_panel(attached: dict[str, Any]) -> None:
    panels = leaves(attached["layout"])
    assert panels == ["3D!scene", "Plot!tension", "StateTransitions!stages", "RosOut!log"]
    assert set(panels) == set(attached["configById"])
    assert set(attached) == {"configById", "globalVariables", "userNodes", "playbackConfig", "layout"}


def test_the_layout_for_other_viewers_uses_the_world_frame_and_the_recorded_topics(
    recorded: Recording, attached: dict[str, Any]
) -> None:
    scene = attached["configById"]["3D!scene"]
    assert scene["fixedFrame"] == scene["followTf"] == "world"
    for topic, shown in scene["topics"].items():
        assert shown == {"visible": True}
        assert recorded.topics[topic].schema == "foxglove.SceneUpdate"
    assert recorded.topics["/poses"].schema == "foxglove.FrameTransforms"
    assert attached["configById"]["RosOut!log"]["topicToRender"] in recorded.topics


def test_each_curve_of_the_plot_for_lichtblick_shows_the_rope_that_its_label_names(
    recorded: Recording, attached: dict[str, Any]
) -> None:
    paths = attached["configById"]["Plot!tension"]["paths"]
    if "rope/tension" not in recorded.signals():
        assert paths == []
        return
    fields = json.loads(recorded.topics["/samples"].metadata["signals"])
    columns = next(f["columns"] for f in fields if f["field"] == "rope_tension")
    for path in paths:
        found = re.fullmatch(r"/samples\.rope_tension\[(\d+)\]", path["value"])
        assert found
        assert path["label"] == f"{columns[int(found[1])]} [N]"
    assert len(paths) == len(columns)
    (stage,) = attached["configById"]["StateTransitions!stages"]["paths"]
    topic, _, field = stage["value"].partition(".")
    assert topic in recorded.topics
    assert field == "value.name"


def test_the_layout_command_writes_the_layout_file_that_lichtblick_can_import(
    recorded: Recording, tmp_path: Path
) -> None:
    heavylift = Path(sys.executable).parent / "heavylift"
    out = tmp_path / "here.json"
    done = subprocess.run([heavylift, "layout", recorded.path, "-o", out], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0
    assert out.read_bytes() == recorded.attachments[LAYOUT]
    before = recorded.path.read_bytes()
    done = subprocess.run([heavylift, "layout", recorded.path, "-o", recorded.path], capture_output=True, text=True)
    assert (
        done.stderr == f"heavylift: {recorded.path}: the file name of a layout must end in .json; choose such a name\n"
    )
    assert recorded.path.read_bytes() == before
