"""Bundled scenes with other actions, and the errors of invalid orders."""

from __future__ import annotations

import pytest
from heavylift.kernel import SceneError
from heavylift.nodes.scene import LoadedScene, parse


def scene(base: str, *actions: str, more: str = "") -> LoadedScene:
    listed = "".join(f"  - {action}\n" for action in actions)
    return parse(f"extends: {base}\nname: made\n{more}actions:\n{listed}", "scene.yaml", passing=True)


def assert_refused(base: str, order: str, message: str) -> None:
    with pytest.raises(SceneError) as error:
        scene(base, order)
    assert message in str(error.value)
    assert "scene.yaml:4:" in str(error.value)
