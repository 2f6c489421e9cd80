"""Every face that takes a file takes its name as text or as a path; anything else is refused in one sentence."""

from collections.abc import Callable
from pathlib import Path

import pytest
from heavylift.coordinator.participants import paused
from heavylift.coordinator.run import Beginning, run
from heavylift.kernel import RecordingError, SceneError
from heavylift.nodes.scene import LoadedScene, check, load, loaded, parse
from heavylift.recordings import (
    Recorder,
    Recording,
    compare,
    curves,
    export,
    info,
    info_data,
    plot,
    recover,
    report,
    storyboard,
    view,
)

TEXT = """heavylift: 1
name: pendulum
end: 0.1 s
mechanism:
  bodies: {bob: {mass: 1 kg, com: [0 m, 0 m, -1 m]}}
  joints: {hinge: {type: revolute, child: bob, axis: [0, 1, 0]}}
"""
NO_FILES = [None, 5, 1.5, b"run.mcap", ["run.mcap"], object]
READERS: dict[str, Callable[[object], object]] = {
    "Recording": lambda p: Recording(p),
    "info": lambda p: info(p),
    "info_data": lambda p: info_data(p),
    "compare": lambda p: compare(p, p),
    "plot": lambda p: plot(p, "run.png"),
    "view": lambda p: view(p, "run.html"),
    "report": lambda p: report(p, "run.html"),
    "storyboard": lambda p: storyboard(p, "run.png"),
    "curves": lambda p: curves(p, ["*"], "run.png"),
    "export": lambda p: export(p, "run.csv"),
    "recover": lambda p: recover(p),
    "Beginning": lambda p: Beginning.of(p),
    "Recorder": lambda p: Recorder(p, {}),
    "run": lambda p: run(parse(TEXT), p, in_process=True),
}


@pytest.mark.parametrize("kind", [str, Path])
def test_recordings_and_scenes_can_be_named_by_a_string_or_a_path_object(kind: type, tmp_path: Path) -> None:
    (tmp_path / "pendulum.yaml").write_text(TEXT)
    scene, out = kind(tmp_path / "pendulum.yaml"), kind(tmp_path / "out.mcap")
    assert isinstance(loaded(scene), LoadedScene)
    run(load(scene), out, in_process=True)
    first = Recording(out)
    assert first.result["digest"] == Recording(Path(out)).result["digest"]
    second = run(scene, out, in_process=True).recording
    assert second == tmp_path / "out-2.mcap"
    assert Recording(second).result["digest"] == first.result["digest"]
    assert paused(scene).epoch == 0
    assert info(out).startswith(str(out))


@pytest.mark.parametrize("name", READERS)
@pytest.mark.parametrize("no_file", NO_FILES, ids=repr)
def test_an_argument_that_is_not_a_file_name_is_refused(
    name: str, no_file: object, tmp_path: Path, monkeypatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(RecordingError) as e:
        READERS[name](no_file)
    assert str(e.value) == f"{no_file!r} is not a file name; give a path as text or as a Path, such as 'run.mcap'"
    assert not any(tmp_path.iterdir())


@pytest.mark.parametrize("no_scene", [None, 5, b"lift", {"heavylift": 1}], ids=repr)
@pytest.mark.parametrize("face", [loaded, check, paused, lambda x: run(x, "x.mcap", in_process=True)])
def test_a_file_that_is_not_a_scene_is_refused(face: Callable[[object], object], no_scene: object) -> None:
    with pytest.raises(SceneError) as e:
        face(no_scene)
    assert str(e.value) == (
        f"{no_scene!r} is not a scene; give its path, the name of a bundled scene, or the result of `load`"
    )
